"""Effects that set in: before some frame the recording is as it would be without."""

from dataclasses import replace

import numpy as np

from mismatch.cost import cost
from mismatch.fit import Fit, fit, on_others
from mismatch.noise import Nuisances
from mismatch.poisson import deviance
from mismatch.simulation import Simulation

# Deviance by which the frames before must fit better without it for a fit to be worth the while.
WORTH = 10.0


def set_in(train: Simulation, test: Simulation, chosen: Fit) -> Fit:
    """The fit with its last effect from some frame on alone, where that is likelier and fits frames held out better."""
    *before, form = chosen.forms
    if "since" in form.given or form.effect.looks(chosen.settings[-1].values):
        return chosen
    nuisances = Nuisances(train, chosen.frame_gain_sigma)
    without = train.expected(chosen.gain, chosen.settings[:-1])
    each = [deviance(train.counts, nuisances.applied(e)).sum(axis=(1, 2)) for e in (chosen.expected, without)]
    time_s = np.asarray(train.light.time_s, float)
    order = np.argsort(time_s, kind="stable")
    spared = np.cumsum((each[0] - each[1])[order])[:-1]
    if not len(spared) or spared.max() < WORTH + 2 * np.log(len(time_s)):
        return chosen
    at = int(spared.argmax())
    since = float(time_s[order[at : at + 2]].mean())
    later = replace(form, start=form.start | {"since": since}, given=(*form.given, "since"))
    found = fit(train, (*before, later), chosen.x, chosen.frame_gain_sigma)
    likelier = found.deviance + cost(train, found) < chosen.deviance + cost(train, chosen)
    return found if likelier and on_others(test, found)[1] < on_others(test, chosen)[1] else chosen
