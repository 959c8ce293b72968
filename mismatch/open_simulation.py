"""A recording, where its zones look, and how its sensor counts, become a simulation to compare it with."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from mismatch.blocks import halves
from mismatch.clock_slopes import loosened
from mismatch.estimated_sensor import estimated_sensor, likeliest_pedestal, quiet_pedestal
from mismatch.fit import fit_nominal
from mismatch.likelier_response import likelier_clock
from mismatch.simulation import Simulation
from physics.footprint import Footprints, footprints
from physics.geometry import incidence_cosine_across_edges
from physics.light import Light, direct_light
from physics.motion import Motion
from physics.sensor import SensorModel
from physics.sensor_file import load_sensor
from recordings.files import kind_of, load, maps_of
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps
from recordings.recording import Recording
from recordings.refusal import Refusal

# Footprints are smooth: a grid of about so many pixels shows all that histograms can tell.
ENOUGH_PIXELS = 40_000
ENOUGH_FRAMES = 512
OWN_PEDESTAL = "The pedestal is estimated from this recording: lamps are the scene's, not the sensor's."


def open_simulation(
    path: Path,
    maps_path: Path | None = None,
    sensor_path: Path | None = None,
    mesh: Path | None = None,
    zones: Path | None = None,
) -> tuple[Simulation, SensorModel, tuple[str, ...]]:
    """The simulation beside the recording in a file, the sensor it assumes, and what was assumed, in sentences.

    mesh, zones: of published data that have these in files of their own; else they are looked for beside the recording.
    """
    if mesh is None and zones is None:
        recording, maps = load(path), None if maps_path else maps_of(path)
    else:
        kind = kind_of(path)
        if not hasattr(kind, "maps"):
            raise Refusal(f"{path}: brings its own geometry, expected published data with {mesh or zones} beside it")
        recording, maps = kind.stream(path, mesh, zones).collect(), kind.maps(path, zones)
    maps = maps if maps_path is None else load_maps(maps_path)
    if maps is None:
        raise Refusal(f"{path}: carries no response maps, expected them by --calibration MAPS.npz")
    sensor = None if sensor_path is None else load_sensor(sensor_path)
    return simulation_of(recording, maps, sensor, str(path))


def simulation_of(
    recording: Recording, maps: ResponseMaps, sensor: SensorModel | None = None, name: str = "recording"
) -> tuple[Simulation, SensorModel, tuple[str, ...]]:
    """The same from a recording and maps at hand."""
    # Matrices are slim; threads for them would wait on those that render.
    with threadpool_limits(1, user_api="blas"):
        return _simulation_of(recording, maps, sensor, name)


def _simulation_of(
    recording: Recording, maps: ResponseMaps, sensor: SensorModel | None, name: str
) -> tuple[Simulation, SensorModel, tuple[str, ...]]:
    """See `simulation_of`."""
    counts = np.asarray(recording.counts)
    frames, zones, bins = counts.shape
    if frames < 2:
        raise Refusal(f"{name}: has {frames} frame, expected 2 or more: some to choose a model, others to judge it")
    if recording.depth_m is None or recording.intrinsics is None:
        lacking = "depth_m" if recording.depth_m is None else "intrinsics"
        raise Refusal(f"{name}: {lacking} is missing, expected the geometry that the sensor saw")
    if tuple(maps.zone_grid) != tuple(int(n) for n in recording.zone_grid):
        here, there = (" x ".join(str(int(n)) for n in grid) for grid in (recording.zone_grid, maps.zone_grid))
        raise Refusal(f"{name}: has {here} zones but the response maps {there}, expected the same")
    if not counts.any():
        raise Refusal(f"{name}: counts are 0 in every frame, zone and bin, expected photons")
    notes: list[str] = []
    every = max(1, -(-frames // ENOUGH_FRAMES))
    if every > 1:
        notes.append(f"Every {every}th of {frames} frames was compared.")
    chosen = np.arange(0, frames, every)
    estimated = sensor is None and recording.irf is None
    if estimated:
        sensor, sentence = estimated_sensor(recording, maps)
        notes.append(sentence)
    if sensor is None:
        sensor = SensorModel.of(recording)
    if sensor.zones != zones or sensor.bins != bins:
        found = f"{sensor.zones} zones and {sensor.bins} bins"
        raise Refusal(f"{name}: has {zones} zones and {bins} bins but the sensor {found}, expected the same")
    stride = _stride(np.shape(recording.depth_m)[-2:])
    if stride > 1:
        notes.append(f"Geometry was read at every {stride}th pixel of each row and column.")
    light = _light(recording, chosen, stride, sensor.laser_cycles)
    dead = ~counts.any(axis=(0, 2))
    if dead.any():
        which = ", ".join(str(p) for p in np.flatnonzero(dead))
        notes.append(f"No photon in any frame of zone {which}: it could not be judged and was left out.")
    simulation = Simulation(
        counts[chosen].astype(float), light, _footprints(recording, maps, stride), sensor.clock,
        np.asarray(sensor.background_counts, float), np.arange(len(chosen)), sensor.effects, dead=dead,
        guessed=estimated, timed=estimated and not recording.assumes("time_zero_s"),
    )  # fmt: skip
    if recording.incidence_cosine is None:
        across = _light(recording, chosen, stride, sensor.laser_cycles, across_edges=True)
        simulation, note = _likelier(simulation, replace(simulation, light=across))
        notes += note
    if estimated and recording.background_counts is None:
        simulation = replace(simulation, background=likeliest_pedestal(simulation))
        sensor = replace(sensor, background_counts=simulation.background)
    if not estimated and recording.background_counts is None and sensor.is_estimate("background_counts"):
        simulation = replace(simulation, background=quiet_pedestal(simulation))
        sensor = replace(sensor, background_counts=simulation.background)
        notes.append(OWN_PEDESTAL)
    if estimated:
        clock = likelier_clock(simulation)
        if clock is not simulation.clock:
            simulation = loosened(replace(simulation, clock=clock))
            sensor = replace(sensor, pulse=clock.pulse, time_zero_s=clock.time_zero_s)
    return simulation, sensor, tuple(notes)


def _stride(shape: tuple[int, int]) -> int:
    """Of how many rows and columns one is read."""
    return max(1, int(np.sqrt(shape[0] * shape[1] / ENOUGH_PIXELS)))


def _footprints(recording: Recording, maps: ResponseMaps, stride: int) -> Footprints:
    """Where the zones look, at the pixels that are read."""
    whole = footprints(maps, np.shape(recording.depth_m)[-2:], recording.meta.get("calibration_range_m"))
    if stride == 1:
        return whole
    read = (slice(stride // 2, None, stride),) * 2
    return whole.read_at(whole.x_px[read], whole.y_px[read])


def _likelier(within: Simulation, across: Simulation) -> tuple[Simulation, list[str]]:
    """Of slopes within surfaces and across edges the likelier for frames that choose; and a sentence on it.

    No page says how slopes are told from depth. They differ at edges alone, where they make all the difference.
    """
    if np.array_equal(within.light.returns[0].strength, across.light.returns[0].strength):
        return within, []
    some = halves(len(within.counts))[0]
    if fit_nominal(within.of(some)).deviance <= fit_nominal(across.of(some)).deviance:
        return within, []
    return across, ["Incidence was told from depth across edges as well: that is likelier than within surfaces alone."]


def _light(
    recording: Recording, chosen: np.ndarray, stride: int, shots: int | None, across_edges: bool = False
) -> Light:
    """What the scene sends back in the chosen frames, at the pixels that are read.

    shots: laser shots in a frame of this sensor, where the recording does not say. across_edges: how incidence is told
    from depth where that has to be.
    """
    frames = len(recording.counts)
    first = stride // 2

    def images(name: str) -> np.ndarray | None:
        values = getattr(recording, name)
        if values is None:
            return None
        if np.ndim(values) == 2 or np.shape(values)[0] != frames:
            one = np.asarray(values)[first::stride, first::stride]
            return np.broadcast_to(one, (len(chosen), *one.shape))
        return np.stack([np.asarray(values[int(i)])[first::stride, first::stride] for i in chosen])

    depth = images("depth_m")
    if not np.isfinite(depth).any():
        raise Refusal("depth_m is NaN in every pixel of every frame, expected geometry")
    intrinsics = np.array(recording.intrinsics, float)
    intrinsics[:2] /= stride
    intrinsics[:2, 2] -= first / stride
    cycles = shots if recording.laser_cycles is None else recording.laser_cycles
    if cycles is not None and np.ndim(cycles):
        cycles = np.asarray(cycles)[chosen]
    times = np.asarray(recording.timestamp_s, float)[chosen] - float(recording.timestamp_s[0])
    poses = recording.camera_pose
    motion = None if poses is None else Motion.of(times, np.asarray(poses)[chosen], np.asarray(poses)[0])
    cosine = incidence_cosine_across_edges(depth, intrinsics) if across_edges else images("incidence_cosine")
    return direct_light(
        depth, intrinsics, images("reflectance"), cosine,
        time_s=times, laser_cycles=cycles, motion=motion,
    )  # fmt: skip
