"""The depth camera shows near things wider than they are."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.light import Light, Return
from physics.rendering import Rendering

# Ranges of neighbours that differ by more than this part of themselves belong to two things.
JUMP = 0.05
# A border of so many pixels is tried beside one of one.
WIDER = 2.0


class FatEdges(Effect):
    """Of what lies within `pixels` of something farther by `JUMP`, the part `share` is that which is farther.

    Stereo matches windows, and what is near wins a window that holds an edge: foreground is fattened by up to half of
    one (Scharstein and Szeliski 2002, International Journal of Computer Vision 47, 7).
    """

    id = "fat_edges"
    acts_on = "scene"
    sentence = "near things are narrower than the depth camera shows them"
    forms = (("share",),)
    parameters = (
        Parameter("share", "1", 0.0, 1.0, 0.3, "Part of the border that is not there.", vanishes_at=0.0),
        Parameter("pixels", "1", 1.0, 4.0, 1.0, "Width of the border, pixels of the depth image."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Begun with a wider border as well."""
        return [{"share": self.parameter("share").start, "pixels": WIDER}]

    def light(self, values: Values, rendering: Rendering) -> Light:
        """Things as narrow as they are."""
        light = rendering.light
        if not values["share"]:
            return light
        at = _farthest(light.range_m, round(values["pixels"]))
        border = light.range_m.ravel()[at].reshape(light.range_m.shape) > light.range_m * (1 + JUMP)
        ways = []
        for way in light.returns:
            there = [of.ravel()[at].reshape(of.shape) for of in (way.range_m, way.strength)]
            part = np.where(border, np.float32(values["share"]), np.float32(0))
            ways += [Return(way.range_m, way.strength * (1 - part)), Return(there[0], there[1] * part)]
        return replace(light, returns=tuple(ways))


def _farthest(range_m: np.ndarray, pixels: int) -> np.ndarray:
    """(F·H·W,) index of the farthest pixel of each frame (F, H, W) within so many rows and columns of each."""
    _, height, width = range_m.shape
    index = np.arange(range_m.size).reshape(range_m.shape)
    best, found = np.nan_to_num(range_m), index
    known = best.copy()
    row, column = np.indices((height, width))
    for down in range(-pixels, pixels + 1):
        for right in range(-pixels, pixels + 1):
            y, x = np.clip(row + down, 0, height - 1), np.clip(column + right, 0, width - 1)
            farther = known[:, y, x] > best
            best, found = np.where(farther, known[:, y, x], best), np.where(farther, index[:, y, x], found)
    return found.ravel()


effect = FatEdges()
