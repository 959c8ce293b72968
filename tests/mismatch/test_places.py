"""Where a misfit sits: the places hold the cells that were changed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mismatch.fit import fit_nominal
from mismatch.places import extent, places, significance

from .conftest import BINS, FRAMES, ZONES


@st.composite
def blocks(draw):
    def stretch(size):
        first = draw(st.integers(0, size - 1))
        return first, draw(st.integers(first, size - 1))

    return stretch(ZONES), stretch(BINS), stretch(FRAMES)


@given(blocks())
def test_extent_is_the_block_that_was_changed(block):
    zones, bins, frames = block
    change = np.zeros((FRAMES, ZONES, BINS))
    change[frames[0] : frames[1] + 1, zones[0] : zones[1] + 1, bins[0] : bins[1] + 1] = 3.0
    found = extent(change, np.ones_like(change))
    assert found[0] == tuple(range(zones[0], zones[1] + 1))
    for (first, last), (low, high) in zip(found[1:], (bins, frames), strict=True):
        assert low <= first <= last <= high
        assert last - first + 1 >= 0.8 * (high - low + 1) - 1e-9


@given(st.floats(0, 1), st.integers(0, BINS - 1))
def test_extent_stays_inside_whatever_the_change(strength, bin_):
    change = np.zeros((FRAMES, ZONES, BINS))
    change[:, :, bin_] = strength
    zones, bins, frames = extent(change, np.ones_like(change))
    assert set(zones) <= set(range(ZONES))
    assert 0 <= bins[0] <= bins[1] < BINS
    assert 0 <= frames[0] <= frames[1] < FRAMES


def test_an_excess_in_one_zone_is_placed_there(rig, simulated):
    mean = rig.expected().copy()
    mean[:, 2, 43:46] += 10
    simulation = simulated(np.random.default_rng(1).poisson(mean))
    found = places(simulation, fit_nominal(simulation))
    assert found[0].zones == (2,)
    assert 43 <= found[0].bins[0] <= found[0].bins[1] <= 45
    assert found[0].frames[1] - found[0].frames[0] > FRAMES // 2
    assert found[0].p_value < 1e-6
    assert found[0].sentence.startswith("zone 2, bins ")


def test_a_loss_in_some_frames_is_placed_there(rig, simulated):
    mean = rig.expected().copy()
    mean[5:9] *= 0.8
    simulation = simulated(np.random.default_rng(2).poisson(mean))
    found = places(simulation, fit_nominal(simulation))
    assert 4 <= found[0].frames[0] <= 6
    assert 7 <= found[0].frames[1] <= 10
    assert found[0].follows == "time"


def test_shares_add_to_one_and_places_lie_inside(rig, simulated):
    mean = rig.expected() * (1 + 0.2 * np.sin(np.arange(BINS) / 2 + np.arange(FRAMES)[:, None, None]))
    simulation = simulated(np.random.default_rng(3).poisson(mean))
    found = places(simulation, fit_nominal(simulation))
    assert sum(place.share for place in found) == pytest.approx(1)
    for place in found:
        assert 0 <= place.bins[0] <= place.bins[1] < BINS
        assert 0 <= place.frames[0] <= place.frames[1] < FRAMES


def test_noise_has_no_place(drawn):
    simulation = drawn(4)
    assert places(simulation, fit_nominal(simulation)) == []


def test_significance_is_corrected_for_having_looked():
    assert significance(1.959964, 1) == pytest.approx(0.025, rel=1e-5)
    assert significance(1.959964, 10) == pytest.approx(0.25, rel=1e-5)
    assert significance(0.0, 10) == 1.0
