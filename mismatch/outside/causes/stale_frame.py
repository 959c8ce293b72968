"""Memory is not cleared: a histogram still holds part of the one some frames before."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

# Rings of buffers hold so many frames.
OLDEST = 8
# A frame that stays is looked for so many frames on either side of that which is most like it: blocks of so many may
# be held out.
NEAR = 4
# Counts by which nothing is divided.
LEAST = 1e-3


class StaleFrame(Effect):
    """What is shown is (1 - share) · the frame's counts and share · those of the frame `age` before it.

    Or, where it is never cleared, the frame's counts and `ever` · those at time `at` as well, of the session's first
    frame where that is 0, between two frames by interpolation.

    Unlike a lag, which moves pulses, it shows them where they were and where they are. Before its first frame a
    session showed what that shows.
    """

    id = "stale_frame"
    acts_on = "detector"
    order = 90  # Of finished histograms.
    sentence = "each histogram holds part of that of an earlier frame"
    forms = (("share",), ("ever",), ("ever", "at"))
    parameters = (
        Parameter("share", unit="1", low=0.0, high=0.95, start=0.05, vanishes_at=0.0, sentence="Part of the earlier."),
        Parameter(
            "ever", unit="1", low=0.0, high=1.0, start=0.01, vanishes_at=0.0, sentence="Part of the one that stays."
        ),
        Parameter("at", unit="s", low=0.0, high=200.0, start=0.0, sentence="When that was taken."),
        Parameter("age", unit="frames", low=1.0, high=OLDEST, start=1.0, sentence="How many frames earlier."),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """All frames before, and after where one of these may be the one that stays."""
        return np.inf, np.inf if values["at"] else 0.0

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Mixed counts."""
        share, age, now = values["share"], round(values["age"]), rendering.expected
        earlier = now[np.maximum(np.arange(len(now)) - age, 0)]
        at = np.interp(values["at"], rendering.light.time_s, np.arange(len(now)))
        before, part = int(at), at - int(at)
        stays = (1 - part) * now[before] + part * now[min(before + 1, len(now) - 1)]
        return (1 - share) * now + share * earlier + values["ever"] * stays

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Every age; and the frame that is most like what is too much in all, or one near it, which may be held out."""
        ages = [{"share": self.parameter("share").start, "age": float(age)} for age in range(1, OLDEST + 1)]
        noise, times = np.sqrt(np.maximum(expected.mean(axis=0), LEAST)), rendering.light.time_s
        seen, more = ((of / noise).reshape(-1, noise.size) for of in (expected, excess.mean(axis=0)))
        # What all frames have in common is the gain's.
        common = seen.mean(axis=0) / max(float(np.linalg.norm(seen.mean(axis=0))), LEAST)
        apart = seen - np.outer(seen @ common, common)
        alike = apart @ more[0] / np.maximum(np.linalg.norm(apart, axis=1), LEAST)
        step = float(np.diff(times).min()) if len(times) > 1 else 0.0
        near = times[np.argmax(alike)] + step * np.arange(-NEAR, NEAR + 1)
        start = self.parameter("ever").start
        return ages + [{"ever": start, "at": float(at)} for at in near if 0 < at <= times[-1]]


effect = StaleFrame()
