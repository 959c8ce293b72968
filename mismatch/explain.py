"""Where a recording and its simulation differ, and what physics was left out: from frames to a verdict."""

import time
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from mismatch.candidates import MINOR, MINOR_PART
from mismatch.doubts import doubts
from mismatch.fit import Fit, expected_at, fit, fit_nominal, on_others
from mismatch.fluctuation import frame_gain_sigma
from mismatch.form import all_forms
from mismatch.leftover import NEGLIGIBLE, what_is_left
from mismatch.located import locate_effects
from mismatch.looks import blur
from mismatch.naming import name_effects, next_measurement
from mismatch.outside.told import told_outside
from mismatch.poisson import expected_deviance
from mismatch.refined import enlarged
from mismatch.search import searched
from mismatch.selection import MOST_EFFECTS, Round
from mismatch.simulation import Simulation
from mismatch.unseen import marginal_deviance
from mismatch.verdict import Deviance, Verdict
from mismatch.visibility import not_visible
from mismatch.work import MOST_RENDERINGS

# No more of what was explained is negligible.
A_QUARTER = 0.25
# Nor is more deviance than this negligible on frames held out, whatever was explained.
LARGE = 500.0
# What may be left, as such a part of what effects explained that leave to be guessed what nobody saw: frames tell
# roughly how far off guesses are.
NOT_SEEN = 0.15
# How many times what another formula gains may be left where that is said to take it up.
TAKEN_UP = 2.0


@dataclass(frozen=True, eq=False)
class Explanation:
    """A verdict, and the models behind it.

    simulation: all frames. chosen, held: indices of the frames that chose and those that judged. nominal, explained:
    fits of all frames, without and with the effects that were found. judged: fit of the frames that chose alone.
    rounds: how the effects were chosen.
    """

    verdict: Verdict
    simulation: Simulation
    chosen: np.ndarray
    held: np.ndarray
    nominal: Fit
    explained: Fit
    judged: Fit
    rounds: tuple[Round, ...]


def explain(simulation: Simulation, notes: tuple[str, ...] = ()) -> Explanation:
    """The verdict on a recording beside its simulation. notes: what was assumed, in sentences."""
    # Matrices are slim; threads for them would wait on those that render.
    with threadpool_limits(1, user_api="blas"):
        return _explain(simulation, notes, time.monotonic())


def _explain(simulation: Simulation, notes: tuple[str, ...], began: float) -> Explanation:
    """See `explain`."""
    frames, zones, bins = simulation.counts.shape
    given = tuple(setting.effect.id for setting in simulation.given)
    forms = all_forms({"zone": zones, "bin": bins}, without=given, guessed=simulation.guessed)
    simulation, found = searched(simulation, forms)
    train, test, rounds, judged, contests = found.train, found.test, found.rounds, found.judged, found.contests
    every, simulation = simulation, found.simulation
    notes = (*notes, *found.notes, *_cut_short(simulation))  # Here, as what follows renders more and searches no more.
    # All frames tell better than those that chose how much the gain fluctuates; what is left is judged by that.
    sigma = frame_gain_sigma(simulation, expected_at(simulation, judged.forms, judged.x))
    nominal = fit_nominal(simulation, sigma)
    explained = fit(simulation, judged.forms, judged.x, sigma) if judged.forms else nominal
    left = what_is_left(simulation, explained)
    if left and not judged.forms and (slow := frame_gain_sigma(simulation, nominal.expected, slow=True)) > sigma:
        # No cause was found: what is left may be noise of the frames' gains that was slow by chance.
        calm = fit_nominal(simulation, slow)
        if not what_is_left(simulation, calm):
            sigma, nominal, explained, left = slow, calm, calm, ()
    # What differs by little costs more numbers than half of the frames see worth, or shows in all of them alone.
    for more in enlarged(train, test, judged, forms) if left and judged.forms else ():
        better = fit(simulation, more.forms, more.x, sigma)
        if not what_is_left(simulation, better):
            last = judged.forms[-1]
            contests = [replace(c, form=more.forms[-1]) if c.form is last else c for c in contests]
            judged, explained, left = more, better, ()
            break
    tried = max(one.tried for one in rounds)
    effects = name_effects(train, test, judged, contests, explained, tried)
    first = fit_nominal(train, judged.frame_gain_sigma)
    uncertain = blur(simulation, explained.gain, explained.settings)
    remains = max(sum(place.gain for place in left) - uncertain, 0.0) * len(test.frames) / frames
    won = marginal_deviance(test, first) - marginal_deviance(test, judged)
    missing = remains + judged.numbers - 1 + (0.0 if judged.pattern is None else judged.pattern.effective)
    kind = "explained" if judged.forms else "agrees"
    # What another formula of the same cause would take up.
    minor = rounds[-1].minor
    most = min(max(MINOR, MINOR_PART * won), A_QUARTER * won)
    small = minor is not None and remains < min(most, TAKEN_UP * minor.observed)
    doubted = doubts(simulation, explained, effects)
    guesses = {setting.effect.id for setting in judged.settings if setting.effect.owns_up(setting.values)}
    guessed = sum(effect.heldout_gain for effect in effects if effect.id in guesses)
    negligible = (small or remains < little(won, guessed)) and not any(place.foreign for place in left)
    # As many causes as there may be, and still something: none of them need be there.
    negligible &= len(judged.forms) < MOST_EFFECTS
    if doubted or (left and not (judged.forms and negligible)):
        kind = "unknown"
    if kind != "agrees":
        outside = told_outside(simulation, train, test, judged, beside=kind == "unknown")
        kind, doubted = "unknown" if outside else kind, (*doubted, *outside)
    verdict = Verdict(
        verdict=kind,
        located=locate_effects(simulation, explained, effects) if judged.forms else left,
        effects=effects,
        train=_deviances(train, first, judged, missing),
        heldout=(heldout := _deviances(test, first, judged, missing)),
        gap_closed=_closed(heldout) if judged.forms else None,
        unexplained=(*left, *doubted),
        not_visible=not_visible(rounds[-1].scores, len(train.frames) / frames),
        next_measurement=next_measurement(train, contests),
        seconds=time.monotonic() - began,
        notes=notes,
    )
    if simulation is not every:
        nominal, explained = (fit(every, one.forms, one.x, sigma, most_steps=0) for one in (nominal, explained))
    return Explanation(verdict, every, train.frames, test.frames, nominal, explained, judged, tuple(rounds))


def little(won: float, guessed: float) -> float:
    """Deviance on frames held out that does not make an explanation unknown which gained `won` there.

    guessed: how much of that is of effects which leave to be guessed what nobody saw.
    """
    return max(NOT_SEEN * guessed, min(NEGLIGIBLE * won, LARGE))


def _cut_short(simulation: Simulation) -> tuple[str, ...]:
    """What to say where the search was ended before it had tried all."""
    if not simulation.work.enough:
        return ()
    return (f"the search was ended after {MOST_RENDERINGS} renderings; other causes may not all have been tried",)


def _deviances(part: Simulation, first: Fit, judged: Fit, missing: float) -> Deviance:
    """Per cell, of some frames, all counts trusted.

    The floor: as explained, less what parameters' errors cost and what is left. It is no lower than photon noise alone
    would make it on average, where a misfit is large.
    """
    part = part.trusting(None)
    nominal, (expected, explained) = on_others(part, first)[1], on_others(part, judged)
    noise = float(expected_deviance(expected)[0].sum())
    floor = max(explained - missing, min(noise, explained))
    zones = part.counts.shape[1]
    alive = 1.0 if part.dead is None else float((~part.dead).sum()) / zones
    cells = part.counts.size * alive
    return Deviance(*(total / cells for total in (nominal, explained, floor)))


def _closed(fit: Deviance) -> float:
    """Of the way from the nominal model to the floor, the part that was gone."""
    return float(np.clip((fit.nominal - fit.explained) / max(fit.nominal - fit.floor, 1e-12), 0, 1))
