"""How counts change with coordinates: against one at a time, and slopes of patches that are known from nearby."""

import numpy as np

from mismatch.derivatives import derivatives, expected_at
from mismatch.fit import fit_nominal
from mismatch.form import forms_of
from mismatch.remembered import Slopes
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


def form_of(name, free):
    return next(form for form in forms_of(find_effect(name), SIZES) if form.free == free and form.own)


def test_patches_are_moved_one_at_a_time(drawn):
    simulation, form = drawn(3), form_of("reflectance_map", ("patch",))
    rng = np.random.default_rng(2)
    x = np.concatenate([fit_nominal(simulation).x, rng.normal(0, 0.5, len(form.coordinates))])
    here = expected_at(simulation, (form,), x)
    found, slopes = derivatives(simulation, (form,), x, here)
    np.testing.assert_allclose(slopes.columns.reshape(128, -1).T, found[:, 1:], rtol=1e-6)
    for i in rng.choice(len(x), 6, replace=False):
        moved = x.copy()
        moved[i] += 1e-3
        alone = (expected_at(simulation, (form,), moved) - here) / 1e-3
        np.testing.assert_allclose(found[:, i], alone.ravel(), atol=1e-6 * max(np.abs(alone).max(), 1))


def test_slopes_that_are_near_are_taken_and_others_are_not(drawn):
    simulation, form, gain = drawn(3), form_of("reflectance_map", ("patch",)), find_effect("zone_gain")
    x = np.concatenate([fit_nominal(simulation).x, np.random.default_rng(2).normal(0, 0.5, 128)])
    here = expected_at(simulation, (form,), x)
    _, slopes = derivatives(simulation, (form,), x, here)
    (zones,) = (one for one in forms_of(gain, SIZES) if one.free == ("factor",) and one.own)

    def beside(factor):
        forms, there = (form, zones), np.concatenate([x, zones.coordinates_of(gain.at(factor=factor))])
        return forms, there, expected_at(simulation, forms, there)

    # What acts on counts alone leaves slopes in proportion to them: taken as they were, they are what they are.
    forms, there, now = beside([0.9, 1.0, 1.1, 1.0])
    found, again = derivatives(simulation, forms, there, now, slopes)
    anew, _ = derivatives(simulation, forms, there, now)
    assert again is slopes
    np.testing.assert_allclose(found[:, 1:129], anew[:, 1:129], atol=0.02 * np.abs(anew[:, 1:129]).max())
    np.testing.assert_array_equal(found[:, 129:], anew[:, 129:])
    forms, there, now = beside([0.5, 1.5, 0.5, 1.5])
    found, again = derivatives(simulation, forms, there, now, slopes)
    assert again is not slopes
    np.testing.assert_array_equal(found, derivatives(simulation, forms, there, now)[0])


def test_slopes_go_with_counts():
    slopes = Slopes(np.array([[[2.0, 4.0, 0.0]]]), np.array([[[[1.0, 3.0, 0.0]]]]))
    np.testing.assert_allclose(slopes.at(np.array([[[3.0, 4.0, 0.0]]])), [[[[1.5, 3.0, 0.0]]]])
    assert slopes.near(np.array([[[2.1, 4.1, 0.1]]]))
    assert not slopes.near(np.array([[[3.0, 4.0, 0.0]]]))
