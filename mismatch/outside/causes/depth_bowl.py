"""The depth camera errs with the angle to its axis."""

from mismatch.outside.farther import farther
from physics.effect import Effect, Parameter, Values
from physics.light import Light
from physics.rendering import Rendering


class DepthBowl(Effect):
    """Surfaces are at r · (1 + `bowl` · tan²θ + `scale`) where the camera says r, θ from its optical axis.

    Flat walls come out as bowls where a lens is calibrated imperfectly, and where depth along the ray was taken for
    depth along the axis (r · tan²θ / 2 to first order). Nearer surfaces are brighter by the inverse square.
    """

    id = "depth_bowl"
    acts_on = "scene"
    sentence = "ranges differ from the camera's by an error that grows with the angle to its axis"
    forms = (("bowl",), ("bowl", "scale"))
    parameters = (
        Parameter("bowl", unit="1", low=-1.0, high=1.0, start=0.02, vanishes_at=0.0, sentence="At 45 degrees."),
        Parameter("scale", unit="1", low=-0.2, high=0.2, start=0.0, sentence="On the axis, relative."),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene at its true ranges."""
        light = rendering.light
        square = (light.rays[..., :2] ** 2).sum(axis=-1)
        return farther(light, lambda _: 1 + values["bowl"] * square + values["scale"])


effect = DepthBowl()
