"""What a true cause gains on frames held out scatters as is said, where counts are few, too."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.clock_slopes import loosened
from mismatch.fit import fit, fit_nominal
from mismatch.form import forms_of
from mismatch.gained import gained
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


@pytest.mark.parametrize(("share", "dark"), [(0.02, True), (0.1, False)])
def test_gains_scatter_as_those_of_counts_drawn_again(rig, simulated, share, dark):
    """An early pulse next to nothing, where each count gains much; a tail amid background, where each gains little."""
    (setting,) = [find_effect("impulse_tail").at(share=share, tau=1.5e-9)]
    truth = rig.expected(setting) if not dark else 0.02 * (rig.expected(setting) - rig.expected().min()) + 1e-5
    simulation = simulated(np.random.default_rng(1).poisson(truth))
    simulation = replace(simulation, background=np.full(4, 1e-5)) if dark else simulation
    train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
    form = next(f for f in forms_of(find_effect("impulse_tail"), SIZES) if f.free == ("share", "tau") and not f.own)
    less = fit_nominal(train)
    more = fit(train, (form,), np.concatenate([less.x, form.coordinates_of(setting)]))
    once = gained(test, less, more)
    mean, rng = test.expected(more.gain, more.settings), np.random.default_rng(2)
    again = [gained(replace(test, counts=rng.poisson(mean).astype(float)), less, more).observed for _ in range(200)]
    # Of 200: 5 %. The fit's own numbers are taken off what is due.
    assert once.scatter == pytest.approx(np.std(again), rel=0.2)
    assert once.expected == pytest.approx(np.mean(again), abs=4 + 0.3 * np.std(again))
    assert (once.scatter > 2.5 * np.sqrt(once.expected)) == dark


def test_of_a_large_change_a_loose_response_takes_up_what_it_can(rig, simulated):
    """Late bins that hold nothing: what is due is what counts drawn again gain, the response at its best for each."""
    setting = find_effect("window_clipping").at(late=30.0)
    simulation = loosened(simulated(np.random.default_rng(3).poisson(rig.expected(setting))))
    train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
    form = next(f for f in forms_of(find_effect("window_clipping"), SIZES) if f.free == ("late",) and not f.own)
    less = fit_nominal(train)
    more = fit(train, (form,), np.concatenate([less.x, form.coordinates_of(setting)]))
    mean, rng = test.expected(more.gain, more.settings), np.random.default_rng(4)
    again = [gained(replace(test, counts=rng.poisson(mean).astype(float)), less, more).observed for _ in range(30)]
    once = gained(test, less, more)
    assert once.expected > 500
    assert once.expected == pytest.approx(np.mean(again), rel=0.05)
