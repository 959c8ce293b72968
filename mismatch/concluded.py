"""What fits come to: explained, unknown or in agreement, and by how much they fit."""

import numpy as np

from mismatch.candidates import MINOR, MINOR_PART
from mismatch.doubts import doubts
from mismatch.fit import Fit, fit_nominal, on_others
from mismatch.leftover import NEGLIGIBLE
from mismatch.located import locate_effects
from mismatch.looks import blur
from mismatch.naming import Contest, name_effects, next_measurement
from mismatch.outside.told import told_outside
from mismatch.places import Place
from mismatch.poisson import expected_deviance
from mismatch.selection import MOST_EFFECTS, Round
from mismatch.simulation import Simulation
from mismatch.tolerance import still_off
from mismatch.unseen import marginal_deviance
from mismatch.verdict import Deviance, Verdict
from mismatch.visibility import not_visible

# No more of what was explained is negligible.
A_QUARTER = 0.25
# Nor is more deviance than this negligible on frames held out, whatever was explained.
LARGE = 500.0
# What may be left, as such a part of what effects explained that leave to be guessed what nobody saw: frames tell
# roughly how far off guesses are.
NOT_SEEN = 0.15
# How many times what another formula gains may be left where that is said to take it up.
TAKEN_UP = 2.0


def concluded(
    simulation: Simulation,
    train: Simulation,
    test: Simulation,
    rounds: list[Round],
    judged: Fit,
    explained: Fit,
    contests: list[Contest],
    left: tuple[Place, ...],
) -> tuple[Verdict, tuple[Place, ...]]:
    """The verdict on fits of the frames that choose and of all, and what fits better outside the library.

    left: what is amiss beside `explained`.
    """
    tried = max(one.tried for one in rounds)
    effects = name_effects(train, test, judged, contests, explained, tried)
    first = fit_nominal(train, judged.frame_gain_sigma)
    uncertain = blur(simulation, explained.gain, explained.settings)
    shown = len(test.frames) / len(simulation.counts)
    remains = max(sum(place.gain for place in left) - uncertain, 0.0) * shown
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
    if simulation.tolerance is not None:
        doubted, missing = (still_off(simulation, explained), *doubted), np.inf
    if doubted or (left and not (judged.forms and negligible)):
        kind = "unknown"
    outside: tuple[Place, ...] = ()
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
        not_visible=not_visible(rounds[-1].scores, len(train.frames) / len(simulation.counts)),
        next_measurement=next_measurement(train, contests),
    )
    return verdict, outside


def little(won: float, guessed: float) -> float:
    """Deviance on frames held out that does not make an explanation unknown which gained `won` there.

    guessed: how much of that is of effects which leave to be guessed what nobody saw.
    """
    return max(NOT_SEEN * guessed, min(NEGLIGIBLE * won, LARGE))


def _deviances(part: Simulation, first: Fit, judged: Fit, missing: float) -> Deviance:
    """Per cell, of some frames, all counts trusted. missing: deviance that is known to be left beside noise.

    The floor: as explained, less what parameters' errors cost and what is left. It is no lower than photon noise alone
    would make it on average, where a misfit is large.
    """
    part = part.as_recorded()
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
