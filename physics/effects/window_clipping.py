"""`window_clipping`: counts are looked for in a window, which cuts off part of a pulse."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class WindowClipping(Effect):
    """Counts before and after the window are not there; of a bin that its edge divides, the part inside is."""

    id = "window_clipping"
    acts_on = "estimator"
    sentence = "A later step keeps only the counts inside a window of bins and cuts off what reaches beyond it."
    look_alikes = (
        LookAlike(
            "range_falloff", "Step the target in range: falloff scales the pulse, a window cuts it in the same bins."
        ),
        LookAlike("range_aliasing", "Step the target in range: an aliased pulse comes back, one that is cut does not."),
    )
    forms = (("early",), ("late",), ("early", "late"))
    parameters = (
        Parameter(
            "early",
            unit="bins",
            low=0.0,
            high=65536.0,
            start=4.5,
            vanishes_at=0.0,
            sentence="How many of the first bins lie outside the window.",
        ),
        Parameter(
            "late",
            unit="bins",
            low=0.0,
            high=65536.0,
            start=4.5,
            vanishes_at=0.0,
            sentence="How many of the last bins lie outside the window.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts times the part of their bin that lies in the window."""
        bins = rendering.expected.shape[-1]
        start, stop = values["early"], bins - values["late"]
        left = np.arange(bins)
        return rendering.expected * np.clip(np.minimum(left + 1, stop) - np.maximum(left, start), 0, 1)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The edges beyond which the recording lacks most of what is expected, early and late."""
        lacking, there = -excess.sum(axis=(0, 1)), np.maximum(expected.sum(axis=(0, 1)), 1)
        early = np.cumsum(2 * lacking - there)
        late = np.cumsum((2 * lacking - there)[::-1])
        return [{"early": float(np.argmax(early) + 1)}, {"late": float(np.argmax(late) + 1)}]


effect = WindowClipping()
