"""What a sensor would have recorded of known depth, if its zones looked elsewhere than the maps say."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import speed_of_light

from physics.clock import Clock
from physics.footprint import Footprints, footprints
from physics.geometry import full_size_pixels
from physics.light import Light, Return, direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.scene.material import reflectance_of_colour
from physics.sensor import SensorModel
from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal

# Footprints are far wider than a pixel of a grid of this width.
WIDTH_PX = 240
# Frames beyond these add little but time.
MOST_FRAMES = 6
# A pulse has begun when this part of it has come; the nearest surface is nearer than all but this part of pixels.
NEGLIGIBLE, NEAREST = 1e-3, 1e-3
# Light of the sensor's own cover is over when all but this part of a pulse from no distance has come.
COVER = 0.02
# The clock of a zone may be late or early by as many bins.
SPARE_BINS = 3
# Frames closer than this, mean relative difference of depth, are one and the same to a comparison.
DISTINCT = 0.02


@dataclass(frozen=True, eq=False)
class Bench:
    """Some frames of a recording whose depth is known, on a coarse grid, to be seen through any footprints.

    counts: (F, P, T) as recorded. reached: (F, P, T) bool, bins that light of the nearest surface and later can reach:
    what comes before is crosstalk of the sensor's own cover, and says nothing of where zones look. light: what the
    scene sends back. where: the maps' footprints on the same grid. frames: (F,) which of the recording's frames these
    are. grid: (H, W) of the camera. at: which of its pixels these are. gain: counts per unit of light.
    """

    counts: np.ndarray
    reached: np.ndarray
    light: Light
    where: Footprints
    sensor: SensorModel
    frames: np.ndarray
    grid: tuple[int, int]
    at: tuple[slice, slice]
    gain: float = 1.0

    @property
    def clock(self) -> Clock:
        """The sensor's."""
        return self.sensor.clock

    def signal(self, where: Footprints, light: Light | None = None) -> np.ndarray:
        """(F, P, T) expected counts less background, seen through other footprints, or of other light."""
        level = self.sensor.background_counts
        model = ForwardModel(self.light if light is None else light, where, self.clock, level)
        return np.maximum(model.expected(self.gain, self.sensor.effects) - level[:, None], 0)

    def through(self, maps: ResponseMaps) -> "Bench":
        """The same frames, to be seen through other maps."""
        known = self.where.calibration_range_m
        return replace(self, where=_where(maps, self.grid, self.at, known if np.isfinite(known) else None))

    def relit(self, factor: np.ndarray) -> Light:
        """The light where every pixel sends `factor` (F, H, W) times as much."""
        ways = tuple(Return(way.range_m, (way.strength * factor).astype(np.float32)) for way in self.light.returns)
        return replace(self.light, returns=ways)


def bench(recording: Recording, maps: ResponseMaps, sensor: SensorModel) -> Bench:
    """The frames to compare, of a recording with depth; refuses one sentence where there is nothing to compare."""
    for name in ("depth_m", "intrinsics"):
        if getattr(recording, name) is None:
            raise Refusal(f"{name} is missing in the recording, expected a camera with depth to check maps against")
    zones, bins = recording.counts.shape[1:]
    for whose, grid in (("response maps have", maps.zone_grid), ("sensor has", sensor.zone_grid)):
        if grid[0] * grid[1] != zones:
            raise Refusal(f"the {whose} {grid[0]} x {grid[1]} zones, expected {zones} as recorded")
    if sensor.bins != bins:
        raise Refusal(f"the sensor has {sensor.bins} bins, expected {bins} as recorded")
    frames = _distinct(recording)
    depth = np.stack([_image(recording.depth_m, i) for i in frames]).astype(np.float32)
    albedo = _albedo(recording, frames)
    cosine = None
    if recording.incidence_cosine is not None:
        cosine = np.stack([_image(recording.incidence_cosine, i) for i in frames])
    # Drifts go with the session's clock, echoes of what stands still with the camera's motion.
    times = np.asarray(recording.timestamp_s, float) - float(recording.timestamp_s[0])
    motion = None if recording.camera_pose is None else Motion.of(times, recording.camera_pose)
    light = direct_light(
        depth,
        recording.intrinsics,
        albedo,
        cosine,
        time_s=times[frames],
        laser_cycles=sensor.laser_cycles,
        motion=motion,
    )
    # Every so many pixels, each at its own place: means of depth would be on no surface at edges.
    step = max(1, round(depth.shape[2] / WIDTH_PX))
    at = (slice(step // 2, None, step),) * 2
    ways = tuple(Return(_every(way.range_m, at), _every(way.strength, at)) for way in light.returns)
    seen = {name: _every(getattr(light, name), at) for name in ("range_m", "reflectance", "cosine")}
    light = replace(light, returns=ways, intrinsics=_every_pixel(light.intrinsics, step), **seen)
    where = _where(maps, depth.shape[1:], at, recording.meta.get("calibration_range_m"))
    counts = np.stack([recording.counts[i] for i in frames]).astype(float)
    reached = _reached(light, sensor, counts.shape)
    made = Bench(counts, reached, light, where, sensor, frames, depth.shape[1:], at)
    expected = (made.signal(where) * reached).sum()
    level = (sensor.background_counts[:, None] * reached).sum()
    if not expected > 0:
        raise Refusal("no light of any frame would fall into the histograms, expected depth within the sensor's window")
    return replace(made, gain=max(float((counts * reached).sum() - level), 1.0) / float(expected))


def _where(
    maps: ResponseMaps, grid: tuple[int, int], at: tuple[slice, slice], calibration_range_m: float | None
) -> Footprints:
    """Footprints on some pixels of a grid. calibration_range_m: where the maps do not say."""
    x, y = (np.ascontiguousarray(a[at]) for a in full_size_pixels(grid, maps.image_size))
    coarse = footprints(maps, x.shape, calibration_range_m)
    return coarse if x.shape == grid else coarse.read_at(x, y)


def _every_pixel(intrinsics: np.ndarray, step: int) -> np.ndarray:
    """(3, 3) pinhole matrix of every `step`th pixel, the first in the middle of as many."""
    taken = np.array(intrinsics, float)
    taken[:2] /= step
    taken[:2, 2] -= step // 2 / step
    return taken


def _every(images: np.ndarray, at: tuple[slice, slice]) -> np.ndarray:
    """(F, h, w) some of the pixels, in memory of their own."""
    return np.ascontiguousarray(images[(slice(None), *at)])


def _image(images, i: int) -> np.ndarray:
    """Frame i of (F, H, W), or the one image (H, W) there is."""
    return np.asarray(images) if images.ndim == 2 else np.asarray(images[i])


def _reached(light: Light, sensor: SensorModel, shape: tuple[int, int, int]) -> np.ndarray:
    """(F, P, T) bool, bins that the pulse reaches from the nearest surface in view, and those after them."""
    clock, pulse = sensor.clock, sensor.clock.pulse
    begins_s = np.interp(NEGLIGIBLE, pulse.edge_cumulative, pulse.edges)
    over_s, spare_s = np.interp(1 - COVER, pulse.edge_cumulative, pulse.edges), SPARE_BINS * clock.bin_width_s
    direct, first = light.returns[0], np.zeros(shape[:2])
    for i, (ranges, strength) in enumerate(zip(direct.range_m, direct.strength, strict=True)):
        lit = ranges[strength > 0]
        travel_s = 2 * float(np.quantile(lit, NEAREST)) / speed_of_light if lit.size else 0.0
        first[i] = (clock.time_zero_s + np.maximum(travel_s + begins_s - spare_s, over_s)) / clock.bin_width_s
    return np.arange(shape[2]) >= np.floor(first)[..., None]


def _albedo(recording: Recording, frames: np.ndarray) -> np.ndarray | None:
    """(F, H, W) reflectance as recorded, else guessed from colour, else None."""
    if recording.reflectance is not None:
        return np.stack([_image(recording.reflectance, i) for i in frames])
    rgb = recording.rgb
    shape = None if rgb is None else np.asarray(rgb[0]).shape
    if shape is None or len(shape) != 3 or shape[:2] != _image(recording.depth_m, 0).shape:
        return None
    return np.stack([reflectance_of_colour(np.asarray(rgb[i])) for i in frames])


def _distinct(recording: Recording) -> np.ndarray:
    """Frames that differ in depth from one another, spread over the recording, MOST_FRAMES at most."""
    count = len(recording.counts)
    spread = np.unique(np.linspace(0, count - 1, min(count, 2 * MOST_FRAMES)).round().astype(int))
    usable = [i for i in spread if recording.counts[i].any() and (_image(recording.depth_m, i) > 0).any()]
    if not usable:
        raise Refusal("no frame has both counts and depth, expected at least one")
    kept, images = [], []
    for i in usable:
        image = _image(recording.depth_m, i)[::8, ::8].astype(float)
        if all(_difference(image, other) > DISTINCT for other in images):
            kept.append(i)
            images.append(image)
    at = np.linspace(0, len(kept) - 1, min(len(kept), MOST_FRAMES)).round().astype(int)
    return np.array(kept)[at]


def _difference(one: np.ndarray, other: np.ndarray) -> float:
    """Mean relative difference of two depth images where both are known; that they are known counts, too."""
    both = (one > 0) & (other > 0)
    either = (one > 0) | (other > 0)
    apart = np.abs(np.log(one[both] / other[both])).sum() + (either & ~both).sum()
    return float(apart / max(either.sum(), 1))
