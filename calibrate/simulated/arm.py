"""The robot arm that carries the patch: its measures, and its picture for the camera."""

import cv2
import numpy as np

from calibrate.simulated.bench import Bench

# Metres, about those of a small cobot with an ISO 9409-1-50-4-M6 flange.
FLANGE_M, PLATE_M, BOLT_CIRCLE_M, BOLT_M = 0.0432, 0.0335, 0.025, 0.0032
BOLT_ANGLES = np.radians([-68, 22, 112, 202])
WRIST_M, HOUSING_M, LINK_M = 0.039, 0.042, 0.046
SEAM_AT_M, CAP_AT_M, CAP_M, BAND_AT_M = 0.052, 0.1255, 0.0545, 0.183
SCREW_CIRCLE_M, SCREW_M = 0.044, 0.0032
ARM_LENGTH_M = 1.6
ARM_BEHIND_M, FLANGE_BEHIND_M = 0.06, 0.004

# Where the arm comes from, in the image: beyond its upper left corner, so that its direction turns with the
# position.
SHOULDER_PX = (-260.0, -90.0)

PICTURE_PX_PER_M = 1400
HALF_PICTURE_M = 0.06


def arm_direction(bench: Bench, centres_m: np.ndarray) -> np.ndarray:
    """(..., 2) unit vectors in the image plane, from the flange at (..., 3) towards the shoulder."""
    shoulder = (np.array(SHOULDER_PX) - bench.principal_px) * bench.patch_range_m / bench.focal_px
    towards = shoulder - centres_m[..., :2]
    return towards / np.linalg.norm(towards, axis=-1, keepdims=True)


def arm_picture() -> tuple[np.ndarray, np.ndarray]:
    """RGB (h, w, 3) uint8 of the arm times its coverage, and 255 minus the coverage in each channel.

    Drawn along +x from the flange's centre, which lies at x = HALF_PICTURE_M, y = HALF_PICTURE_M; one pixel
    is 1 / PICTURE_PX_PER_M.
    """
    shape = (
        int(2 * HALF_PICTURE_M * PICTURE_PX_PER_M),
        int((ARM_LENGTH_M + HALF_PICTURE_M) * PICTURE_PX_PER_M),
    )
    y, x = (np.indices(shape, np.float32) + 0.5) / PICTURE_PX_PER_M - HALF_PICTURE_M
    colour = np.zeros((*shape, 3), np.float32)
    coverage = np.zeros(shape, np.float32)

    def paint(distance_m: np.ndarray, rgb: np.ndarray) -> None:
        """Lay a colour over where the distance to an edge, positive inside, is positive."""
        inside = np.clip(distance_m * PICTURE_PX_PER_M + 0.5, 0, 1)
        colour[:] += inside[..., None] * (rgb - colour)
        coverage[:] += inside * (1 - coverage)

    across = y / HOUSING_M
    grey = (168 + 55 * across)[..., None] * np.array([0.97, 1.0, 1.02], np.float32)
    paint(np.minimum(WRIST_M - abs(y), x + 0.02), 0.9 * grey)
    paint(np.minimum(HOUSING_M - abs(y), x - SEAM_AT_M), grey)
    half_seam = np.minimum(WRIST_M - abs(y), 0.0016 - abs(x - SEAM_AT_M))
    paint(half_seam, np.array([52, 46, 50]))
    paint(np.minimum(WRIST_M - abs(y), 0.0012 - abs(x - SEAM_AT_M + 0.003)), np.array([232, 228, 222]))
    bowed = x - BAND_AT_M - 0.008 * np.square(y / LINK_M)
    paint(np.minimum(LINK_M + 0.008 * (x - BAND_AT_M) - abs(y), bowed), _link_colour(-y / LINK_M))
    paint(np.minimum(LINK_M - abs(y), 0.0055 - abs(bowed)), np.array([56, 52, 54]))
    _paint_cap(paint, x - CAP_AT_M, y)
    blurred = cv2.GaussianBlur(np.dstack([colour * coverage[..., None], coverage]), (0, 0), 1.1)
    uncovered = np.repeat(255 * (1 - blurred[..., 3:]), 3, axis=2)
    return blurred[..., :3].round().astype(np.uint8), uncovered.round().astype(np.uint8)


def _link_colour(across: np.ndarray) -> np.ndarray:
    """Polished tube: two saturated highlights with a warm reflection between them, RGB."""
    at = [-1.1, -0.9, -0.3, 0.05, 0.4, 0.75, 1.1]
    red, green = [170, 254, 254, 240, 214, 225, 150], [172, 254, 246, 208, 200, 224, 150]
    blue = [178, 254, 240, 190, 196, 226, 152]
    return np.stack([np.interp(across, at, channel) for channel in (red, green, blue)], axis=-1)


def _paint_cap(paint, x: np.ndarray, y: np.ndarray) -> None:
    """The round cap of the joint, with its rim and three screws."""
    radius = np.hypot(x, y)
    shade = (1 + 0.05 * (x - y) / CAP_M)[..., None]
    paint(CAP_M - radius, shade * np.array([158, 172, 178]))
    paint(CAP_M - 0.0015 - np.hypot(x, y + 0.001), shade * np.array([192, 216, 228]))
    paint(CAP_M - 0.006 - radius, shade * np.array([187, 203, 211]))
    for angle in np.radians([65, 185, 305]):
        from_screw = np.hypot(x - SCREW_CIRCLE_M * np.cos(angle), y - SCREW_CIRCLE_M * np.sin(angle))
        paint(SCREW_M + 0.0012 - from_screw, np.array([168, 184, 190]))
        paint(SCREW_M - from_screw, np.array([128, 122, 118]))
        paint(SCREW_M - 0.002 - from_screw, np.array([196, 190, 178]))
