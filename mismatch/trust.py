"""Counts that a cause leaves uncertain, as nobody saw what its model would have to know, are trusted less."""

from dataclasses import replace

from mismatch.cost import cost
from mismatch.fit import Fit, fit, fit_nominal
from mismatch.selection import Round
from mismatch.simulation import Simulation
from mismatch.unseen import marginal_deviance, owns_up, trust_in

# What is uncertain depends on what is fitted, and that on what is trusted: a fit and the trust in it settle in so many.
TURNS = 3
# Where fewer cells than this are lost all may as well be trusted.
WORTH = 10.0


def as_given(simulation: Simulation) -> Simulation:
    """Trusted as far as the effects that are given say."""
    return simulation.trusting(trust_in(simulation, fit_nominal(simulation))) if simulation.given else simulation


def trusted(
    simulation: Simulation, train: Simulation, test: Simulation, rounds: list[Round]
) -> tuple[Simulation, Fit, list[Round]] | None:
    """All frames, trusted as far as the likeliest cause that owns up to what nobody saw says, its fit, and how it came.

    None where no cause does, or it is not likelier, its own uncertainty being paid for, than what was found by trusting
    all.
    """
    owning = [(i, c) for i, one in enumerate(rounds) for c in one.candidates if _last_owns_up(c.fit)]
    if not owning:
        return None
    at, chosen = min(owning, key=lambda one: one[1].criterion)
    found, led = chosen.fit, [*rounds[:at], replace(rounds[at], chosen=chosen)]
    for _ in range(TURNS):
        there = simulation.trusting(trust_in(simulation, found))
        found = fit(there.of(train.frames), found.forms, found.x, found.frame_gain_sigma)
    mine, theirs = (marginal_deviance(simulation, one) + cost(train, one) for one in (found, rounds[-1].before))
    likelier = owns_up(rounds[-1].before) or mine < theirs
    return (there, found, led) if likelier and there.trust is not None and (1 - there.trust).sum() > WORTH else None


def _last_owns_up(fitted: Fit) -> bool:
    """Whether the effect that was fitted last does."""
    last = fitted.settings[-1]
    return last.effect.owns_up(last.values)
