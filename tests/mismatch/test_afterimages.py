"""Noise that is seen again: whose chance is right where there is none, and where counts stay in memory."""

import numpy as np
import pytest

from mismatch.afterimages import afterimage

FRAMES, ZONES, BINS = 24, 4, 48
EVERY = np.arange(FRAMES)


def means(rng):
    """Peaks that move from frame to frame, on a pedestal."""
    t = np.arange(BINS)
    at = 15 + 8 * np.sin(np.arange(FRAMES) / 3)[:, None, None] + rng.uniform(0, 5, (1, ZONES, 1))
    return 4 + rng.uniform(20, 400) * np.exp(-(((t - at) / 4) ** 2))


def test_of_photons_it_is_as_likely_as_it_says():
    found = []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        mean = means(rng)
        found.append(afterimage(rng.poisson(mean) - mean, mean, EVERY).p_value)
    found = np.array(found)
    # The smallest of eight, times eight, is 1 at most. To take means off makes sums of products a little too small.
    for p in (0.05, 0.2, 0.5):
        assert 0.5 * p < (found < p).mean() < 1.5 * p
    assert found.min() > 1e-4


@pytest.mark.parametrize("back", [1, 3, 8])
def test_a_share_of_a_frame_that_stays_is_seen_in_its_noise(back):
    """Though the mean, as a fit would have it, has that share in it."""
    rng = np.random.default_rng(back)
    mean = means(rng)
    counts = rng.poisson(mean).astype(float)
    for i in range(back, FRAMES):
        counts[i] += rng.binomial(counts[i - back].astype(int), 0.15)
    expected = mean.copy()
    for i in range(back, FRAMES):
        expected[i] += 0.15 * expected[i - back]
    found = afterimage(counts - expected, expected, EVERY)
    assert found.p_value < 1e-6
    assert found.foreign
    assert ("the frame before" if back == 1 else f"the frame {back} before") in found.sentence


def test_frames_that_were_left_out_lie_between():
    """Every other frame: what stays of the one before is not among them, and nothing is seen."""
    rng = np.random.default_rng(7)
    mean = means(rng)
    counts = rng.poisson(mean).astype(float)
    counts[1:] += rng.binomial(counts[:-1].astype(int), 0.2)
    expected = mean.copy()
    expected[1:] += 0.2 * mean[:-1]
    some = EVERY[::2]
    found = afterimage((counts - expected)[some], expected[some], some)
    assert found.p_value > 1e-3


def test_what_is_amiss_in_all_frames_is_no_afterimage():
    rng = np.random.default_rng(3)
    mean = means(rng)
    excess = rng.poisson(mean) - mean + 0.3 * np.sqrt(mean) * np.sin(np.arange(BINS))
    assert afterimage(excess, mean, EVERY).p_value > 1e-3


def test_few_counts_say_nothing():
    assert afterimage(np.zeros((2, 1, 4)), np.full((2, 1, 4), 0.1), np.arange(2)).p_value == 1
