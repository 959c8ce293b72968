"""The camera's lens distorts its image, which nobody took off."""

from physics.effect import Effect, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class LensDistortion(Effect):
    """Maps are displaced along the radius by `cubic` · r³, r and displacement in half diagonals of the image.

    The first term of Brown's model (Brown 1966, "Decentering distortion of lenses", Photogrammetric Engineering
    32(3), 444-462), about the image's centre, or where the axis of the lens meets the image beside that.
    """

    id = "lens_distortion"
    acts_on = "optics"
    sentence = "maps are displaced outward or inward, the more the farther from the image's centre"
    forms = (("cubic",), ("cubic", "axis_x", "axis_y"))
    parameters = (
        Parameter("cubic", unit="1", low=-1.0, high=1.0, start=0.02, vanishes_at=0.0, sentence="At a corner."),
        Parameter("axis_x", "1", -1.0, 1.0, 0.0, "Where the axis is, half diagonals right of the image's centre."),
        Parameter("axis_y", "1", -1.0, 1.0, 0.0, "The same down."),
    )

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints of the distorted image."""
        where = rendering.footprints
        width, height = where.field.full_size
        half = ((width**2 + height**2) ** 0.5) / 2
        x = (where.x_px - (width - 1) / 2) / half - values["axis_x"]
        y = (where.y_px - (height - 1) / 2) / half - values["axis_y"]
        times = values["cubic"] * (x**2 + y**2) * half
        return where.moved(times * x, times * y)


effect = LensDistortion()
