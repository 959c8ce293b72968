"""Memory is not cleared: a histogram still holds part of the one some frames before."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

# Rings of buffers hold so many frames.
OLDEST = 8


class StaleFrame(Effect):
    """What is shown is (1 - share) · the frame's counts and share · those of the frame `age` before it.

    Or, where it is never cleared, the frame's counts and `first` · those of the session's first frame as well.

    Unlike a lag, which moves pulses, it shows them where they were and where they are. Before its first frame a
    session showed what that shows.
    """

    id = "stale_frame"
    acts_on = "detector"
    order = 90  # Of finished histograms.
    sentence = "each histogram holds part of that of an earlier frame"
    forms = (("share",), ("first",))
    parameters = (
        Parameter("share", unit="1", low=0.0, high=0.95, start=0.05, vanishes_at=0.0, sentence="Part of the earlier."),
        Parameter("first", unit="1", low=0.0, high=1.0, start=0.01, vanishes_at=0.0, sentence="Part of the first."),
        Parameter("age", unit="frames", low=1.0, high=OLDEST, start=1.0, sentence="How many frames earlier."),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """All frames before."""
        return np.inf, 0.0

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Mixed counts."""
        share, age, now = values["share"], round(values["age"]), rendering.expected
        earlier = now[np.maximum(np.arange(len(now)) - age, 0)]
        return (1 - share) * now + share * earlier + values["first"] * now[:1]

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Every age."""
        return [{"share": self.parameter("share").start, "age": float(age)} for age in range(1, OLDEST + 1)]


effect = StaleFrame()
