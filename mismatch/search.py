"""The search for effects: on some frames, judged by others, anew where a cause leaves counts uncertain."""

from dataclasses import dataclass, replace

from mismatch.beginnings import likeliest_selection, unjudged
from mismatch.blocks import halves
from mismatch.economy import economical
from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.gained import falls_short
from mismatch.leftover import what_is_left
from mismatch.likelier_response import likelier_clock
from mismatch.naming import Contest, contested
from mismatch.selection import Round, onward, without
from mismatch.simulation import Simulation
from mismatch.trust import as_given, trusted
from mismatch.unseen import owns_up
from mismatch.work import Work

ONE_BY_ONE = "what is amiss shows in few frames; single frames were held out, not blocks of them"
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
    its own, or is left. Then it is estimated anew, beside what explains most, and all is sought once more.
    """
    cheap = replace(economical(simulation), work=Work())
    found = search(cheap, forms)
    names = found.judged.forms
    if not (simulation.guessed and names and (len(names) > 1 or what_is_left(found.train, found.judged))):
        return cheap, found
    most = max(range(len(names)), key=lambda i: without(found.train, found.judged, names[i], 0).deviance)
    clock = likelier_clock(simulation, found.judged.gain, (found.judged.settings[most],))
    cheap = replace(economical(replace(simulation, clock=clock)), work=Work())
    return cheap, search(cheap, forms)


def search(simulation: Simulation, forms: list[Form]) -> Search:
    """The effects, of all that there are, that stand in a recording."""
    frames, simulation = len(simulation.counts), as_given(simulation)
    train, test = (simulation.of(some) for some in halves(frames))
    rounds, notes = likeliest_selection(train, test, forms), ()
    if unjudged(rounds[-1]):
        singly = [simulation.of(some) for some in halves(frames, frames)]
        anew = likeliest_selection(*singly, forms)
        # A search that was ended before it began tells nothing.
        if anew[-1].before.forms or not rounds[-1].before.forms or not simulation.work.enough:
            (train, test), rounds, notes = singly, anew, (ONE_BY_ONE,)
    there = trusted(simulation, train, test, rounds) if what_is_left(train, rounds[-1].before) else None
    if there is not None:
        again = [there[0].of(part.frames) for part in (train, test)]
        # There may be no more search left in it than to go on from there.
        anew = onward(*again, forms, there[2], there[1]) if simulation.work.enough else _beside(*again, forms, there[1])
        if owns_up(anew[-1].before):
            simulation, (train, test), rounds, notes = there[0], again, anew, (*notes, UNCERTAIN)
    judged, contests = contested(train, test, rounds[-1].before, rounds, forms)
    return Search(simulation, train, test, rounds, judged, contests, notes)


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
    if best.z < AS_WELL or falls_short(best.observed, best.expected_gain, True):
        return rounds
    return onward(train, test, forms, [replace(last, chosen=best)], best.fit)
