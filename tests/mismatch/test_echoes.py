"""Echoes of the signal in what a fit leaves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest, norm, poisson

from mismatch.echoes import chance, echoes


def looked(simulation, expected):
    return echoes(simulation, expected, expected)


def test_noise_has_no_echo(drawn, rig):
    found = np.array([[check.p_value for check in looked(drawn([1, seed]), rig.expected())] for seed in range(30)])
    for column in found.T:
        # They may be too cautious: displaced signals are alike, and each is paid for.
        assert kstest(column, "uniform", alternative="greater").pvalue > 1e-3


def test_a_zone_that_hears_another_is_found(rig, simulated):
    expected = rig.expected()
    mean = expected.copy()
    mean[:, 3, 5:] += 0.02 * np.maximum(expected[:, 1, :-5] - 3.0, 0)
    _, pair = looked(simulated(np.random.default_rng(2).poisson(mean)), expected)
    assert pair.p_value < 1e-6
    assert pair.sentence == "zone 3 shows the signal of zone 1 displaced by 5 bins"


def test_an_echo_of_some_frames_is_found(rig, simulated):
    expected = rig.expected()
    mean = expected.copy()
    mean[::6, :, :-7] += 0.03 * np.maximum(expected[::6, :, 7:] - 5.0, 0)
    frames, _ = looked(simulated(np.random.default_rng(3).poisson(mean)), expected)
    assert frames.p_value < 1e-6
    assert frames.sentence.startswith("an echo 7 bins before the signal")


def test_a_few_stray_counts_are_no_echo(rig, simulated):
    """Where a bin holds a hundredth of a count, one photon is many standard deviations."""
    expected = np.maximum(rig.expected() - 3.0, 0) + 0.01
    dark = replace(simulated(rig.expected()), background=np.full(expected.shape[1], 0.01))
    rng = np.random.default_rng(4)
    chances = [[c.p_value for c in looked(replace(dark, counts=rng.poisson(expected)), expected)] for _ in range(60)]
    for column in np.array(chances).T:
        assert kstest(column, "uniform", alternative="greater").pvalue > 1e-3


@pytest.mark.parametrize(("counts", "mean"), [(9.0, 1.0), (3.0, 0.01), (0.0, 12.0), (150.0, 100.0)])
def test_the_chance_of_one_cell_is_a_bound_on_poissons_tail_and_near_it(counts, mean):
    tail = poisson.sf(counts - 1, mean) if counts > mean else poisson.cdf(counts, mean)
    found = chance(np.array([counts]), np.array([mean]), np.array([2.0]))
    assert tail <= found < 20 * tail
    # Only the ratio of weights matters; a weight below 0 exchanges the sides.
    assert chance(np.array([counts]), np.array([mean]), np.array([-0.3])) == pytest.approx(found, rel=1e-3)


def test_the_chance_of_many_bright_cells_is_near_the_normal_laws():
    rng = np.random.default_rng(5)
    mean, weights = np.full(4000, 500.0), rng.normal(size=4000)
    z = 5.0
    counts = mean + z * weights * np.sqrt(mean / (weights**2).sum()) * 1.0
    found = chance(counts, mean, weights)
    assert norm.sf(z) < found < 20 * norm.sf(z)


def test_counts_as_expected_have_any_chance():
    assert chance(np.full(5, 3.0), np.full(5, 3.0), np.arange(5.0)) == 1
