"""The search for effects: on some frames, judged by others, anew where a cause leaves counts uncertain."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mismatch.beginnings import likeliest_selection, unjudged
from mismatch.between_frames import placed
from mismatch.blocks import finer, halves
from mismatch.clock_slopes import loosened
from mismatch.economy import economical
from mismatch.fit import Fit, expected_at, fit, fit_nominal
from mismatch.fluctuation import frame_gain_sigma
from mismatch.form import Form
from mismatch.gained import falls_short
from mismatch.leftover import NEGLIGIBLE, what_is_left
from mismatch.likelier_response import likelier_clock
from mismatch.naming import Contest, contested
from mismatch.places import Place
from mismatch.poisson import deviance
from mismatch.reordered import told_in_order
from mismatch.selection import Round, onward, without
from mismatch.simulation import Simulation
from mismatch.tolerance import in_words, is_near, tolerated
from mismatch.trust import as_given, trusted
from mismatch.unseen import owns_up
from mismatch.work import MOST_RENDERINGS, Work

ONE_BY_ONE = "what is amiss shows in few frames; single frames were held out, not blocks of them"
# A search that took so many renderings is not made a second time; what leaves less than this part is better.
SOON, MUCH_LESS = 2000, 0.3
# Standard deviations by which a cause must stand out on frames held out that is likelier for what it leaves uncertain.
AS_WELL = 2.0
UNCERTAIN = "counts of which nobody saw what was there when they were taken are trusted less"


@dataclass(frozen=True, eq=False)
class Search:
    """What a search came to.

    simulation: all frames, as far as they are trusted. train, test: those that chose and those that were held out.
    rounds: how effects were chosen. judged: the fit of those that chose. contests: of each of its effects. notes: how
    it was done, in sentences.
    """

    simulation: Simulation
    train: Simulation
    test: Simulation
    rounds: list[Round]
    judged: Fit
    contests: list[Contest]
    notes: tuple[str, ...]


def searched(simulation: Simulation, forms: list[Form]) -> tuple[Simulation, Search]:
    """The effects, of all that there are, that stand in a recording; and its simulation, as it was searched.

    A response that was estimated holds what was amiss when nobody knew of it, and beside the cause that takes a name of
    its own, or is left. Then it is estimated anew, beside what explains most, and all is sought once more. One that is
    loose hides no name, but is off all the same, and the model that was found is to have it right. That may take what
    the first search left of all a search may cost, or half of it.

    Where the nominal model is far off counts are trusted less at first (`mismatch/tolerance.py`), and in the end, too,
    unless what is found turns out to be right to within noise.
    """
    simulation = told_in_order(simulation)
    tolerant, error = tolerated(simulation)
    if error:
        tolerant = replace(economical(tolerant), work=Work())
        found = search(tolerant, forms)
        if not is_near(found.train, found.judged):
            return tolerant, replace(found, notes=(*found.notes, in_words(error)))
    cheap = replace(economical(simulation), work=Work())
    found = search(cheap, forms)
    names = found.judged.forms
    loose = simulation.loose is not None
    if simulation.guessed and names and (loose or len(names) > 1 or what_is_left(found.train, found.judged)):
        most = max(range(len(names)), key=lambda i: without(found.train, found.judged, names[i], 0).deviance)
        clock = likelier_clock(simulation, found.judged.gain, (found.judged.settings[most],))
        anew = replace(simulation, clock=clock)
        spent = Work(min(cheap.work.renderings, MOST_RENDERINGS / 2))
        cheap = replace(economical(loosened(anew) if loose else anew), work=spent)
        found = search(cheap, forms)
    return cheap, _leaving_less(cheap, found, forms)


def _leaving_less(simulation: Simulation, found: Search, forms: list[Form]) -> Search:
    """What was found, or what is where single frames are held out, if that leaves much less.

    What shows in few frames may lie on one side where blocks are held out, among those that choose or those that judge.
    A response that was estimated has seen some of these single frames, which then could not judge.
    """
    frames = len(simulation.counts)
    alike = np.array_equal(halves(frames)[0], halves(frames, frames)[0])
    if alike or simulation.guessed or ONE_BY_ONE in found.notes or simulation.work.renderings > SOON:
        return found
    before, won = _left(found), fit_nominal(found.train).deviance - found.judged.deviance
    # Another formula of what was found leaves as much.
    if before <= NEGLIGIBLE * won * frames / len(found.train.frames):
        return found
    anew = search(simulation, forms, singly=True)
    return anew if _left(anew) < MUCH_LESS * before else found


def _left(found: Search) -> float:
    """Deviance that is left in all frames."""
    return sum(place.gain for place in _places(found.simulation, found.judged))


def _places(every: Simulation, judged: Fit) -> tuple[Place, ...]:
    """What a fit leaves in all frames."""
    sigma = frame_gain_sigma(every, expected_at(every, judged.forms, judged.x))
    return what_is_left(every, fit(every, judged.forms, judged.x, sigma))


def search(simulation: Simulation, forms: list[Form], singly: bool = False) -> Search:
    """The effects, of all that there are, that stand in a recording.

    singly: whether single frames are held out from the first, not blocks of them.
    """
    frames, simulation = len(simulation.counts), as_given(simulation)
    train, test = (simulation.of(some) for some in (halves(frames, frames) if singly else halves(frames)))
    others = [] if singly else finer(frames)
    rounds, notes = likeliest_selection(train, test, forms, last=not others), (ONE_BY_ONE,) if singly else ()
    while others and (alone := unjudged(rounds[-1])) is not None:
        others.sort(key=partial(_shown_by_both, simulation, rounds[-1].before, alone.fit))
        parts = [simulation.of(part) for part in others.pop()]
        anew = likeliest_selection(*parts, forms, last=not others)
        # A search that was ended before it began tells nothing.
        if anew[-1].before.forms or not rounds[-1].before.forms or not simulation.work.enough:
            (train, test), rounds, notes = parts, anew, (ONE_BY_ONE,)
    uncertain = simulation.tolerance is None and _uncertain(simulation, train, rounds[-1].before)
    there = trusted(simulation, train, test, rounds) if uncertain else None
    if there is not None:
        again = [there[0].of(part.frames) for part in (train, test)]
        # There may be no more search left in it than to go on from there.
        anew = onward(*again, forms, there[2], there[1]) if simulation.work.enough else _beside(*again, forms, there[1])
        if owns_up(anew[-1].before):
            simulation, (train, test), rounds, notes = there[0], again, anew, (*notes, UNCERTAIN)
    judged, contests = contested(train, test, rounds[-1].before, rounds, forms)
    timed = placed(simulation, train, judged)
    anew = dict(zip(judged.forms, timed.forms, strict=True))
    contests = [replace(contest, form=anew[contest.form]) for contest in contests]
    return Search(simulation, train, test, rounds, timed, contests, notes)


def _uncertain(simulation: Simulation, train: Simulation, found: Fit) -> bool:
    """Whether something is left that may be what nobody saw; in any frame, where a cause says that there is such."""
    return bool(what_is_left(train, found) or (owns_up(found) and _places(simulation, found)))


def _shown_by_both(simulation: Simulation, before: Fit, after: Fit, parts: tuple[np.ndarray, np.ndarray]) -> float:
    """Deviance that one fit gains over another in that of two parts of the frames in which it gains less."""
    lost, left = (deviance(simulation.counts, expected_at(simulation, one.forms, one.x)) for one in (before, after))
    gained = (lost - left).sum(axis=(1, 2))
    return float(min(gained[part].sum() for part in parts))


def _beside(train: Simulation, test: Simulation, forms: list[Form], owning: Fit) -> list[Round]:
    """How effects are chosen from counts trusted as far as a cause lets them be.

    Where what it leaves uncertain is all that is amiss there is little left to choose it by: it has been, if frames
    held out say so, too.
    """
    rounds = likeliest_selection(train, test, forms)
    last = rounds[-1]
    same = [c for c in last.candidates if c.form.effect is owning.forms[-1].effect]
    if last.before.forms or not same:
        return rounds
    best = min(same, key=lambda candidate: candidate.criterion)
    if best.z < AS_WELL or falls_short(best.observed, best.expected_gain, best.scatter, True):
        return rounds
    return onward(train, test, forms, [replace(last, chosen=best)], best.fit)
