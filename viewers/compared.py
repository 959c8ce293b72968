"""A recording beside its simulation, before and after the effects that were found: the sums that pictures show."""

from dataclasses import dataclass

import numpy as np

from mismatch.explain import Explanation
from mismatch.noise import Nuisances
from mismatch.poisson import deviance, expected_deviance, signed


@dataclass(frozen=True, eq=False)
class Compared:
    """Counts (F, P, T): recorded, and simulated by the nominal model and by the explained one.

    Where the data show that gain fluctuates from frame to frame, simulated frames have their own gains.
    frames: (F,) numbers in the recording. time_s: (F,). chosen: (F,) whether it took part in choosing and fitting.
    """

    recorded: np.ndarray
    before: np.ndarray
    after: np.ndarray
    frames: np.ndarray
    time_s: np.ndarray
    chosen: np.ndarray

    @property
    def improvement(self) -> np.ndarray:
        """(F, P) deviance that the effects gain."""
        return (deviance(self.recorded, self.before) - deviance(self.recorded, self.after)).sum(axis=2)

    @property
    def remaining(self) -> np.ndarray:
        """(F, P) deviance that is left, less what noise gives."""
        return (deviance(self.recorded, self.after) - expected_deviance(self.after)[0]).sum(axis=2)

    def by_frame(self) -> dict[str, np.ndarray]:
        """(F,) deviance per cell before and after, and what Poisson noise around the latter gives."""
        return {
            "before": deviance(self.recorded, self.before).mean(axis=(1, 2)),
            "after": deviance(self.recorded, self.after).mean(axis=(1, 2)),
            "noise": expected_deviance(self.after)[0].mean(axis=(1, 2)),
        }

    def residuals(self, axis: int) -> tuple[np.ndarray, np.ndarray]:
        """Signed deviance before and after, of counts summed over the frames (axis 0) or the zones (axis 1)."""
        recorded = self.recorded.sum(axis=axis)
        return signed(recorded, self.before.sum(axis=axis)), signed(recorded, self.after.sum(axis=axis))


def compared(explanation: Explanation) -> Compared:
    """What an explanation compares."""
    simulation = explanation.simulation
    simulated = [
        Nuisances(simulation, fit.frame_gain_sigma).applied(fit.expected)
        for fit in (explanation.nominal, explanation.explained)
    ]
    frames = np.asarray(simulation.frames)
    chosen = np.isin(np.arange(len(frames)), explanation.chosen)
    return Compared(simulation.counts, *simulated, frames, np.asarray(simulation.light.time_s, float), chosen)


def telling(shown: Compared, kind: str, most: int = 6) -> list[tuple[int, int]]:
    """(frame, zone) indices worth a picture: where the effects gain most; half of them where most is left if that is
    unknown, all of them if nothing was found. At most two of a zone.
    """
    gained = bool(np.abs(shown.improvement).max() > 0)
    wanted = [(shown.improvement, most)] if gained else [(shown.remaining, most)]
    if gained and kind == "unknown":
        wanted = [(shown.improvement, most // 2), (shown.remaining, most - most // 2)]
    found: list[tuple[int, int]] = []
    for values, count in wanted:
        mine: list[tuple[int, int]] = []
        for index in np.argsort(-values, axis=None):
            frame, zone = (int(i) for i in np.unravel_index(index, values.shape))
            if (frame, zone) not in found and sum(z == zone for _, z in mine) < 2:
                mine.append((frame, zone))
            if len(mine) == count:
                break
        found += mine
    return found


def bins_of_interest(shown: Compared) -> slice:
    """Bins that hold nearly all signal and nearly all that changed, and a few beside them."""
    peak = shown.before.sum(axis=(0, 1))
    signal = np.maximum(peak - np.median(peak), 0)
    change = (
        (shown.recorded.sum(axis=0) - shown.before.sum(axis=0)) ** 2 / np.maximum(shown.before.sum(axis=0), 1)
    ).sum(axis=0)
    change = np.where(change > 5 * shown.recorded.shape[1], change, 0)
    ends = []
    for weight in (signal, change):
        if weight.sum() > 0:
            part = np.cumsum(weight) / weight.sum()
            ends += [int(np.searchsorted(part, 0.002)), int(np.searchsorted(part, 0.998))]
    if not ends:
        return slice(0, len(peak))
    return slice(max(0, min(ends) - 4), min(len(peak), max(ends) + 5))
