"""Unequal bins against the code-density test, and against a pulse integrated between the displaced edges."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from physics.effects.bin_nonlinearity import effect


def seen(counts, **values):
    return effect.expected(effect.at(**values).values, SimpleNamespace(expected=np.asarray(counts, float)))


def test_a_pedestal_shows_the_widths():
    """The code-density test: counts of constant light are in proportion to the width of their bin."""
    found = seen(np.full((2, 3, 40), 100.0), alternation=0.1, slope=0)
    np.testing.assert_allclose(found[..., 1:-1:2], 120)
    np.testing.assert_allclose(found[..., 2:-1:2], 80)
    bent = seen(np.full(200, 100.0), alternation=0, slope=0.1)
    np.testing.assert_allclose(bent, 100 + 10 * np.cos(np.pi * (np.arange(200) + 0.5) / 200), atol=1e-2)


@pytest.mark.parametrize(("alternation", "slope"), [(0.3, 0), (-0.2, 0.1), (0, -0.15)])
def test_a_pulse_is_integrated_between_the_displaced_edges(alternation, slope):
    edges = np.arange(61.0)
    pulse = norm(30.3, 3.0)
    late = np.where(edges % 2 == 0, alternation, -alternation)
    moved = edges + late + slope * 60 / np.pi * np.sin(np.pi * edges / 60)
    found = seen(np.diff(pulse.cdf(edges)), alternation=alternation, slope=slope)
    np.testing.assert_allclose(found, np.diff(pulse.cdf(moved)), atol=5e-3 * found.max())


@given(
    alternation=st.floats(-0.4, 0.4),
    slope=st.floats(-0.15, 0.15),
    bins=st.integers(2, 60),
    seed=st.integers(0, 999),
)
def test_counts_are_kept_and_none_turns_negative(alternation, slope, bins, seed):
    counts = np.random.default_rng(seed).exponential(size=(2, 3, bins)) ** 4
    found = seen(counts, alternation=alternation, slope=slope)
    np.testing.assert_allclose(found.sum(axis=-1), counts.sum(axis=-1))
    assert (found >= 0).all()
