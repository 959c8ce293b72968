"""The depth camera errs with the square of depth."""

from mismatch.outside.farther import farther
from physics.effect import Effect, Parameter, Values
from physics.light import Light
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
        return farther(rendering.light, lambda ranges: 1 + values["error"] * ranges)


effect = DepthError()
