"""The camera's lens distorts its image, which nobody took off."""

from physics.effect import Effect, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class LensDistortion(Effect):
    """Maps are displaced along the radius by `cubic` · r³, r and displacement in half diagonals of the image.

    The first term of Brown's model (Brown 1966, "Decentering distortion of lenses", Photogrammetric Engineering
    32(3), 444-462).
    """

    id = "lens_distortion"
    acts_on = "optics"
    sentence = "maps are displaced outward or inward, the more the farther from the image's centre"
    forms = (("cubic",),)
    parameters = (
        Parameter("cubic", unit="1", low=-0.5, high=0.5, start=0.02, vanishes_at=0.0, sentence="At a corner."),
    )

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints of the distorted image."""
        where = rendering.footprints
        width, height = where.field.full_size
        x, y = where.x_px - (width - 1) / 2, where.y_px - (height - 1) / 2
        times = values["cubic"] * 4 * (x**2 + y**2) / (width**2 + height**2)
        return where.moved(times * x, times * y)


effect = LensDistortion()
