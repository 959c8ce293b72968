"""The counter changes its scale above a number of counts."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

# Parts of the largest count at which the change is looked for.
PARTS = (0.1, 0.3, 0.6)


class TwoSlopes(Effect):
    """Of what exceeds `above` counts, in a zone and bin of a frame, the part `lost` is not there.

    Histograms that are compressed to fewer bits, or prescaled, and expanded again with the wrong law. A saturated
    counter stops instead.
    """

    id = "two_slopes"
    acts_on = "detector"
    order = 80
    sentence = "the counter goes on more slowly above a number of counts"
    forms = (("lost", "above"),)
    parameters = (
        Parameter("lost", "1", -3.0, 0.8, 0.2, "Part of what exceeds it; more is counted where negative.", 0.0),
        Parameter("above", "counts", 1.0, 1e9, 1e3, "Counts from which on."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Some parts of the largest count."""
        return [{"above": max(1.0, part * float(expected.max()))} for part in PARTS]

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts, of which some are lost."""
        return rendering.expected - values["lost"] * np.maximum(rendering.expected - values["above"], 0)


effect = TwoSlopes()
