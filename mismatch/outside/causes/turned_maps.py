"""The image is turned, or of another scale, against that of the scan."""

from physics.effect import Effect, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class TurnedMaps(Effect):
    """Maps are turned by `roll` about the image's centre, or larger by the part `zoom`, to first order in both.

    A camera that was screwed on anew, an image that was resampled or cropped: about another point than the centre it
    is displaced as well.
    """

    id = "turned_maps"
    acts_on = "optics"
    sentence = "maps are turned about the image's centre, or larger or smaller"
    forms = (("roll",), ("zoom",), ("roll", "x", "y"), ("zoom", "x", "y"))
    parameters = (
        Parameter("roll", unit="rad", low=-0.5, high=0.5, start=0.02, vanishes_at=0.0, sentence="Clockwise."),
        Parameter("zoom", unit="1", low=-0.5, high=0.5, start=0.02, vanishes_at=0.0, sentence="Larger by this part."),
        Parameter("x", "px", -100.0, 100.0, 0.0, "Displaced to the right beside that."),
        Parameter("y", "px", -100.0, 100.0, 0.0, "Displaced down."),
    )

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints turned and scaled."""
        where, roll, zoom = rendering.footprints, values["roll"], values["zoom"]
        width, height = where.field.full_size
        x, y = where.x_px - (width - 1) / 2, where.y_px - (height - 1) / 2
        return where.moved(zoom * x - roll * y + values["x"], zoom * y + roll * x + values["y"])


effect = TurnedMaps()
