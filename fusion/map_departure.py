"""How maps depart from where zones look, if they do."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fusion.map_changes import displaced, reordered, turned
from fusion.map_null import DOUBT_SIGMAS, LEAST_GAIN, SHIFT_SIGMAS, Null
from fusion.map_trials import Scores, Trials, peak_of
from recordings.maps import ResponseMaps

# Flips that are not their own inverse.
BACK = {
    "rows for columns and left-right": "rows for columns and up-down",
    "rows for columns and up-down": "rows for columns and left-right",
}


@dataclass(frozen=True, eq=False)
class Departure:
    """One thing that is wrong with maps.

    kind: shifted, mirrored or exchanged. sentence: what it is. gain: how much better the recording fits without it,
    log-likelihood. chance: what such a gain stays below where maps are right. undo: makes right maps of wrong ones.
    redone: the gain of making the same mistake, in scores of maps put right; None where that says little.
    values: numbers and names of it.
    """

    kind: str
    sentence: str
    gain: float
    chance: float
    undo: Callable[[ResponseMaps], ResponseMaps]
    redone: Callable[[Scores], float] | None
    values: dict


def departure(trials: Trials, null: Null) -> Departure | None:
    """The departure that explains most; None where nothing exceeds noise and the model's errors."""
    found = [each(trials, null) for each in (_mirrored, _exchanged, _shifted)]
    found = [one for one in found if one is not None and one.gain > max(one.chance, LEAST_GAIN)]
    if not found:
        return None
    best = max(one.gain for one in found)
    # In this order: a mirror is an exchange of many zones, and the shorter story.
    return next(one for one in found if one.gain > best - LEAST_GAIN)


def _mirrored(trials: Trials, null: Null) -> Departure | None:
    """Maps turned over, in the order of zones or in the image."""
    seen = trials.observed
    gains = seen.mirror_gain
    if not gains:
        return None
    name = max(gains, key=gains.get)
    in_order = seen.order.get(name, -np.inf) >= seen.image.get(name, -np.inf)
    how = "in the order of their zones" if in_order else "in the image"
    undo = partial(reordered, order=trials.orders[name]) if in_order else partial(turned, name=name)
    chance = null.over(lambda one: max(one.mirror_gain.values()))
    sentence, values = f"the maps are mirrored {name}, {how}", {"mirror": name, "of": how}
    return Departure(
        "mirrored", sentence, gains[name], chance, undo, lambda one: one.mirror_gain[BACK.get(name, name)], values
    )


def _exchanged(trials: Trials, null: Null) -> Departure | None:
    """Zones that look where the maps say others do."""
    seen = trials.observed
    order, own = np.arange(len(seen.table)), np.arange(len(seen.table))
    chance = max(null.over(lambda one: one.order_gain), LEAST_GAIN)
    gain, groups = 0.0, []
    for cycle in _cycles(seen.assignment):
        looks = seen.assignment[cycle]
        adds = float(seen.table[cycle, looks].sum() - seen.table[cycle, cycle].sum())
        if adds > chance:
            order[cycle], gain = looks, gain + adds
            groups.append([int(zone) for zone in cycle])
    if (order == own).all():
        return None
    told = "; ".join(" and ".join(str(zone) for zone in group) for group in groups)
    if any(len(group) > 2 for group in groups):
        sentence = f"the maps of zones {told} are in another order: zones {_pairs(order)}"
    else:
        sentence = f"the maps of zones {told} are exchanged"
    values = {"zones": groups, "looks_like_zone": order.tolist()}
    zones = np.arange(len(order))
    back = np.argsort(order)

    def redone(one: Scores) -> float:
        return float(one.table[zones, back].sum() - np.trace(one.table))

    return Departure("exchanged", sentence, gain, chance, partial(reordered, order=order), redone, values)


def _shifted(trials: Trials, null: Null) -> Departure | None:
    """All maps displaced in the image."""
    gain = trials.observed.shift_gain
    away, inside = _displaced(trials, null)
    chance = null.over(lambda one: float(one.shift_gain.max()), SHIFT_SIGMAS)
    found = _shift(away, null, inside, float(gain.max()), chance)
    return found if found.values["sigmas"] > SHIFT_SIGMAS else None


def doubt(trials: Trials, null: Null) -> str | None:
    """A shift that is not certain, and too likely to call maps right, in words; None where there is none."""
    away, inside = _displaced(trials, null)
    maybe = _shift(away, null, inside, 0.0, 0.0)
    if maybe.values["sigmas"] < DOUBT_SIGMAS:
        return None
    return f"{maybe.sentence}, unless that is chance".replace(" are ", " may be ", 1)


def _displaced(trials: Trials, null: Null) -> tuple[np.ndarray, bool]:
    """(2,) x, y in pixels by which footprints fit best elsewhere, and whether that lies within what was tried."""
    place, inside = peak_of(trials.observed.shift_gain)
    return place - null.shift[0], inside


def _shift(away: np.ndarray, null: Null, inside: bool, gain: float, chance: float) -> Departure:
    """That the maps are displaced, by minus (2,) pixels: footprints fit where they are moved to."""
    sigma = np.sqrt(np.diag(null.shift[1]))
    x, y = -away
    more = "" if inside else "at least "
    sentence = (
        f"the maps are shifted by {more}dx = {x:+.0f} ± {sigma[0]:.0f} px (right) "
        f"and dy = {y:+.0f} ± {sigma[1]:.0f} px (down)"
    )
    sigmas = float(np.sqrt(away @ np.linalg.solve(null.shift[1], away)))
    values = {"shift_px": [float(x), float(y)], "sigma_px": sigma.tolist(), "sigmas": sigmas, "within_reach": inside}
    return Departure("shifted", sentence, gain, chance, partial(displaced, shift_px=away), None, values)


def settled(found: Departure, trials: Trials, null: Null) -> Departure:
    """A departure as it looks from where it was put right: a shift is known best from there."""
    if found.kind != "shifted":
        return found
    more, inside = _displaced(trials, null)
    return _shift(more - np.array(found.values["shift_px"]), null, inside, found.gain, found.chance)


def joined(found: list[Departure], step: Departure) -> list[Departure]:
    """What was found so far, and one more; a shift beyond what is tried at once is found in parts, and is one."""
    if not found or not found[-1].kind == step.kind == "shifted":
        return [*found, step]
    whole = step.values | {"shift_px": found[-1].values["shift_px"]}
    return [*found[:-1], replace(step, values=whole, gain=found[-1].gain + step.gain)]


def _cycles(order: np.ndarray) -> list[np.ndarray]:
    """The cycles of a permutation, without those of one zone."""
    left, found = set(range(len(order))), []
    while left:
        cycle, at = [], min(left)
        while at in left:
            left.remove(at)
            cycle.append(at)
            at = int(order[at])
        if len(cycle) > 1:
            found.append(np.array(cycle))
    return found


def _pairs(order: np.ndarray) -> str:
    """Which zone looks where which map says."""
    moved = np.flatnonzero(order != np.arange(len(order)))
    return ", ".join(f"{p} looks where the map of {order[p]} says" for p in moved)
