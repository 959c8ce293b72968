"""A patch scan that never took place: camera frames, histograms with and without the patch, and the truth."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from calibrate.plan import ScanPlan
from calibrate.simulated.bench import Bench
from calibrate.simulated.frames import FrameRenderer, Mishaps, encode_jpeg
from calibrate.simulated.light import Light
from physics.optics import Optics, tmf882x_optics
from physics.photons import draw_counts
from physics.timing import LASER_HZ, Timing, tmf882x_timing
from recordings.refusal import Refusal
from recordings.stream import Stream

BATCH_FRAMES = 64
# Between captures the arm moves and settles; between the two passes the patch is taken off.
SETTLING_S, CHANGE_S = 0.5, 600.0


@dataclass(frozen=True, eq=False)
class ScanTruth:
    """What a calibration of the scan should find, for K cells in the plan's order and P zones.

    centres_px: (K, 2) patch centres in the image. positions_m: (K, 3) in the camera's frame.
    radius_px: (K,) radius of the patch's image.
    points: (P, K) photons per frame, all bins, were the patch shrunk to its centre and no dimmer.
    blurred: (P, K) photons per frame, all bins, from the whole patch: integrated over its disc.
    window: first and last bin, both included, of the patch's pulses.
    """

    centres_px: np.ndarray
    positions_m: np.ndarray
    radius_px: np.ndarray
    points: np.ndarray
    blurred: np.ndarray
    window: tuple[int, int]


@dataclass(frozen=True, eq=False)
class SimulatedScan:
    """The two passes, each to be run through once, and the truth behind them."""

    patch: Stream
    background: Stream
    truth: ScanTruth


def simulate_scan(
    plan: ScanPlan,
    *,
    rng: np.random.Generator,
    mode: str = "long",
    patch_range_m: float | None = None,
    bench: Bench | None = None,
    optics: Optics | None = None,
    signal: float = 0.7,
    laser_cycles: int = 4000 * 1024,
    gain_noise: float = 0.003,
    ambient_per_ns: float = 1e-4,
    with_images: bool = True,
    image_noise: float = 1.0,
    mishaps: Mishaps | None = None,
) -> SimulatedScan:
    """Simulate both passes of a patch scan; the same state of `rng` gives the same scan.

    mode: "long" or "short" range. patch_range_m: depth of the scan's plane, the bench's where None.
    bench: camera, mount and grid. optics: the sensor, one TMF8828 in map 6 where None, always the same.
    signal: photons per laser shot, in long mode, from a 17.4 mm patch at 0.6 m where the response is 1.
    laser_cycles: shots per frame. gain_noise: relative standard deviation of the laser's energy by frame.
    ambient_per_ns: ambient and dark counts per shot and nanosecond in a zone of 20 SPADs.
    with_images: whether frames of the patch pass carry `rgb` (JPEG). image_noise: scales the camera's noise.
    mishaps: frames in which the patch is missing, occluded or under glare.

    Counts are Poisson around energy · (patch + scene + crosstalk) + ambient; nothing saturates. The arm stops
    at the same positions in both passes. Raises `Refusal` for numbers that make no scan.
    """
    _check(signal=signal, gain_noise=gain_noise, ambient_per_ns=ambient_per_ns, image_noise=image_noise)
    if isinstance(laser_cycles, bool) or not isinstance(laser_cycles, int | np.integer) or laser_cycles < 1:
        raise Refusal(f"simulated scan: laser_cycles is {laser_cycles!r}, expected an integer of 1 or more")
    bench = bench or Bench()
    bench = bench if patch_range_m is None else bench.at_range(patch_range_m)
    optics = optics or tmf882x_optics(6, np.random.default_rng(0))
    timing = tmf882x_timing(mode, len(optics.spads.masks))
    mishaps = mishaps or Mishaps()
    mishaps.check(plan.count)
    arm_rng, patch_rng, background_rng, plate_rng, camera_rng = rng.spawn(5)

    positions = bench.patch_positions(plan, arm_rng)
    light = Light(bench, optics, timing, signal, laser_cycles, ambient_per_ns)
    blurred = light.discs(positions)
    truth = ScanTruth(
        centres_px=bench.project(positions),
        positions_m=positions,
        radius_px=bench.focal_px * bench.patch_radius_m / positions[:, 2],
        points=light.points(positions),
        blurred=blurred,
        window=light.window(positions, blurred),
    )
    # Before the grid the arm waits at the first cell.
    cells = np.maximum(np.arange(plan.count) - plan.first, 0) // plan.repeats
    lit = blurred[:, cells].T
    lit[list(mishaps.missing)] = 0
    period_s = laser_cycles / LASER_HZ + SETTLING_S
    times = period_s * np.arange(plan.count)

    def one_pass(name: str, photons: np.ndarray, start_s: float, draws: np.random.Generator) -> Stream:
        frames = _captures(light, positions[cells], photons, start_s + times, gain_noise, draws)
        if with_images and name == "patch":
            renderer = FrameRenderer(bench, plate_rng, image_noise)
            frames = _pictured(frames, renderer, positions[cells], mishaps, camera_rng)
        static = _static(bench, optics, timing) | {
            "laser_cycles": np.int64(laser_cycles),
            "meta_json": json.dumps(_meta(name, plan, bench, optics, mode)),
        }
        return Stream(static=static, frames=frames, count=plan.count)

    return SimulatedScan(
        patch=one_pass("patch", lit, 0.0, patch_rng),
        background=one_pass("background", np.zeros_like(lit), times[-1] + CHANGE_S, background_rng),
        truth=truth,
    )


def _captures(
    light: Light,
    positions_m: np.ndarray,
    photons: np.ndarray,
    times_s: np.ndarray,
    gain_noise: float,
    rng: np.random.Generator,
) -> Iterator[dict[str, Any]]:
    """Frames with `counts` and `timestamp_s`, at positions (F, 3) with (F, P) photons of the patch."""
    for start in range(0, len(times_s), BATCH_FRAMES):
        batch = slice(start, start + BATCH_FRAMES)
        energy = np.maximum(1 + gain_noise * rng.standard_normal(len(times_s[batch])), 0)
        counts = draw_counts(light.expected(positions_m[batch], photons[batch], energy), rng)
        for histogram, time_s in zip(counts, times_s[batch], strict=True):
            yield {"counts": histogram, "timestamp_s": float(time_s)}


def _pictured(
    frames: Iterator[dict[str, Any]],
    renderer: FrameRenderer,
    positions_m: np.ndarray,
    mishaps: Mishaps,
    rng: np.random.Generator,
) -> Iterator[dict[str, Any]]:
    """The same frames with `rgb`, JPEG bytes."""
    for index, frame in enumerate(frames):
        yield frame | {"rgb": encode_jpeg(renderer.render(positions_m[index], index, rng, mishaps))}


def _static(bench: Bench, optics: Optics, timing: Timing) -> dict[str, Any]:
    """Fields of the recording that are the same in every frame and both passes."""
    return {
        "zone_grid": np.array(optics.zone_grid),
        "bin_width_s": np.float64(timing.bin_width_s),
        "time_zero_s": timing.time_zero_s,
        "irf_time_s": timing.pulse.time_s,
        "irf": timing.pulse.probability,
        "intrinsics": bench.intrinsics,
        "image_size": np.array(bench.image_size),
        "lidar_from_camera": bench.lidar_from_camera,
    }


def _meta(name: str, plan: ScanPlan, bench: Bench, optics: Optics, mode: str) -> dict[str, Any]:
    """What the recording says about itself, under the published names where there are such."""
    rows, columns = optics.zone_grid
    return {
        "sensor": "TMF8828",
        "made_by": "simulated patch scan",
        "scan_pass": name,
        "mode": f"{rows}x{columns}",
        "ranging": f"{mode}range",
        "patch_depth_m": bench.patch_range_m,
        "patch_radius_m": bench.patch_radius_m,
        **plan.to_meta(),
    }


def _check(**numbers: float) -> None:
    """Refuse a number that is negative or not finite."""
    for name, value in numbers.items():
        if not (np.isfinite(value) and value >= 0):
            raise Refusal(f"simulated scan: {name} is {value!r}, expected a finite number of 0 or more")
