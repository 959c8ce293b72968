"""A time-to-digital converter that reads one of its digits wrong: events are filed some bins away from theirs."""

from itertools import product

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

# Digits of bin numbers; fewest bins in a turn of the coarse counter, and parts of it that are tried, the likeliest.
DIGITS, TURN, WIDE, LIKELY = range(8), 4, (1, 2, 4), 4
# Counts by which nothing is divided.
LEAST = 1e-3


class MisfiledBins(Effect):
    """Part `flipped` of all events has digit `digit` of the binary number of its bin inverted, or of those alone in
    which that is 1, where it sticks at 0, or 0, where it sticks at 1 (`sticks` 1 and 2); and part `slipped` of those in
    the `wide` bins from bin `at` of each turn of `turn` bins on is filed a turn later.

    The first is a latch that samples a line as it changes; all of them where a zone's words are read in another order.
    The second is a coarse counter that counts on before the fine one is back at 0. Either makes echoes, as surfaces do,
    of some bins alone: before and behind, or behind.
    """

    id = "misfiled_bins"
    acts_on = "detector"
    order = 80  # Of events that have been detected, before anything is done with counts.
    sentence = "a time-to-digital converter reads a digit wrong, so that events of some bins are filed others away"
    forms = (("flipped",), ("slipped",))
    parameters = (
        Parameter("flipped", "1", 0.0, 1.0, 0.01, "Part of events with a digit inverted.", 0.0, axis="zone"),
        Parameter("digit", "1", 0.0, 7.0, 3.0, "Which digit, the lowest is 0."),
        Parameter("sticks", "1", 0.0, 2.0, 0.0, "0: read wrong either way; 1: always 0; 2: always 1."),
        Parameter("slipped", "1", 0.0, 1.0, 0.05, "Part of those events that are a turn late.", vanishes_at=0.0),
        Parameter("turn", "bins", 2.0, 256.0, 16.0, "Bins of a turn."),
        Parameter("at", "bins", 0.0, 256.0, 12.0, "Bin of a turn from which on they are."),
        Parameter("wide", "bins", 1.0, 256.0, 4.0, "In how many bins they are."),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts with part of those of some bins in others."""
        bins, turn = np.arange(rendering.clock.bins), round(values["turn"])
        digit, sticks = round(values["digit"]), round(values["sticks"])
        amiss = (bins >> digit & 1 == 2 - sticks) if sticks else np.ones(len(bins))
        of_zones = np.atleast_1d(values["flipped"])[:, None] * amiss
        flipped = _filed(rendering.expected, bins ^ (1 << digit), of_zones)
        late = (bins - round(values["at"])) % turn < round(values["wide"])
        return _filed(flipped, bins + turn, values["slipped"] * late)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Every digit; and the turns, and places in them, that explain most of an excess, bin by bin."""
        bins = rendering.clock.bins
        flipped = self.parameter("flipped").start
        ways = product((float(d) for d in DIGITS if 1 << d < bins), (0.0, 1.0, 2.0))
        digits = [{"flipped": flipped, "digit": digit, "sticks": sticks} for digit, sticks in ways]
        found = []
        for turn in range(TURN, bins // 2):
            now, told = expected[..., :-turn], 1 / np.maximum(expected, LEAST)
            amiss = excess * told
            score = (now * (amiss[..., turn:] - amiss[..., :-turn])).sum(axis=(0, 1))
            information = (now**2 * (told[..., turn:] + told[..., :-turn])).sum(axis=(0, 1))
            of, known = (np.bincount(np.arange(bins - turn) % turn, each, turn) for each in (score, information))
            for wide in (wide for wide in WIDE if wide < turn):
                here, sure = (sum(np.roll(each, -k) for k in range(wide)) for each in (of, known))
                evidence = np.maximum(here, 0) ** 2 / np.maximum(sure, LEAST)
                best = int(np.argmax(evidence))
                found.append((float(evidence[best]), {"turn": float(turn), "at": float(best), "wide": float(wide)}))
        strength = {"slipped": self.parameter("slipped").start}
        return digits + [strength | where for _, where in sorted(found, key=lambda one: -one[0])[:LIKELY]]


def _filed(counts: np.ndarray, to: np.ndarray, part: np.ndarray) -> np.ndarray:
    """(F, P, T) counts of which a part, (T,) or by zone, is in other bins (T,); beyond the window it is lost."""
    out, there = counts * (1 - part), to < len(to)
    np.add.at(out, (..., to[there]), (counts * part)[..., there])
    return out


effect = MisfiledBins()
