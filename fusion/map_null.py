"""What scores would be if the maps were right: recordings made up with photon noise and a reflectance nobody knows."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fusion.map_changes import STEP_PX, shifts_px
from fusion.map_trials import Scores, Trials, peak_of

REPLICATES, FEW = 32, 4
# Spreads of reflectance, log-normal, that are tried; beyond the last no scene is likely to be.
SPREADS = (0.1, 0.25, 0.5, 0.8, 1.2)
# What differs from expectation by so many standard deviations is not chance.
SIGMAS = 4.0
# The same for a shift in two directions at once: 2 in 1000.
SHIFT_SIGMAS = 3.5
# Beyond this maps are not called right: 4 in 100. A shift by SHOWN_SIGMAS lies beyond it in 95 cases of 100.
DOUBT_SIGMAS, SHOWN_SIGMAS = 2.5, 4.1
# Log-likelihood below which nothing is claimed: odds of 1 to 400.
LEAST_GAIN = 6.0
# Where a shift is found, it is known no better: pixels of the full-size image.
LEAST_SIGMA_PX = 1.0
# The shift that a check should not miss.
TOLD_PX = 12.0


@dataclass(frozen=True, eq=False)
class Null:
    """Scores of made-up recordings of one scene that the maps are right about.

    spread: standard deviation of the logarithm of reflectance, such that made-up recordings fit as badly as the one
    that was checked at its best. scores: (REPLICATES,). implausible: the same at the largest spread there is.
    """

    spread: float
    scores: list[Scores]
    implausible: list[Scores]

    def over(self, figure: Callable[[Scores], float], sigmas: float = SIGMAS) -> float:
        """What a figure stays below where maps are right."""
        values = [figure(one) for one in self.scores]
        return float(np.mean(values) + sigmas * np.std(values, ddof=1))

    def mean(self, figure: Callable[[Scores], float]) -> float:
        """What a figure is on average where maps are right."""
        return float(np.mean([figure(one) for one in self.scores]))

    def least_plausible(self, figure: Callable[[Scores], float], sigmas: float) -> float:
        """What a figure stays above where maps are right, whatever the reflectance."""
        values = [figure(one) for one in self.implausible]
        return float(np.mean(values) - sigmas * np.std(values, ddof=1))

    @property
    def shift(self) -> tuple[np.ndarray, np.ndarray]:
        """(2,) mean x, y and (2, 2) covariance of the shift that fits best where there is none, pixels."""
        places = np.array([peak_of(one.shift_gain)[0] for one in self.scores])
        # Few replicates: standard deviations are known to an eighth of themselves.
        return places.mean(axis=0), np.cov(places.T) + LEAST_SIGMA_PX**2 * np.eye(2)

    def told(self, figure: Callable[[Scores], float]) -> bool:
        """Whether a change of maps would be noticed: its gain is far below 0 where maps are right."""
        return self.mean(figure) < -LEAST_GAIN and self.over(figure, 2.0) < 0

    @property
    def shift_told(self) -> bool:
        """Whether a shift by TOLD_PX would be noticed."""
        _, covariance = self.shift
        sigma = float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
        return self.mean(shift_loss) < -LEAST_GAIN and SHOWN_SIGMAS * sigma < TOLD_PX

    @property
    def mirrors_told(self) -> dict[str, bool]:
        """By name, whether maps so mirrored would be noticed."""
        return {name: self.told(lambda one, n=name: one.mirror_gain[n]) for name in self.scores[0].mirror_gain}

    @property
    def pairs_untold(self) -> list[tuple[int, int]]:
        """Zones that could be exchanged for one another without notice."""
        gain = np.mean([one.pair_gain for one in self.scores], axis=0)
        first, second = np.nonzero(np.triu(gain > -LEAST_GAIN, 1))
        return list(zip(first.tolist(), second.tolist(), strict=True))


def shift_loss(scores: Scores) -> float:
    """The gain of the least harmful shift by about TOLD_PX along an axis."""
    away, middle = round(TOLD_PX / STEP_PX), len(shifts_px()) // 2
    near, far = middle - away, middle + away
    gain = scores.shift_gain
    return float(max(gain[near, middle], gain[far, middle], gain[middle, near], gain[middle, far]))


def null_of(trials: Trials, rng: np.random.Generator) -> Null:
    """Made-up recordings for what was tried."""
    seen = trials.observed
    gains = (0.0, seen.shift_gain.max(), seen.order_gain, max(seen.mirror_gain.values(), default=0.0))
    best = float(seen.base.sum() + max(gains))
    few = [[trials.made_up(spread, rng) for _ in range(FEW)] for spread in SPREADS]
    level = [np.mean([one.base.sum() for one in some]) for some in few]
    # A wider spread fits worse; numpy wants ascending levels.
    spread = float(np.interp(-best, -np.array(level), SPREADS))
    scores = [trials.made_up(spread, rng) for _ in range(REPLICATES)]
    return Null(spread, scores, few[-1] + [trials.made_up(SPREADS[-1], rng) for _ in range(2 * FEW)])
