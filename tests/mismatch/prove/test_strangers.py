"""Causes that nobody knows: they change counts, and nothing else."""

import numpy as np
import pytest

from mismatch.prove.strangers import STRANGERS
from physics.effects import all_effects


@pytest.fixture(scope="module")
def expected(rig):
    return rig.expected()


@pytest.mark.parametrize("name", sorted(STRANGERS))
def test_it_changes_counts_and_keeps_their_shape(expected, name):
    before = expected.copy()
    changed = STRANGERS[name](expected, 0.5, np.random.default_rng(1))
    assert changed.shape == expected.shape
    assert np.isfinite(changed).all()
    assert (changed >= 0).all()
    assert not np.allclose(changed, expected, rtol=1e-3)
    np.testing.assert_array_equal(expected, before)


@pytest.mark.parametrize("name", sorted(STRANGERS))
def test_it_is_the_same_for_the_same_draw_and_vanishes_with_its_strength(expected, name):
    one, other = (STRANGERS[name](expected, 0.3, np.random.default_rng(2)) for _ in range(2))
    np.testing.assert_array_equal(one, other)
    none = STRANGERS[name](expected, 1e-9, np.random.default_rng(2))
    np.testing.assert_allclose(none, expected, rtol=1e-6, atol=1e-6)


def test_none_of_them_is_in_the_library():
    assert not STRANGERS.keys() & all_effects().keys()
