"""Detectors tire: what they received in the frames before makes them less sensitive."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class Fatigue(Effect):
    """Light of a zone over 1 + tired · m, with m the mean of its light in earlier frames, over the most of any.

    Earlier frames count by exp(-age / memory); before the first none were seen, and counters began rested. The
    background tires and fades as well where it was recorded with detectors at rest, by the power `background`.
    """

    id = "fatigue"
    acts_on = "detector"
    order = 80  # All that a zone counts, before histograms are mixed.
    sentence = "each zone is less sensitive the more light it received in the frames before"
    forms = (("tired",), ("tired", "memory"), ("tired", "memory", "background"))
    parameters = (
        Parameter("tired", unit="1", low=-0.5, high=10.0, start=0.05, vanishes_at=0.0, sentence="After most light."),
        Parameter(
            "memory", unit="frames", low=0.1, high=300.0, start=3.0, tries=(0.3, 15.0), sentence="How long it lasts."
        ),
        Parameter(
            "background", "1", 0.0, 1.0, 0.0, "1 where the recorded background is of detectors at rest.", tries=(1.0,)
        ),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """All frames before."""
        return np.inf, 0.0

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts of detectors that are as tired as they are."""
        background = np.minimum(rendering.background, rendering.expected)
        light = rendering.expected - background
        total = (light + values["background"] * background).sum(axis=-1)
        kept, mean = np.exp(-1 / values["memory"]), np.zeros(total.shape)
        for i in range(1, len(total)):
            mean[i] = kept * mean[i - 1] + (1 - kept) * total[i - 1]
        left = 1 / (1 + values["tired"] * mean / max(float(total.max()), 1e-300))
        return light * left[..., None] + background * left[..., None] ** values["background"]


effect = Fatigue()
