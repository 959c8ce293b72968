"""The depth camera errs with the square of depth."""

from dataclasses import replace

from physics.effect import Effect, Parameter, Values
from physics.light import Light, Return
from physics.rendering import Rendering


class DepthError(Effect):
    """Surfaces are at r · (1 + r · `error`) where the camera says r.

    A disparity d = f·b/z that is off by the same everywhere makes z err by z²/(f·b) times that, as cameras do whose
    two halves are out of alignment. Nearer surfaces are brighter by the inverse square.
    """

    id = "depth_error"
    acts_on = "scene"
    sentence = "ranges differ from the camera's by an error that grows with the square of range"
    forms = (("error",),)
    parameters = (
        Parameter("error", unit="1/m", low=-0.2, high=0.2, start=0.002, vanishes_at=0.0, sentence="At 1 m, relative."),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene at its true ranges."""
        ways = []
        for way in rendering.light.returns:
            times = (1 + values["error"] * way.range_m).clip(0.1)
            ways.append(Return(way.range_m * times, way.strength / times**2))
        return replace(rendering.light, returns=tuple(ways))


effect = DepthError()
