"""`stray_light`: each zone also receives a share of what the whole field receives."""

from dataclasses import replace

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class StrayLight(Effect):
    """In each zone, a share of the sum of all zones.

    Light that is scattered in the lens falls on all zones and is timed by the clock of the zone that counts it. Where
    signals mix after they were timed, as they may between neighbouring wires, they come at the time that they had in
    the zone they are of: `clocks` is the part of it that does.

    What the lens scatters comes from beyond the maps as well: by `glare` each zone also weighs a pixel with

        glare · exp(-x²/2 glare_x² - y²/2 glare_y²)

    of the tangents x/z and y/z of its ray, over the largest response, wherever the zone itself looks.
    """

    id = "stray_light"
    acts_on = "optics"
    grows = True
    order = -1  # It is light from the field: crosstalk, which never was there, comes after.
    sentence = "Every zone also receives a small share of the light that all zones together receive."
    look_alikes = (
        LookAlike("ambient_pedestal", "Cover the emitter: stray light goes, a pedestal stays."),
        LookAlike("multipath", "Show one zone alone a bright target: stray light is not late, a second bounce is."),
        LookAlike("footprint_blur", "Show one zone alone a target: stray light is in all others, blur in the next."),
    )
    forms = (("share",), ("share", "clocks"), ("glare", "glare_x", "glare_y"))
    parameters = (
        Parameter(
            "share",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.01,
            vanishes_at=0.0,
            axis="zone",
            sentence="What the zone receives more, as a part of the sum of all zones; about 0.01 is common.",
        ),
        Parameter("clocks", "1", 0.0, 1.0, 0.0, "Part of it that brings its zone's time zero along.", tries=(1.0,)),
        Parameter(
            "glare", "1", 0.0, 1.0, 1e-3, "Response to light from the whole field.", vanishes_at=0.0, axis="zone"
        ),
        Parameter("glare_x", "1", 0.02, 10.0, 0.3, "How far that reaches to either side, as a tangent."),
        Parameter("glare_y", "1", 0.02, 10.0, 0.3, "How far it reaches up and down, as a tangent."),
    )

    def in_scene(self, values: Values) -> bool:
        """Glare is; what zones give each other is not."""
        return bool(np.any(values["glare"]))

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Each zone's, with its glare all over the field."""
        glare = np.atleast_1d(values["glare"])
        if not glare.any():
            return rendering.footprints
        x, y = np.moveaxis(rendering.light.rays[..., :2], -1, 0)
        field = np.exp(-((x / values["glare_x"]) ** 2 + (y / values["glare_y"]) ** 2) / 2)
        return rendering.footprints.changed(lambda weights: weights + glare[:, None, None] * field)

    def moves_light(self, values: Values) -> bool:
        """See `Effect`."""
        return bool(np.any(values["share"]))

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """In each zone, a share of the sum over zones, moved to this zone's time zero or not."""
        own, share = rendering.arrivals, np.atleast_1d(values["share"])[:, None]
        zero = np.broadcast_to(rendering.clock.time_zero_s, own.light.shape[:2])
        as_timed = own.light.sum(axis=1, keepdims=True)
        if not np.ptp(zero, axis=1).any():
            return replace(own, light=own.light + share * as_timed)
        total = own.delayed(zero[:, :1] - zero).light.sum(axis=1, keepdims=True)
        everywhere = replace(own, light=np.broadcast_to(total, own.light.shape)).delayed(zero - zero[:, :1])
        mixed = everywhere.light  # Its own, and large: it is changed where it is.
        if values["clocks"]:
            mixed += values["clocks"] * (as_timed - mixed)
        mixed *= share
        mixed += own.light
        return replace(own, light=mixed)


effect = StrayLight()
