"""A time-to-digital converter that reads one of its digits wrong: events are filed some bins away from theirs."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

# Digits of bin numbers, and bins in a turn of the coarse counter.
DIGITS, TURNS = range(8), (4, 8, 16, 32, 64)
# Where in a turn the last parts begin that are tried.
LAST = (0.5, 0.75, 0.875)


class MisfiledBins(Effect):
    """Part `flipped` of all events has digit `digit` of the binary number of its bin inverted; and part `slipped` of
    those in the last part of a turn of `turn` bins, from part `last` of it on, is filed a turn later.

    The first is a latch that samples a line as it changes. The second is a coarse counter that counts on before the
    fine one is back at 0. Either makes echoes, as surfaces do, of some bins alone: before and behind, or behind.
    """

    id = "misfiled_bins"
    acts_on = "detector"
    order = 80  # Of events that have been detected, before anything is done with counts.
    sentence = "a time-to-digital converter reads a digit wrong, so that events of some bins are filed others away"
    forms = (("flipped",), ("slipped",))
    parameters = (
        Parameter("flipped", "1", 0.0, 0.5, 0.01, "Part of events with a digit inverted.", vanishes_at=0.0),
        Parameter("digit", "1", 0.0, 7.0, 3.0, "Which digit, the lowest is 0."),
        Parameter(
            "slipped", "1", 0.0, 1.0, 0.05, "Part of events late in a turn that are a turn late.", vanishes_at=0.0
        ),
        Parameter("turn", "bins", 2.0, 256.0, 16.0, "Bins of a turn."),
        Parameter("last", "1", 0.0, 1.0, 0.75, "Part of a turn after which they are."),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts with part of those of some bins in others."""
        bins, turn = np.arange(rendering.clock.bins), round(values["turn"])
        flipped = _filed(
            rendering.expected, bins ^ (1 << round(values["digit"])), np.full(len(bins), values["flipped"])
        )
        return _filed(flipped, bins + turn, values["slipped"] * (bins % turn >= values["last"] * turn))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Every digit, every turn."""
        bins = rendering.clock.bins
        digits = [{"flipped": self.parameter("flipped").start, "digit": float(d)} for d in DIGITS if 1 << d < bins]
        start = self.parameter("slipped").start
        turns = [(turn, last) for turn in TURNS for last in LAST if turn < bins and turn * (1 - last) >= 1]
        return digits + [{"slipped": start, "turn": float(turn), "last": last} for turn, last in turns]


def _filed(counts: np.ndarray, to: np.ndarray, part: np.ndarray) -> np.ndarray:
    """(..., T) counts of which a part (T,) is in other bins (T,); beyond the window it is lost."""
    out, there = counts * (1 - part), to < len(to)
    np.add.at(out, (..., to[there]), (counts * part)[..., there])
    return out


effect = MisfiledBins()
