"""`ambient_pedestal`: sunlight, lamps, dark counts beyond the recorded background."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class AmbientPedestal(Effect):
    """Photons that no laser sent arrive evenly in time: as many more in every bin."""

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
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """As many counts more in each bin of a zone."""
        return rendering.expected + np.atleast_1d(values["level"])[:, None]


effect = AmbientPedestal()
