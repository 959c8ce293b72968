"""The depth camera errs to and fro over its image."""

import numpy as np

from mismatch.outside.farther import farther
from physics.effect import Effect, Parameter, Values
from physics.light import Light
from physics.rendering import Rendering

# Waves over the width and over the height of the image that are looked for; fewer are a slope or a bowl.
WAVES = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (0, 3))


class DepthWaves(Effect):
    """Surfaces are at r · (1 + `sine` sin φ + `cosine` cos φ) where the camera says r, φ = 2π(`across` x + `down` y).

    x and y go from 0 to 1 over the image. Depth cameras of structured light warp depth by a factor of each pixel's own,
    which varies smoothly over the image and is the same in all frames (Teichman, Miller and Thrun 2013, RSS). Nearer
    surfaces are brighter by the inverse square.
    """

    id = "depth_waves"
    acts_on = "scene"
    sentence = "ranges differ from the camera's by an error that goes to and fro over its image"
    forms = (("sine", "cosine", "across", "down"),)
    parameters = (
        Parameter("sine", "1", -0.2, 0.2, 0.005, "Relative, at a quarter of a wave.", vanishes_at=0.0),
        Parameter("cosine", "1", -0.2, 0.2, 0.005, "Relative, at none.", vanishes_at=0.0),
        Parameter("across", "1", -10.0, 10.0, 1.0, "Waves over the width of the image."),
        Parameter("down", "1", -10.0, 10.0, 0.0, "Waves over its height."),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene at its true ranges."""
        height, width = rendering.light.range_m.shape[1:]
        x, y = np.arange(width) / width, np.arange(height)[:, None] / height
        phase = 2 * np.pi * (values["across"] * x + values["down"] * y)
        wave = values["sine"] * np.sin(phase) + values["cosine"] * np.cos(phase)
        return farther(rendering.light, lambda _: 1 + wave)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Some directions and lengths of waves."""
        return [{"across": float(across), "down": float(down)} for across, down in WAVES]


effect = DepthWaves()
