"""What a fit pays for its parameters, its choices and its names, in deviance."""

import numpy as np

from mismatch.fit import Fit
from mismatch.form import Form
from mismatch.pattern import drawn
from mismatch.score import numbers_given
from mismatch.simulation import Simulation
from physics.effects import all_effects

# Deviance that a choice of one of two must gain: twice the logarithm of the odds against it.
CHOICE = 2 * np.log(2)
# Deviance by which an effect must beat others where its name is stretched.
STRAINED = 25.0


def price(simulation: Simulation) -> float:
    """Deviance that a parameter must gain to be worth having: logarithm of the number of histograms (BIC)."""
    return float(np.log(simulation.counts.shape[0] * simulation.counts.shape[1]))


def numbers_cost(simulation: Simulation, fitted: Fit) -> float:
    """Deviance that the numbers of a fit must gain which are fitted each by itself."""
    return price(simulation) * fitted.numbers - _less(simulation, fitted.forms)


def _less(simulation: Simulation, forms: tuple[Form, ...]) -> float:
    """What numbers of single zones cost less than others: only that zone's histogram tells of them in each frame."""
    own = sum(place is not None and parameter.axis == "zone" for form in forms for parameter, place in form.coordinates)
    return own * float(np.log(simulation.counts.shape[1]))


def cost(simulation: Simulation, fitted: Fit) -> float:
    """Deviance that a fit's parameters must gain, and its effects where their names are stretched.

    What the data gave zone by zone, which zones are late or share a converter, is a choice for each; that an effect
    sets in with some frame is one of as many as there are frames. Any other number that the data gave, and no fit
    varied, is a parameter like others, or one of as many as it is large where it is whole. And each effect is one of
    as many as there are.
    """
    given = [(form, name) for form in fitted.forms for name in form.given]
    chosen = sum(np.size(form.start[n]) for form, n in given if np.ndim(form.start[n]))
    onsets = sum(name == "since" for _, name in given)
    numbers = [number for form in fitted.forms for number in numbers_given(form)]
    whole = [2 * np.log(2 + abs(number)) for number in numbers if number.is_integer()]
    choices = CHOICE * chosen + 2 * np.log(len(simulation.counts)) * onsets + sum(whole)
    choices += 2 * np.log(len(all_effects())) * len(fitted.forms)
    given_too = price(simulation) * (len(numbers) - len(whole))
    patterns = 0.0 if fitted.pattern is None else fitted.pattern.cost + price(simulation)
    return numbers_cost(simulation, fitted) + given_too + patterns + choices + strain(simulation, fitted)


def strain(simulation: Simulation, fitted: Fit) -> float:
    """Deviance that the names of a fit must gain for being stretched, or contradicted by their own parameters."""
    rendering = simulation.rendering(fitted.gain)
    each = ((setting.effect, setting.values) for setting in fitted.settings)
    return STRAINED * sum(
        effect.strained(values, rendering) or effect.contradiction(values, rendering) is not None
        for effect, values in each
    )


def least_cost(train: Simulation, forms: tuple[Form, ...]) -> float:
    """Deviance that forms must gain at least: of numbers that are drawn, what they fit of noise."""
    many = len(drawn(forms))
    return price(train) * (1 + sum(len(form.coordinates) for form in forms) - many) - _less(train, forms) + many
