"""Why two calibrations of one sensor disagree."""

import json
from dataclasses import replace

import numpy as np
from scipy.stats import norm

from calibrate.consistency import common_positions
from mismatch.calibrations.choosing import SIGNIFICANT, Candidate, Round, gained, judged, select
from mismatch.calibrations.fitting import Fitted, settled
from mismatch.calibrations.judging import figures, floor, misfits, places, squared
from mismatch.calibrations.pair import Pair, pair
from mismatch.calibrations.verdict import CalibrationVerdict
from mismatch.rivals import LEAST_PROBABILITY
from mismatch.verdict import Alternative, Deviance, Estimate, Named
from recordings.maps import ResponseMaps

NOTES = (
    "Only relations between the two are testable: whatever both share leaves no trace here.",
    "The first is carried to what the second would have seen; the second stays as it is, with its own faults.",
    "Noise is the scatter of samples around their neighbours; structure finer than the scan counts as noise.",
)


def explain_calibrations(
    a: ResponseMaps, b: ResponseMaps, rng: np.random.Generator | None = None
) -> CalibrationVerdict:
    """What makes the first calibration disagree with the second, decided on positions that took no part.

    The first is carried to the second by few named departures; the second is never used at a position to predict it
    there. rng: draws the noise of the floor.
    """
    whole = pair(a, b)
    train, held = whole.of(~whole.held), whole.of(whole.held)
    rounds = select(train, held)
    judge = rounds[-1].before
    first = rounds[0].before
    misfit = misfits(held, judge, SIGNIFICANT)
    named = sorted(_named(train, held, judge, rounds), key=lambda one: -one[0].heldout_gain)
    # The maps that leave this room come from the fit that the figures judge: no held-out position took part in it.
    carried = judge.predicted(whole)
    fits = [_deviances(part, first, judge) for part in (train, held)]
    kind = "unknown" if misfit else ("explained" if judge.departures else "agrees")
    rest = places(whole, judge) if misfit else ()
    maps = _maps(a, b, whole, carried, [one.id for one, _, _ in named])
    return CalibrationVerdict(
        verdict=kind,
        effects=tuple(one for one, _, _ in named),
        multiples=tuple(multiple for _, multiple, _ in named),
        seen_as=tuple(seen for _, _, seen in named),
        located=places(whole, first) if judge.departures else rest,
        unexplained=rest,
        train=fits[0],
        heldout=fits[1],
        gap_closed=_gap(fits[1]) if judge.departures else None,
        before=figures(whole, whole.a, whole.b, whole.held),
        after=figures(whole, carried, whole.b, whole.held),
        floor=floor(whole, whole.held, rng or np.random.default_rng(0)),
        scatter=(first.scatter, judge.scatter),
        positions=(int((~whole.held).sum()), int(whole.held.sum())),
        a=maps[0],
        b=maps[1],
        notes=NOTES,
    )


def _named(train: Pair, held: Pair, judge: Fitted, rounds: list[Round]) -> list[tuple[Named, float, str]]:
    """Each departure of a fit with its rivals, the multiple found on held-out positions, and what is known of it."""
    zones = len(train.a)
    tried = max(r.tried for r in rounds)
    found = []
    for mine, departure in zip(judge.numbers(zones), judge.departures, strict=True):
        kept = tuple(d for d in judge.departures if d is not departure)
        without = settled(train, kept, np.delete(judge.x, np.r_[mine]), judge.scatter)
        multiple, _, p = judged(held, without, judge, tried)
        gain, expected = gained(held, without, judge), gained(train, without, judge) * held.b.size / train.b.size
        errors = np.sqrt(np.maximum(np.diag(judge.covariance)[mine], 0))
        parameters = tuple(
            Estimate(name, float(value), float(error), unit)
            for (name, unit), value, error in zip(departure.labels(zones), judge.x[mine], errors, strict=True)
        )
        turn = next(r for r in rounds if r.chosen is not None and r.chosen.departure is departure)
        one = Named(departure.id, departure.sentence, parameters, gain, p, expected, _look_alikes(held, turn))
        found.append((one, multiple, departure.seen_as))
    return found


def _look_alikes(held: Pair, turn: Round) -> tuple[Alternative, ...]:
    """Other effects that would have stood in a departure's place, by how well they do on tiles held out."""
    chosen = turn.chosen
    texts = {look.id: look.separated_by for look in chosen.departure.look_alikes}
    best: dict[str, float] = {}
    for other in turn.candidates:
        if other.departure.id != chosen.departure.id:
            odds = _better(held, turn.before, other, chosen)
            best[other.departure.id] = max(best.get(other.departure.id, 0.0), odds)
    whole = 1 + sum(best.values())
    return tuple(
        Alternative(name, odds / whole, texts.get(name, "A scan in which only one of the two is changed."))
        for name, odds in sorted(best.items(), key=lambda entry: -entry[1])
        if odds / whole >= LEAST_PROBABILITY
    )


def _better(held: Pair, before: Fitted, other: Candidate, chosen: Candidate) -> float:
    """Odds that another departure is the better one, by the paired difference of the tiles held out."""
    tile = np.unique(held.tile, return_inverse=True)[1]
    gain = (other.fit.cost(held, before.scatter) - chosen.fit.cost(held, before.scatter)).sum(axis=0)
    each = np.bincount(tile, gain)
    error = each.std(ddof=1) * np.sqrt(len(each))
    return float(norm.sf(each.sum() / max(error, 1e-12)) / max(norm.cdf(each.sum() / max(error, 1e-12)), 1e-12))


def _deviances(part: Pair, first: Fitted, judge: Fitted) -> Deviance:
    return Deviance(float(squared(part, first).mean()), float(squared(part, judge).mean()), 1.0)


def _gap(held: Deviance) -> float | None:
    wide = held.nominal - held.floor
    return float((held.nominal - held.explained) / wide) if wide > 0 else None


def _maps(a: ResponseMaps, b: ResponseMaps, whole: Pair, carried: np.ndarray, names: list[str]):
    """Both calibrations at the captures they share: the first carried to the second, in its unit."""
    first, second = common_positions(a, b)
    shape = (*a.zone_grid, len(first))
    note = json.dumps(a.meta | {"brought_to": "the second calibration", "departures_removed": names})

    def cut(maps: ResponseMaps, index: np.ndarray, **changes) -> ResponseMaps:
        """Some captures of maps."""
        names_k = ("xs", "ys", "cap_ids", "position_sigma_px", "position_confidence")
        parts = {n: None if getattr(maps, n) is None else getattr(maps, n)[index] for n in names_k}
        grids = {n: None if getattr(maps, n) is None else getattr(maps, n)[..., index] for n in ("sigma", "flags")}
        return replace(maps, responses=maps.responses[..., index], **grids, **parts, **changes)

    factor = (carried / np.maximum(whole.a, 1e-12)).reshape(shape)
    moved = replace(cut(a, first, meta_json=note), responses=carried.reshape(shape).astype(np.float32))
    if moved.sigma is not None:
        moved = replace(moved, sigma=moved.sigma * factor)
    return moved, cut(b, second)
