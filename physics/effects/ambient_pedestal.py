"""`ambient_pedestal`: sunlight, lamps, dark counts beyond the recorded background."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class AmbientPedestal(Effect):
    """Photons that no laser sent arrive evenly in time: level + growth·t more in every bin, t seconds into the session.

    Where the same light is brighter than when it was recorded there is `more` of the recorded background in each zone.
    A background that is less than recorded, which negative growth may come to, is never less than none.
    """

    id = "ambient_pedestal"
    acts_on = "detector"
    sentence = "Light other than the laser's, or dark counts, adds the same number of counts to every bin."
    look_alikes = (
        LookAlike("stray_light", "Cover the emitter: a pedestal stays, stray light goes."),
        LookAlike(
            "scattering_medium",
            "Cover the emitter: a pedestal stays and is flat, backscatter goes and falls with time.",
        ),
        LookAlike("afterpulsing", "Cover the emitter: a pedestal stays, afterpulses go."),
    )
    forms = (("level",), ("level", "growth"), ("more",))
    parameters = (
        Parameter(
            "level",
            unit="counts",
            low=0.0,
            high=1e7,
            start=10.0,
            vanishes_at=0.0,
            axis="zone",
            sentence="Counts per bin and frame beyond the recorded background.",
        ),
        Parameter(
            "growth",
            unit="counts/s",
            low=-1e6,
            high=1e6,
            start=1.0,
            vanishes_at=0.0,
            sentence="Counts per bin and frame by which it is more after a second, in all zones.",
        ),
        Parameter(
            "more",
            unit="1",
            low=0.0,
            high=1e4,
            start=0.1,
            vanishes_at=0.0,
            sentence="Part of the recorded background that comes on top of it.",
        ),
    )

    def background(self, values: Values, rendering: Rendering) -> np.ndarray:
        """(F, P, 1) as many counts more in each bin of a zone."""
        grown = values["growth"] * rendering.light.time_s[:, None, None]
        known = rendering.background * (1 + values["more"])
        return np.maximum(known + np.atleast_1d(values["level"])[:, None] + grown, 0)


effect = AmbientPedestal()
