"""A bit that sticks in one zone is told, and nothing else is taken for one."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import poisson

from mismatch.stuck import set_chance, stuck


@pytest.fixture
def seen():
    """Counts of 24 frames, 4 zones and 48 bins, bright and dark, and what is expected of them."""
    rng = np.random.default_rng(3)
    mean = np.exp(rng.uniform(np.log(0.1), np.log(2000), (24, 4, 48)))
    return rng.poisson(mean), mean


def told(counts, mean):
    return stuck(SimpleNamespace(recorded=counts.astype(float), trust=None), mean)


@pytest.mark.parametrize("value", [1, 8, 64])
def test_the_chance_of_a_bit_is_the_sum_of_all_counts_that_have_it(value):
    mean = np.array([1e-3, 0.7, 9.0, 55.0, 240.0, 4000.0])
    counts = np.arange(6000)
    oracle = (poisson.pmf(counts, mean[:, None]) * ((counts // value) % 2)).sum(axis=1)
    np.testing.assert_allclose(set_chance(mean, value), oracle, atol=2e-3)


@pytest.mark.parametrize("value", [1, 8, 256])
def test_a_bit_that_sticks_in_one_zone_is_found_there(seen, value):
    counts, mean = seen
    for change, state in ((lambda n: n | value, "set"), (lambda n: n & ~value, "clear")):
        changed = counts.copy()
        changed[:, 2] = change(counts[:, 2])
        found = told(changed, mean)
        assert found.p_value < 1e-10
        assert found.sentence == f"every count of zone 2 has the bit worth {value} {state}"


def test_noise_full_counters_and_the_dark_have_none(seen):
    counts, mean = seen
    for few in (counts, np.minimum(counts, 255), np.minimum(counts, 200), counts[:1, :, :2], 0 * counts):
        assert told(few, mean[: len(few), :, : few.shape[2]]).p_value > 1e-3


def test_a_full_counter_has_the_bits_of_its_largest_count():
    """635 lacks the bit worth 128, however many came; what else a zone counts may be too little to have it."""
    rng = np.random.default_rng(3)
    mean = np.where(rng.random((24, 4, 48)) < 0.2, 5000.0, 30.0)
    full, capped = np.minimum(rng.poisson(mean), 635), np.minimum(mean, 635.0)
    assert told(full, capped).p_value > 1e-3
