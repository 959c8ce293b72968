"""What else noise should be: without waves, as scattered as photons, of all remainders."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import kstest

from mismatch.checks import checks, dispersion, gap, late, outlier, remainders, wave

SHAPE = (24, 4, 48)


def counts(seed, mean=80.0):
    return np.random.default_rng(seed).poisson(mean, SHAPE).astype(float)


def white(seed):
    return np.random.default_rng(seed).normal(size=SHAPE)


def test_noise_has_no_strongest_wave_beyond_chance():
    found = [wave(white([1, seed])).p_value for seed in range(100)]
    assert kstest(found, "uniform").pvalue > 1e-3


def test_a_wave_through_frames_and_bins_is_found_where_it_is():
    f, _, t = np.indices(SHAPE)
    found = wave(white(2) + 0.2 * np.sin(2 * np.pi * (5 * t / 48 - 3 * f / 24)))
    assert found.p_value < 1e-6
    assert "5 periods over the bins, 3 over the frames" in found.sentence
    assert found.foreign


@pytest.mark.parametrize("mean", [0.3, 3.0, 80.0])
def test_photons_scatter_as_photons_do(mean):
    found = [dispersion(counts([3, seed], mean), np.full(SHAPE, mean)).p_value for seed in range(60)]
    assert kstest(found, "uniform").pvalue > 1e-3


def test_dark_bins_do_not_make_counts_scatter_less():
    mean = np.full((96, 9, 128), 1e-12)
    mean[..., 20:30] = 30.0
    seen = np.random.default_rng(7).poisson(mean).astype(float)
    assert dispersion(seen, mean).p_value > 1e-3


def test_counts_that_scatter_more_or_less_are_found():
    mean = np.full(SHAPE, 80.0)
    rng = np.random.default_rng(4)
    more = dispersion(rng.negative_binomial(800, 800 / 880, SHAPE).astype(float), mean)
    less = dispersion(rng.binomial(160, 0.5, SHAPE).astype(float), mean)
    assert more.p_value < 1e-6
    assert "more than photons" in more.sentence
    assert less.p_value < 1e-6
    assert "less than photons" in less.sentence


def test_a_bit_that_sticks_in_one_zone_is_found_there():
    seen = counts(5)
    assert min(check.p_value for check in remainders(seen, np.full(SHAPE, 80.0))) > 1e-3
    seen[:, 2] -= seen[:, 2] % 2
    found = remainders(seen, np.full(SHAPE, 80.0))
    assert all(check.p_value < 1e-6 for check in found)
    assert "zone 2 divided by 2" in found[0].sentence


def test_a_full_counter_is_no_remainder_that_comes_too_often():
    """Everything above 120 is counted as 120, which leaves none."""
    mean = np.broadcast_to(np.linspace(30, 160, SHAPE[2]), SHAPE)
    seen = np.minimum(counts(5, mean), 120.0)
    assert min(check.p_value for check in remainders(seen, mean)) > 1e-3


def test_nor_is_one_that_was_full_for_part_of_the_session():
    """In the first half of the frames there is no ceiling and counts are larger; bits that stick still show."""
    mean = np.broadcast_to(np.linspace(30, 160, SHAPE[2]), SHAPE)
    seen = counts(5, mean)
    seen[12:] = np.minimum(seen[12:], 120.0)
    assert min(check.p_value for check in remainders(seen, mean)) > 1e-3
    seen[:, 1] -= seen[:, 1] % 4
    assert min(check.p_value for check in remainders(seen, mean)) < 1e-6


def test_all_of_them_are_quiet_about_a_simulation_that_is_right(drawn, rig):
    assert min(check.p_value for check in checks(drawn(6), rig.expected())) > 1e-3


def test_a_cell_that_is_out_of_place_is_found_and_noise_is_not():
    rng = np.random.default_rng(6)
    mean = rng.uniform(0.01, 200, (12, 4, 50))
    chances = [outlier(rng.poisson(mean), mean, np.arange(4)).p_value for _ in range(200)]
    # Counts are whole numbers: chances are no smaller than uniform ones.
    assert kstest(chances, "uniform", alternative="greater").pvalue > 1e-3
    counts = rng.poisson(mean)
    counts[7, 2, 33] = mean[7, 2, 33] + 9 * np.sqrt(mean[7, 2, 33]) + 9
    found = outlier(counts[:, 1:], mean[:, 1:], np.array([1, 2, 3]))
    assert found.p_value < 1e-6
    assert "frame 7, zone 2, bin 33" in found.sentence


def test_single_histograms_that_come_late_are_told_and_noise_is_not():
    rng = np.random.default_rng(12)
    bins = np.arange(60)
    peak = 4 + 600 * np.exp(-(((bins - 25) / 3) ** 2) / 2)
    mean = np.broadcast_to(peak, (30, 4, 60))
    assert late(rng.poisson(mean) - mean, mean).p_value > 1e-3
    # A fifth of a bin either way, whose mean over frames and zones is nothing.
    moved = np.empty(mean.shape)
    for cell in np.ndindex(30, 4):
        moved[cell] = np.interp(bins - rng.choice([-0.2, 0.2]), bins, peak)
    found = late(rng.poisson(moved) - mean, mean)
    assert found.p_value < 1e-6
    assert "late" in found.sentence


def test_p_values_of_lateness_are_even():
    rng = np.random.default_rng(13)
    mean = 3 + 200 * np.exp(-(((np.arange(40) - 20) / 3) ** 2) / 2) * np.ones((8, 3, 1))
    p = [late(rng.poisson(mean) - mean, mean).p_value for _ in range(200)]
    assert kstest(p, "uniform").pvalue > 1e-3


def test_flat_counts_have_no_lateness():
    mean = np.full((4, 2, 20), 5.0)
    assert late(np.ones(mean.shape), mean).p_value == 1


def test_a_cell_that_is_dark_in_most_frames_has_no_rhythm_of_its_own():
    """A moving pulse lights a cell in some frames: single photons in the others are no rhythm."""
    mean = np.full(SHAPE, 0.05)
    mean[::4] = 40.0
    counts = np.random.default_rng(14).poisson(mean).astype(float)
    simulation = SimpleNamespace(counts=counts, recorded=counts, trust=None, tolerance=None, dead=None)
    assert not any(check.sentence.startswith("one cell") for check in checks(simulation, mean))


def test_dark_bins_do_not_make_histograms_early_or_late():
    """Pulses that begin within a bin, where no background is: the bin before is steep, and a count there is chance."""
    rng = np.random.default_rng(4)

    def pulses(at):
        since = np.arange(96) - at
        return np.where(since >= 0, 300 * np.exp(-np.maximum(since, 0) / 6), 0) + 1e-3

    at = rng.uniform(30, 60, (60, 5, 1))
    mean = pulses(at)
    chances = [late(rng.poisson(mean) - mean, mean).p_value for _ in range(40)]
    assert min(chances) > 1e-3
    moved = pulses(at + rng.choice([0.0, 1.0], at.shape))
    assert late(rng.poisson(moved) - mean, mean).p_value < 1e-6


def test_small_counts_that_are_sent_as_none_are_missed():
    rng = np.random.default_rng(3)
    mean = rng.uniform(0.05, 60, SHAPE)
    seen = rng.poisson(mean).astype(float)
    assert gap(seen, mean).p_value == 1
    for least in (2, 4):
        cut = seen.copy()
        cut[:, 1][cut[:, 1] < least] = 0
        found = gap(cut, mean)
        assert found.p_value < 1e-10
        assert found.foreign
        assert f"holds 1{'' if least == 2 else ' to 3'} count" in found.sentence


def test_the_chance_of_a_gap_is_that_of_drawing_one():
    """Two zones, few cells: how often no cell holds a single count, and how large the smallest chance of two is."""
    rng = np.random.default_rng(4)
    mean = np.full((4, 2, 6), 2.0)
    chances = np.array([gap(rng.poisson(mean), mean).p_value for _ in range(3000)])
    one = -np.expm1(-24 * -np.log1p(-2 * np.exp(-2.0)))
    assert chances.min() == pytest.approx(2 * (1 - one), rel=1e-6)
    assert np.mean(chances < 1) == pytest.approx(2 * (1 - one), abs=0.012)
