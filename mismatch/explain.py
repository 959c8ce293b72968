"""Where a recording and its simulation differ, and what physics was left out: from frames to a verdict."""

import time
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from mismatch.concluded import concluded
from mismatch.fit import Fit, expected_at, fit, fit_nominal
from mismatch.fluctuation import frame_gain_sigma
from mismatch.form import all_forms
from mismatch.leftover import what_is_left
from mismatch.naming import Contest
from mismatch.refined import enlarged
from mismatch.rivals import likelier_forms
from mismatch.search import searched
from mismatch.selection import Round
from mismatch.simulation import Simulation
from mismatch.verdict import Verdict
from mismatch.work import MOST_RENDERINGS


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
    _, zones, bins = simulation.counts.shape
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
            judged, explained, contests, left = more, better, _in_form(contests, judged, more), ()
            break
    conclude = partial(concluded, simulation, train, test, rounds)
    verdict, _ = conclude(judged, explained, contests, left)
    # What falls short of a name, or a cause outside fits better, may be that name in another form, which nothing else
    # has asked for.
    doubtful = verdict.verdict == "unknown" and judged.forms and not left and not simulation.work.enough
    for more in likelier_forms(train, test, judged, forms) if doubtful else ():
        better, anew = fit(simulation, more.forms, more.x, sigma), _in_form(contests, judged, more)
        again, still = conclude(more, better, anew, what_is_left(simulation, better))
        if again.verdict == "explained" and not still:
            verdict, judged, explained = again, more, better
            break
    verdict = replace(verdict, seconds=time.monotonic() - began, notes=notes)
    if simulation is not every or every.tolerance is not None:
        every = every.as_recorded()
        nominal, explained = (fit(every, one.forms, one.x, sigma, most_steps=0) for one in (nominal, explained))
    return Explanation(verdict, every, train.frames, test.frames, nominal, explained, judged, tuple(rounds))


def _in_form(contests: list[Contest], judged: Fit, more: Fit) -> list[Contest]:
    """Contests of a fit whose last effect has another form."""
    last = judged.forms[-1]
    return [replace(contest, form=more.forms[-1]) if contest.form is last else contest for contest in contests]


def _cut_short(simulation: Simulation) -> tuple[str, ...]:
    """What to say where the search was ended before it had tried all."""
    if not simulation.work.enough:
        return ()
    return (f"the search was ended after {MOST_RENDERINGS} renderings; other causes may not all have been tried",)
