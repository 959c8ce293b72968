"""Where a misfit sits and what it goes with: divisions of the cells that explain it, one after the other."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2, norm

from mismatch.fit import Fit
from mismatch.noise import Nuisances
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation
from mismatch.tables import Table, tables

SIGNIFICANT = 1e-3
MOST_PLACES = 4
# A place holds this part of the misfit that its division shows.
HELD = 0.8
# Standard deviations from which a group's excess counts as misfit, and how much of that noise gives each group: the
# mean of z² - 1 where |z| is more.
CLEAR = 2.0
BY_NOISE = 2 * CLEAR * float(norm.pdf(CLEAR))
FOLLOWS = {
    "signal": "signal", "arrival_bins": "range", "phase": "bin_phase", "incidence": "incidence",
    "reflectance": "reflectance", "neighbours": "neighbours", "frame": "time", "time": "time",
}  # fmt: skip
WORDS = {
    "signal": "how much light the zone receives", "range": "range", "bin_phase": "where in its bin the pulse falls",
    "incidence": "the angle at which surfaces are met", "reflectance": "the reflectance of surfaces",
    "neighbours": "how much light the other zones receive", "time": "time",
    "position": "the zone, hence the place in the image",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Place:
    """A part of the misfit.

    zones: indices. bins, frames: first and last, both inclusive. follows: what it goes with. share: of the misfit that
    all places show. p_value: after correction for having looked everywhere. excess: relative, of recorded over
    simulated counts there. change: (F, P, T) counts by which the recording differs, smoothed by the division.
    gain: deviance that goes with it. foreign: whether no formula of what was explained could have left it.
    """

    zones: tuple[int, ...]
    bins: tuple[int, int]
    frames: tuple[int, int]
    follows: str
    share: float
    p_value: float
    gain: float
    sentence: str
    foreign: bool = False


def places(simulation: Simulation, fitted: Fit) -> list[Place]:
    """Divisions of the cells that explain what a fit leaves, the most telling first; none where noise explains it."""
    found: list[Place] = []
    counts, now = simulation.counts, fitted
    for _ in range(MOST_PLACES):
        looked = tables(replace(simulation, counts=counts), now)
        best = max(looked, key=_evidence)
        p = min(1.0, best.p_value * len(looked))
        if p > SIGNIFICANT or _evidence(best) <= 0:
            break
        change, gain = _change(simulation, fitted, best)
        if not change.any():  # Its noise explains each of its groups.
            break
        found.append(_place(simulation, fitted, best, change, gain, p))
        # What is found is taken out, so that the next division shows what is left.
        counts = counts - change
    total = sum(place.gain for place in found)
    return [told(replace(place, share=place.gain / total)) for place in found]


def _evidence(table: Table) -> float:
    """Gain of the division less what noise gives it, less the price of its groups that matter."""
    return -np.log(max(table.p_value, 1e-300)) if table.p_value > 1e-290 else (table.chi2 - table.expected) / 2


def _change(simulation: Simulation, fitted: Fit, table: Table) -> tuple[np.ndarray, float]:
    """(F, P, T) counts of difference that the division tells, shrunk by its own noise; and deviance it explains."""
    noise2 = np.maximum(table.noise**2, LEAST)
    z2 = table.excess**2 / noise2
    # Empirical Bayes: of the squared residuals, the part beyond noise (James and Stein 1961, positive part).
    shrink = max(0.0, 1 - table.expected / max(table.chi2, 1e-9))
    local = shrink * np.maximum(0, 1 - 1 / np.maximum(z2, 1e-9))
    clear = z2 > CLEAR**2
    gain = float((z2 - 1)[clear].sum()) - BY_NOISE * z2.size
    mean = np.maximum(Nuisances(simulation, fitted.frame_gain_sigma).applied(fitted.expected), LEAST)
    return mean * (local * table.excess / noise2)[table.division.group], max(gain, 1e-9)


def _place(simulation: Simulation, fitted: Fit, table: Table, change: np.ndarray, gain: float, p: float) -> Place:
    """Zones, bins and frames that hold most of a change."""
    zones, bins, frames = extent(change, fitted.expected)
    follows = next((FOLLOWS[axis] for axis in table.division.axes if axis in FOLLOWS), "nothing")
    if follows == "nothing" and "zone" in table.division.axes and "bin" not in table.division.axes:
        follows = "position"
    return Place(zones, bins, frames, follows, 1.0, p, gain, "")


def extent(change: np.ndarray, expected: np.ndarray) -> tuple[tuple[int, ...], tuple[int, int], tuple[int, int]]:
    """Zones, first and last bin, first and last frame that hold most of the misfit change²/expected, (F, P, T)."""
    energy = change**2 / np.maximum(expected, LEAST)
    by_zone = energy.sum(axis=(0, 2))
    order = np.argsort(by_zone)[::-1]
    held = np.cumsum(by_zone[order]) >= 0.95 * by_zone.sum()
    zones = tuple(sorted(int(z) for z in order[: int(np.argmax(held)) + 1]))
    return zones, _interval(energy.sum(axis=(0, 1))), _interval(energy.sum(axis=(1, 2)))


def _interval(energy: np.ndarray) -> tuple[int, int]:
    """The shortest stretch that holds most of it."""
    until = np.concatenate([[0], np.cumsum(energy)])
    if not until[-1] > 0:  # Nothing anywhere is no shorter in one place than in another.
        return 0, len(energy) - 1
    ends = np.searchsorted(until, until + HELD * until[-1] - 1e-12 * until[-1])
    lengths = np.where(ends < len(until), ends - np.arange(len(until)), len(until) + 1)
    start = int(np.argmin(lengths))
    return start, max(start, int(ends[start]) - 1)


def wherever(simulation: Simulation, p_value: float, sentence: str, foreign: bool = False) -> Place:
    """A misfit that has no place."""
    frames, zones, bins = simulation.counts.shape
    gain = float(chi2.isf(max(p_value, 1e-300), 1))
    return Place(tuple(range(zones)), (0, bins - 1), (0, frames - 1), "nothing", 1.0, p_value, gain, sentence, foreign)


def told(place: Place) -> Place:
    """With its sentence."""
    many = "zone" if len(place.zones) == 1 else "zones"
    zones = f"{many} {', '.join(str(z) for z in place.zones)}"
    bins = f"bins {place.bins[0]} to {place.bins[1]}" if place.bins[1] > place.bins[0] else f"bin {place.bins[0]}"
    goes = "whatever the scene" if place.follows == "nothing" else f"going with {WORDS[place.follows]}"
    frames = f"frames {place.frames[0]} to {place.frames[1]}"
    return replace(place, sentence=f"{zones}, {bins}, {frames}, {goes}: {100 * place.share:.0f} % of the misfit")


def significance(z: float, tried: int) -> float:
    """One-sided p-value of a normal statistic, corrected for how many were tried."""
    return float(min(1.0, tried * norm.sf(z)))
