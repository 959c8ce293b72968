"""Camera frames of a patch scan: black cloth, the arm, its flange and the patch."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import cv2
import numpy as np
from scipy.special import ndtr

from calibrate.simulated import arm
from calibrate.simulated.bench import Bench
from calibrate.simulated.cloth import cloth_plates, noise_tile
from recordings.refusal import Refusal

LENS_BLUR_PX = 0.9
FLICKER = 0.006
JPEG_QUALITY = 90
TILE_MARGIN_PX = 192
BAND_PX = 40

PLATE_RGB, SIDE_RGB = np.array([68, 61, 54.0]), np.array([128, 122, 116.0])
RING_RGB, PATCH_RGB = np.array([214, 207, 194.0]), np.array([197, 192, 183.0])
BOLT_RGB = np.array([70, 84, 86.0])
HAND_RGB = np.array([74, 70, 72.0])


@dataclass(frozen=True)
class Mishaps:
    """Frames in which something went wrong, by index; each may hold any number of frames.

    missing: the patch had fallen off. occluded: something dark was between camera and patch.
    glare: a lamp's reflection fell on the patch.
    """

    missing: frozenset[int] = frozenset()
    occluded: frozenset[int] = frozenset()
    glare: frozenset[int] = frozenset()

    def check(self, count: int) -> None:
        """Refuse an index that is no frame of a recording of `count`."""
        for field in fields(self):
            strange = [index for index in getattr(self, field.name) if not 0 <= index < count]
            if strange:
                raise Refusal(f"mishaps: {field.name} has frame {strange[0]}, expected 0 to {count - 1}")


class FrameRenderer:
    """Draws frames for one bench; `noise` scales all that is random, `rng` draws what stays the same."""

    def __init__(self, bench: Bench, rng: np.random.Generator, noise: float = 1.0) -> None:
        self.bench, self.noise = bench, noise
        width, height = bench.image_size
        self._plates = cloth_plates(height, width, rng, noise)
        self._tile = noise_tile(height + TILE_MARGIN_PX, width + TILE_MARGIN_PX, rng, noise)
        self._arm, self._uncovered = arm.arm_picture()

    def render(
        self, centre_m: np.ndarray, frame: int, rng: np.random.Generator, mishaps: Mishaps = Mishaps()
    ) -> np.ndarray:
        """(H, W, 3) uint8 RGB with the patch's centre at (3,) metres in the camera's frame."""
        image = self._plates[rng.integers(len(self._plates))].copy()
        scale = self.bench.focal_px / centre_m[2]
        centre = self.bench.project(centre_m)
        self._draw_arm(image, centre, scale, arm.arm_direction(self.bench, centre_m))
        self._draw_flange(image, centre, scale, frame not in mishaps.missing)
        if frame in mishaps.occluded:
            offset = rng.uniform(-0.3, 0.3, 2) * self.bench.patch_radius_m
            _lay(image, centre + offset * scale, 1.6 * self.bench.patch_radius_m * scale, HAND_RGB, 4.0)
        if frame in mishaps.glare:
            heading = rng.uniform(0, 2 * np.pi)
            away = 0.8 * self.bench.patch_radius_m * scale * np.array([np.cos(heading), np.sin(heading)])
            _glare(image, centre + away, self.bench.patch_radius_m * scale)
        return self._expose(image, rng)

    def _draw_arm(self, image: np.ndarray, centre: np.ndarray, scale: float, direction: np.ndarray) -> None:
        """Lay the arm's picture over the image, turned so that it leaves in `direction`."""
        cos, sin = direction
        zoom = scale / arm.PICTURE_PX_PER_M
        rotation = zoom * np.array([[cos, -sin], [sin, cos]])
        origin = arm.HALF_PICTURE_M * arm.PICTURE_PX_PER_M - 0.5
        back = np.linalg.inv(rotation)
        height, width = self._arm.shape[:2]
        box = np.array([[0, 0], [width, 0], [width, height], [0, height]])
        corners = (box - origin) @ rotation.T + centre
        for top, bottom, left, right in _bands(corners, *image.shape[:2]):
            inverse = np.column_stack([back, back @ ((left, top) - centre) + origin])
            size, how = (right - left, bottom - top), cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            drawn = cv2.warpAffine(self._arm, inverse, size, flags=how)
            uncovered = cv2.warpAffine(self._uncovered, inverse, size, flags=how, borderValue=(255, 255, 255))
            behind = image[top:bottom, left:right]
            image[top:bottom, left:right] = cv2.add(cv2.multiply(behind, uncovered, scale=1 / 255), drawn)

    def _draw_flange(self, image: np.ndarray, centre: np.ndarray, scale: float, with_patch: bool) -> None:
        """Flange, its dark plate with four bolts, and the patch in its middle."""
        _lay(image, centre + np.array([0.4, 1.2]), (arm.FLANGE_M + 0.0006) * scale, SIDE_RGB)
        _lay(image, centre, arm.FLANGE_M * scale, RING_RGB, shading=(0.12, -0.1))
        _lay(image, centre, arm.PLATE_M * scale, PLATE_RGB, shading=(0.1, 0.04))
        for angle in arm.BOLT_ANGLES:
            at = centre + arm.BOLT_CIRCLE_M * scale * np.array([np.cos(angle), np.sin(angle)])
            _lay(image, at, arm.BOLT_M * scale, BOLT_RGB)
            _lay(image, at, 0.55 * arm.BOLT_M * scale, 0.5 * PLATE_RGB)
        if with_patch:
            _lay(image, centre, self.bench.patch_radius_m * scale, PATCH_RGB, shading=(-0.04, -0.04))

    def _expose(self, image: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Flicker of the exposure, and noise: a window at a random place of a larger tile."""
        y, x = rng.integers(0, TILE_MARGIN_PX, 2)
        height, width = image.shape[:2]
        gain = 1 + self.noise * FLICKER * rng.normal()
        return cv2.addWeighted(image, gain, self._tile[y : y + height, x : x + width], 1, -128)


def _bands(corners: np.ndarray, height: int, width: int) -> Iterator[tuple[int, int, int, int]]:
    """Top, bottom, left and right of crops that cover a convex outline (4, 2), each a band of rows.

    A slanted arm fills little of one box around it, but most of these.
    """
    edges = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    outline = np.concatenate([np.linspace(a, b, 2 + int(np.ptp([a, b], axis=0).max())) for a, b in edges])
    for top in range(0, height, BAND_PX):
        bottom = min(top + BAND_PX, height)
        x = outline[(outline[:, 1] > top - 2) & (outline[:, 1] < bottom + 1), 0]
        left, right = (int(at) for at in np.clip([x.min() - 1, x.max() + 2], 0, width)) if len(x) else (0, 0)
        if right > left:
            yield top, bottom, left, right


def _lay(
    image: np.ndarray,
    centre: np.ndarray,
    radius_px: float,
    rgb: np.ndarray,
    blur_px: float = LENS_BLUR_PX,
    shading: tuple[float, float] = (0.0, 0.0),
) -> None:
    """Lay a disc over the image; its edge is the normal distribution, which is what blur makes of an edge.

    shading: relative change of brightness from the centre to the right and to the lower edge.
    """
    reach = radius_px + 4 * blur_px
    left, top = np.maximum(np.floor(centre - reach), 0).astype(int)
    right, bottom = np.minimum(np.ceil(centre + reach) + 1, image.shape[1::-1]).astype(int)
    if right <= left or bottom <= top:
        return
    x = np.arange(left, right, dtype=np.float32) - np.float32(centre[0])
    y = np.arange(top, bottom, dtype=np.float32)[:, None] - np.float32(centre[1])
    coverage = ndtr((radius_px - np.hypot(x, y)) / np.float32(blur_px))[..., None]
    shade = 1 + (shading[0] * x + shading[1] * y) / np.float32(radius_px)
    crop = image[top:bottom, left:right]
    crop[:] = np.clip(crop + coverage * (shade[..., None] * rgb.astype(np.float32) - crop) + 0.5, 0, 255)


def _glare(image: np.ndarray, centre: np.ndarray, radius_px: float) -> None:
    """Add a lamp's reflection: a saturated spot with a wide veil."""
    y, x = np.ogrid[: image.shape[0], : image.shape[1]]
    squared = (np.square(x - centre[0]) + np.square(y - centre[1])) / radius_px**2
    light = 260 * np.exp(-squared / 0.5) + 60 * np.exp(-squared / 12)
    image[:] = np.minimum(image + light[..., None], 255)


def encode_jpeg(frame: np.ndarray) -> bytes:
    """JPEG of an RGB frame (H, W, 3) uint8."""
    done, data = cv2.imencode(".jpg", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not done:
        raise Refusal(f"frame of shape {frame.shape} could not be encoded as JPEG")
    return data.tobytes()
