"""Detectors tire: what they received in the frames before makes them less sensitive."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class Fatigue(Effect):
    """Light of a zone over 1 + tired · m, with m the mean of its light in earlier frames, over the most of any.

    Earlier frames count by exp(-age / memory); before the first none were seen, and counters began rested, or the first
    had been seen for long, by the part `before`. The background tires and fades as well where it was recorded with
    detectors at rest, by the power `background`, or with detectors as tired as they are in the mean, as far as that is
    `usual`. Where the supply of their bias sags they tire together, by the light of the mean zone, as far as it is
    `shared`.
    """

    id = "fatigue"
    acts_on = "detector"
    order = 80  # All that a zone counts, before histograms are mixed.
    sentence = "each zone is less sensitive the more light it received in the frames before"
    forms = (
        ("tired",),
        ("tired", "memory"),
        ("tired", "memory", "background"),
        ("tired", "memory", "shared", "before"),
        ("tired", "memory", "background", "shared", "before", "usual"),
    )
    parameters = (
        Parameter("tired", unit="1", low=-0.5, high=10.0, start=0.05, vanishes_at=0.0, sentence="After most light."),
        Parameter(
            "memory", unit="frames", low=0.1, high=300.0, start=3.0, tries=(0.3, 15.0), sentence="How long it lasts."
        ),
        Parameter(
            "background", "1", 0.0, 1.0, 0.0, "1 where the recorded background is of detectors at rest.", tries=(1.0,)
        ),
        Parameter("shared", "1", 0.0, 1.0, 0.0, "Part of that light which is of all zones alike.", tries=(1.0,)),
        Parameter("before", "1", 0.0, 1.0, 0.0, "Part of the first frame that was seen before it.", tries=(1.0,)),
        Parameter("usual", "1", 0.0, 1.0, 0.0, "1 where the background is of detectors that had tired.", tries=(1.0,)),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """All frames before."""
        return np.inf, 0.0

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts of detectors that are as tired as they are."""
        background = np.minimum(rendering.background, rendering.expected)
        light = rendering.expected - background
        total = (light + values["background"] * background).sum(axis=-1)
        total += values["shared"] * (total.mean(axis=1, keepdims=True) - total)
        kept, mean = np.exp(-1 / values["memory"]), values["before"] * total
        for i in range(1, len(total)):
            mean[i] = kept * mean[i - 1] + (1 - kept) * total[i - 1]
        left = 1 / (1 + values["tired"] * mean / max(float(total.max()), 1e-300))
        beside = left / (1 + values["usual"] * (left.mean() - 1))
        return light * left[..., None] + background * beside[..., None] ** values["background"]


effect = Fatigue()
