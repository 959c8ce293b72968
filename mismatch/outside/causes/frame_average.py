"""Firmware averages histograms over frames."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class FrameAverage(Effect):
    """What is shown is (1 - share) · the frame's counts and share · what was shown before: a recursive filter.

    Unlike a lag, which moves pulses, it shows them where they were and where they are. Before its first frame a
    session showed what that shows.
    """

    id = "frame_average"
    acts_on = "detector"
    order = 90  # Of finished histograms.
    sentence = "each histogram holds part of what was shown before it"
    forms = (("share",),)
    parameters = (
        Parameter("share", unit="1", low=0.0, high=0.95, start=0.05, vanishes_at=0.0, sentence="Part of the earlier."),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """All frames before."""
        return np.inf, 0.0

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Averaged counts."""
        share, shown = values["share"], rendering.expected.copy()
        for i in range(1, len(shown)):
            shown[i] = (1 - share) * shown[i] + share * shown[i - 1]
        return shown


effect = FrameAverage()
