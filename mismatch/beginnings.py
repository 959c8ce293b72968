"""Other beginnings: where one effect after the other leads elsewhere, depending on which was chosen first."""

from mismatch.candidates import Candidate
from mismatch.exchanged import exchanged, one_in_another_form
from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.leftover import what_is_left
from mismatch.outside.told import told_alone
from mismatch.rivals import evidence
from mismatch.selection import Round, begun_with, select
from mismatch.simulation import Simulation

# So many of the first round's other candidates are tried as the first.
OTHERS = 2
# Twice the logarithm of the odds at which two causes are believed in place of what is neither stretched nor leaves any.
TWO_FOR_ONE = 10.0
# Where odds are nearer than this what was chosen first may have another form beside what came after it.
NEAR = 60.0
# So many numbers make a shape that may hold two causes: a drift that slows down beside one of another kind.
RICH = 3
# Deviance that is much to gain, and part of it that frames held out should gain at least to judge it.
MUCH, HARDLY = 100.0, 0.1


def likeliest_selection(train: Simulation, test: Simulation, forms: list[Form], last: bool = True) -> list[Round]:
    """The selection that begins with the best effect, or with another where that leads to what is likelier.

    The first may take up parts of two causes and leave a third to be named. Others are tried where what was found is
    stretched or leaves something, until one is not and leaves nothing. One that has a number for each zone, or many,
    may take up two causes whole; and the first of several, so much of others that what is left has another name. Each
    of several is chosen anew beside the others.

    last: whether no other halves of the frames are to be tried, which may judge what these cannot.
    """
    best = select(train, test, forms)
    if not last and unjudged(best[-1]) is not None:
        return best
    found = best[-1].before
    if found.forms and what_is_left(train, found) and told_alone(train, test, found):
        return best  # Whatever else there is to begin with, all that is amiss has another cause.
    return _likeliest(train, test, forms, best[0], exchanged(train, test, forms, best))


def _likeliest(train: Simulation, test: Simulation, forms: list[Form], first: Round, best: list[Round]) -> list[Round]:
    """The likeliest of selections that begin with one effect or another. best: the one that began with the best.

    first: its first round.
    """
    found = best[-1].before
    if not found.forms:
        return best
    doubtful, likeliest = _doubtful(train, found), _evidence(train, test, best)
    others = [(candidate, True) for candidate in _others(first)] if doubtful else []
    # What is plainer costs less to try, and what is found so leaves the others less to explain.
    as_two = [(candidate, False) for candidate in _plainest(first, found)] if doubtful else _two_for_one(first, found)
    for i, (candidate, richer) in enumerate((*as_two, *others)):
        if train.work.enough:
            break
        other = begun_with(train, test, forms, first, candidate, richer=richer)
        two = i < len(as_two)
        if two and len(other[-1].before.forms) < 2:
            continue  # What stands in the place of one alone is a matter of contests.
        there, own = _evidence(train, test, other), False
        if abs(there - likeliest) < NEAR:
            other, own = one_in_another_form(train, test, forms, other)
            there = _evidence(train, test, other)
        if there > likeliest + (TWO_FOR_ONE if two else 0.0):
            best = exchanged(train, test, forms, other, own)
            likeliest = _evidence(train, test, best)
            if doubtful and not _doubtful(train, best[-1].before):
                break
    return best


def _two_for_one(first: Round, found: Fit) -> list[tuple[Candidate, bool]]:
    """Where two may be likelier than what nobody doubts: candidates of the first round to begin with.

    And whether each may take a richer form at once. In the place of one with a number for each zone, or many: its own
    plainest form, and others of one number for all. In the place of several, the first of which may hold parts of
    others: others.
    """
    alone, others = found.forms, _others(first)
    if len(alone) > 1:
        return [(candidate, True) for candidate in others]
    alike = [c for c in others if alone[0].own and not c.form.own]
    return [(candidate, False) for candidate in (*_plainest(first, found), *alike)]


def _plainest(first: Round, found: Fit) -> list[Candidate]:
    """Of one effect that has a number for each zone, or many, the plainest form that stands out; there may be none."""
    alone = found.forms
    if len(alone) > 1:
        return []
    plainer = [c for c in first.candidates if c.form.effect is alone[0].effect and _plainer(c.form, alone[0])]
    plainer = [c for c in plainer if c.stands_out(len(first.candidates))]
    return sorted(plainer, key=lambda c: (len(c.form.coordinates), c.criterion))[:1]


def unjudged(last: Round) -> Candidate | None:
    """A candidate that gains much on frames that choose and of which those held out tell nothing, if there is one."""
    for candidate in last.candidates:
        won = last.before.deviance - candidate.fit.deviance
        if won > MUCH and last.before.deviance > candidate.criterion and candidate.expected_gain < HARDLY * won:
            return candidate
    return None


def _plainer(form: Form, other: Form) -> bool:
    """Whether it has less to fit: one number for all zones, or fewer where that has many."""
    if other.own:
        return not form.own
    return len(form.coordinates) < len(other.coordinates) >= RICH


def _evidence(train: Simulation, test: Simulation, rounds: list[Round]) -> float:
    """Of where a selection ended; or with what it found too little to name, since another may have named as much."""
    last = rounds[-1]
    fits = (last.before,) if last.minor is None else (last.before, last.minor.fit)
    return max(evidence(train, test, fitted) for fitted in fits)


def _doubtful(train: Simulation, found: Fit) -> bool:
    """Whether names are stretched or contradicted, or leave something."""
    rendering = train.rendering(found.gain)
    asked = ((s.effect, s.values, rendering) for s in found.settings)
    if any(effect.strained(*now) or effect.contradiction(*now) for effect, *now in asked):
        return True
    return bool(what_is_left(train, found))


def _others(first: Round) -> list[Candidate]:
    """The best candidate of each effect that was not chosen and stands out, the best first."""
    found = {}
    for candidate in first.candidates:
        name = candidate.form.effect.id
        if name != first.chosen.form.effect.id and candidate.stands_out(len(first.candidates)):
            found.setdefault(name, candidate)
    return list(found.values())[:OTHERS]
