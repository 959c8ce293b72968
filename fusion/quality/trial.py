"""RGB-D frames, recorded through maps photon by photon, with a reflectance that colour does not tell."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fusion.depths import zone_depths
from fusion.peaks import peak_ranges
from fusion.range_response import RangeResponse, range_response
from fusion.sight import Sight, sight
from fusion.zone_view import ZoneDepths
from physics.effects import find_effect
from physics.footprint import footprints
from physics.nominal import ForwardModel
from physics.presets import preset
from physics.scene.open_scene import open_scene
from physics.scene.view import View
from physics.sensor import SensorModel
from physics.simulate import light_of
from physics.single_photons.engine import photon_counts
from recordings.encoded import decoded
from recordings.maps import ResponseMaps

# Counts of signal in the fullest bin of the first frame, before the sensor's effects.
PEAK = 4000.0
# Of the near infrared reflectance of regions of like colour over what colour says: standard deviation of the logarithm.
REFLECTANCE_SPREAD, COLOURS = 0.5, 12
DARKEST = 0.02
# Effects that the sensor has and its model knows, at values that are usual.
EFFECTS = ("pile_up", "cover_glass_crosstalk", "ambient_pedestal")
# A pixel is judged where a zone responds with this part of its largest response, and the sensor's window reaches it.
SEEN = 0.1


@dataclass(frozen=True, eq=False)
class Trial:
    """F frames to be judged by. depth_m: (F, H, W), NaN where nothing is known or beyond the sensor's window.

    depths: of each frame. range_m: (F, P) strongest peaks. seen: (H, W) pixels that any zone sees.
    """

    name: str
    sight: Sight
    response: RangeResponse
    counts: np.ndarray
    depths: tuple[ZoneDepths, ...]
    range_m: np.ndarray
    rgb: tuple[np.ndarray, ...]
    depth_m: np.ndarray
    poses: tuple[np.ndarray | None, ...]

    @property
    def seen(self) -> np.ndarray:
        """(H, W) bool."""
        return (self.sight.normalised > SEEN).any(axis=0)


def record_trial(folder: Path, maps: ResponseMaps, rng: np.random.Generator) -> Trial:
    """An RGB-D folder seen by a TMF8828 in the mode of the maps' long range, drawn with `rng`."""
    scene = open_scene(folder, maps)
    views = list(scene.views)
    shape = views[0].depth_m.shape
    rgb = tuple(decoded(v.rgb, shape, "rgb") if isinstance(v.rgb, bytes) else v.rgb for v in views)
    altered = [painted(view, image, rng) for view, image in zip(views, rgb, strict=True)]
    plain = preset("tmf8828-3x3-wide-long")
    light = light_of(altered, scene.intrinsics, plain, views[0].timestamp_s)
    strongest = ForwardModel(light, footprints(maps, shape), plain.clock).expected()[0].max()
    sensor: SensorModel = replace(plain, effects=tuple(find_effect(name).at() for name in EFFECTS))
    counts = photon_counts(replace(scene, views=iter(altered)), maps, sensor, rng, PEAK / float(strongest))
    response = range_response(sensor)
    truth = np.stack([view.depth_m for view in views]).astype(float)
    return Trial(
        folder.name,
        sight(maps, shape, scene.intrinsics),
        response,
        counts,
        tuple(zone_depths(frame, response) for frame in counts),
        # Crosstalk is known and is taken off first: its peak would be the strongest of many a zone.
        peak_ranges(np.maximum(counts - response.pedestal, 0) + response.flat[:, None], sensor),
        rgb,
        np.where(truth < response.range_m[-1], truth, np.nan),
        tuple(view.camera_pose for view in views),
    )


def painted(view: View, rgb: np.ndarray, rng: np.random.Generator) -> View:
    """The view with reflectance changed by one random factor for each of its dominant colours."""
    pixels = rgb.reshape(-1, 3).astype(np.float32)
    chosen = pixels[rng.choice(len(pixels), min(len(pixels), 8192), replace=False)]
    centres = chosen[rng.choice(len(chosen), COLOURS, replace=False)]
    for _ in range(10):
        nearest = _nearest(chosen, centres)
        for k in range(COLOURS):
            if (nearest == k).any():
                centres[k] = chosen[nearest == k].mean(axis=0)
    factors = np.exp(REFLECTANCE_SPREAD * rng.normal(size=COLOURS))
    changed = np.asarray(view.reflectance, float) * factors[_nearest(pixels, centres)].reshape(rgb.shape[:2])
    return replace(view, reflectance=np.clip(changed, DARKEST, 1))


def _nearest(pixels: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """(N,) index of the nearest of the centres by Euclidean distance."""
    # |p|² is the same for all centres of a pixel.
    return np.argmin(np.square(centres).sum(axis=1) - 2 * pixels @ centres.T, axis=1)
