"""The depth camera errs to and fro with range."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.light import Light, Return
from physics.rendering import Rendering

# So many waves are looked for in the ranges in view, but for a few per cent of these; fewer are a curve.
WAVES, MOST = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0), (2.0, 98.0)


class DepthRipple(Effect):
    """Surfaces are at r + `sine` sin(2πr/`period`) + `cosine` cos(2πr/`period`) where the camera says r.

    Cameras that tell range by the phase of modulated light err so, as its harmonics alias (wiggling error, Lindner and
    Kolb 2006, ISVC); matching of a repeated pattern does as well. Nearer surfaces are brighter by the inverse square.
    Bins that are unequal shift arrivals by the clock, not by range, and counts with them.
    """

    id = "depth_ripple"
    acts_on = "scene"
    sentence = "ranges differ from the camera's by an error that goes to and fro with range"
    forms = (("sine", "cosine", "period"),)
    parameters = (
        Parameter("sine", "m", -0.2, 0.2, 0.002, "At a quarter of a period.", vanishes_at=0.0),
        Parameter("cosine", "m", -0.2, 0.2, 0.002, "At none.", vanishes_at=0.0),
        Parameter("period", "m", 0.02, 100.0, 0.5, "Ranges from one wave to the next."),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene at its true ranges."""
        wave, ways = 2 * np.pi / values["period"], []
        for way in rendering.light.returns:
            by = values["sine"] * np.sin(wave * way.range_m) + values["cosine"] * np.cos(wave * way.range_m)
            true = np.maximum(way.range_m + by, 0.1 * way.range_m).astype(np.float32)
            dimmer = np.where(true > 0, way.range_m / np.where(true > 0, true, 1), 1) ** 2
            ways.append(Return(true, (way.strength * dimmer).astype(np.float32)))
        return replace(rendering.light, returns=tuple(ways))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Some periods; waves of two phases tell which."""
        ranges = rendering.light.range_m
        seen = ranges[ranges > 0]
        if not seen.size:
            return []
        near, far = np.percentile(seen, MOST)
        shortest = self.parameter("period").low
        return [{"period": max(float(far - near) / waves, shortest)} for waves in WAVES if far > near]


effect = DepthRipple()
