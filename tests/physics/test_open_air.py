"""Layers of air whose edges are soft, against integrals that are summed up."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from physics.effects import find_effect
from physics.open_air import layers, ranges_of, way_in
from physics.rendering import Rendering

EFFECT = find_effect("scattering_medium")
FORMS = [
    {"begin": 0.4, "thickness": 0.3, "soft": 0.05},
    {"begin": 0.1, "thickness": 0.01, "soft": 0.2},
    {"begin": 0.0, "thickness": 100.0, "soft": 0.1},
]


def medium(form, r):
    """How much of it is there at a range."""
    return norm.cdf((r - form["begin"]) / form["soft"]) - norm.cdf(
        (r - form["begin"] - form["thickness"]) / form["soft"]
    )


@pytest.mark.parametrize("form", FORMS)
def test_the_way_in_a_soft_layer(form):
    values = EFFECT.at(extinction=1.0, **form).values
    ranges = np.array([0.0, 0.12, 0.5, 0.75, 2.0])
    summed = [quad(lambda r: medium(form, r), 0, end, epsabs=1e-10)[0] for end in ranges]
    np.testing.assert_allclose(way_in(values, ranges), summed, atol=1e-7)
    assert (way_in(values, np.array([-1.0, -0.1])) == 0).all()


@pytest.mark.parametrize("form", FORMS)
def test_what_lies_around_a_knot(small, form):
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)
    values, ranges = EFFECT.at(extinction=1.0, overlap=0.1, blind=0.03, **form).values, ranges_of(rendering.clock)
    half = np.diff(ranges[0, 0])[0] / 2
    found = layers(values, rendering.clock, ranges)[0, 0]
    for k in (45, 60, 90, 150):
        low, high = (max(ranges[0, 0, k] + side, 0.03) for side in (-half, half))
        summed = quad(lambda r: medium(form, r) / (r**2 + 0.1**2), low, high)[0] if high > low else 0.0
        assert found[k] == pytest.approx(summed, rel=0.02, abs=1e-6)


def test_hardly_soft_is_hard():
    hard, soft = (EFFECT.at(extinction=1.0, begin=0.4, thickness=0.3, soft=s).values for s in (0.0, 1e-6))
    ranges = np.linspace(-0.5, 2, 30)
    np.testing.assert_allclose(way_in(soft, ranges), way_in(hard, ranges), atol=1e-5)
