"""What a form promises whose effect looks at the recording: no score, which would flatter it, but its evidence."""

import numpy as np

from mismatch.fit import Fit, expected_at
from mismatch.form import Form
from mismatch.looks import flattery
from mismatch.noise import Nuisances
from mismatch.score import Score, log_chance
from mismatch.simulation import Simulation


def looked(simulation: Simulation, fitted: Fit, form: Form) -> Score:
    """What it gains where it begins. Its information is not told: it does not grow with the square of its strength."""
    forms, x = (*fitted.forms, form), np.concatenate([fitted.x, form.at_start()])
    expected = expected_at(simulation, forms, x)
    nuisances = Nuisances(simulation, fitted.frame_gain_sigma)
    settings = (*fitted.settings, form.setting(form.at_start()))
    reached = nuisances.deviance(expected) + flattery(simulation, fitted.gain, settings)
    gain, dof = fitted.deviance - reached, len(form.coordinates)
    strengths = sum(form.sizes.get(name, 1) if name in form.own else 1 for name in form.strengths)
    return Score(form, np.ones(strengths), gain, dof, log_chance(gain, dof), 0.0)
