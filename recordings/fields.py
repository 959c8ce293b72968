"""What each array of a recording is: its shapes, its type, and the values it may hold."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# Cosines and reflectances computed in float32 overshoot 1 by rounding.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Field:
    """One array: where it may be, what it may hold.

    shapes: one letter an axis (F frames, P zones, T bins, N samples, H × W camera grid); a digit is a length.
    kinds: numpy kinds admitted, of "u", "i", "f".
    good: where values are admitted, element by element; None where the type says it all.
    expected: the end of the sentence "... expected".
    """

    shapes: tuple[str, ...]
    kinds: str
    good: Callable[[np.ndarray], np.ndarray] | None
    expected: str
    required: bool = False

    def of_a_frame(self) -> "Field":
        """The same field seen one frame at a time; its shapes are empty where it does not vary by frame."""
        inner = tuple(letters[1:] for letters in self.shapes if letters.startswith("F"))
        return Field(inner, self.kinds, self.good, self.expected, self.required)

    def of_all_frames(self) -> "Field":
        """The same field where one value holds for all frames; its shapes are empty where it always varies."""
        still = tuple(letters for letters in self.shapes if not letters.startswith("F"))
        return Field(still, self.kinds, self.good, self.expected, self.required)


def positive(a: np.ndarray) -> np.ndarray:
    """Where values are positive and finite."""
    return (a > 0) & np.isfinite(a)


def not_negative(a: np.ndarray) -> np.ndarray:
    """Where values are zero or more, and finite."""
    return (a >= 0) & np.isfinite(a)


def not_infinite(a: np.ndarray) -> np.ndarray:
    """Where values are finite or NaN."""
    return ~np.isinf(a)


def depth(a: np.ndarray) -> np.ndarray:
    """Where values are NaN, or zero or more and finite."""
    return np.isnan(a) | not_negative(a)


def between(low: float, high: float) -> Callable[[np.ndarray], np.ndarray]:
    """Where values are NaN or in low..high."""
    return lambda a: np.isnan(a) | ((a >= low - ROUNDING) & (a <= high + ROUNDING))


IMAGE = ("FHW", "HW")
FIELDS = {
    "counts": Field(("FPT",), "ui", not_negative, "a count of 0 or more", required=True),
    "zone_grid": Field(("2",), "ui", positive, "rows and columns of 1 or more", required=True),
    "bin_width_s": Field(("",), "uif", positive, "positive, finite seconds", required=True),
    "time_zero_s": Field(("", "P"), "uif", np.isfinite, "finite seconds", required=True),
    "timestamp_s": Field(("F",), "uif", np.isfinite, "finite seconds", required=True),
    "laser_cycles": Field(("", "F"), "uif", positive, "a positive, finite number of laser shots"),
    "irf_time_s": Field(("N",), "uif", np.isfinite, "finite seconds"),
    "irf": Field(("N",), "uif", not_negative, "a finite probability of 0 or more"),
    "background_counts": Field(("P",), "uif", not_negative, "finite counts of 0 or more"),
    "depth_m": Field(IMAGE, "f", depth, "finite metres of 0 or more, NaN where unknown"),
    "reflectance": Field(IMAGE, "f", between(0, 1), "0 to 1, NaN where unknown"),
    "incidence_cosine": Field(IMAGE, "f", between(-1, 1), "-1 to 1, NaN where unknown"),
    "rgb": Field(("FHW3", "HW3"), "u", None, "uint8"),
    "intrinsics": Field(("33",), "uif", np.isfinite, "finite pixels"),
    "image_size": Field(("2",), "ui", positive, "width and height of 1 or more"),
    "lidar_from_camera": Field(("44",), "uif", np.isfinite, "finite numbers"),
    "camera_pose": Field(("F44",), "uif", np.isfinite, "finite numbers"),
    "patch_px": Field(("F2",), "uif", not_infinite, "finite pixels, NaN where there is no patch"),
}
# Fields on the camera grid, which a reader may leave in the file until they are asked for.
IMAGES = ("depth_m", "reflectance", "incidence_cosine", "rgb")

MAP_FIELDS = {
    "responses": Field(("RCK",), "uif", not_negative, "a finite response of 0 or more", required=True),
    "xs": Field(("K",), "uif", np.isfinite, "finite pixels", required=True),
    "ys": Field(("K",), "uif", np.isfinite, "finite pixels", required=True),
    "sigma": Field(("RCK",), "uif", not_negative, "a finite standard error of 0 or more"),
    "flags": Field(("RCK",), "u", None, "uint8"),
    "position_sigma_px": Field(("K",), "uif", not_negative, "finite pixels of 0 or more"),
    "position_confidence": Field(("K",), "uif", not_negative, "a finite number of 0 or more"),
}
BYTES_ONLY = ("rgb", "flags")


def varies(name: str, ndim: int) -> bool:
    """Whether field `name`, where its array has `ndim` axes, has one value for every frame."""
    return any(len(letters) == ndim and letters.startswith("F") for letters in FIELDS[name].shapes)
