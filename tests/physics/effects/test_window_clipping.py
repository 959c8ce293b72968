"""A window against slices, against finer bins that it does not divide, and against ramps summed bin by bin."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from physics.effects.window_clipping import effect
from recordings.refusal import Refusal

SHAPE = st.fixed_dictionaries(
    {
        name: st.floats(*within)
        for name, within in {"softness": (1, 10), "rounded": (0, 1), "lost": (0.3, 1), "background": (0, 1)}.items()
    }
)


def seen(counts, level=0.0, **values):
    rendering = SimpleNamespace(expected=np.asarray(counts, float), background=level)
    return effect.expected(effect.at(**values).values, rendering)


@given(early=st.integers(0, 45), late=st.integers(0, 45))
def test_whole_bins_are_a_slice(early, late):
    counts = np.random.default_rng(1).uniform(1, 9, (2, 3, 40))
    wanted = np.zeros_like(counts)
    wanted[..., early : max(40 - late, early)] = counts[..., early : max(40 - late, early)]
    np.testing.assert_array_equal(seen(counts, early=early, late=late), wanted)


@given(early=st.integers(0, 200), late=st.integers(0, 200))
def test_a_divided_bin_is_the_sum_of_finer_ones(early, late):
    fine = np.repeat(np.random.default_rng(2).uniform(1, 9, (1, 2, 20)), 8, axis=-1)
    kept = np.arange(160)
    kept = fine * ((kept >= early) & (kept < 160 - late))
    found = seen(fine.reshape(1, 2, 20, 8).sum(axis=-1), early=early / 8, late=late / 8)
    np.testing.assert_allclose(found, kept.reshape(1, 2, 20, 8).sum(axis=-1), atol=1e-9)


def test_a_window_of_no_width_holds_nothing():
    np.testing.assert_array_equal(seen(np.ones((2, 2, 6)), early=4, late=3), np.zeros((2, 2, 6)))


def test_a_soft_edge_loses_evenly_more_from_bin_to_bin():
    found = seen(np.full((1, 1, 12), 8.0), early=5, softness=4)[0, 0]
    np.testing.assert_allclose(found, [0, 0, 2, 4, 6, 8, 8, 8, 8, 8, 8, 8])
    late = seen(np.full((1, 1, 12), 8.0), late=5, softness=4)[0, 0]
    np.testing.assert_allclose(late, found[::-1])


def test_a_rounded_edge_is_a_gate_of_finite_rise():
    """The logistic curve, and within 1 % the integral of a normal density that is 1.702/4 as broad (Haley 1952)."""
    bins, softness = np.arange(40), 6.0
    found = seen(np.ones((1, 1, 40)), early=20, softness=softness, rounded=1)[0, 0]
    np.testing.assert_allclose(found, 1 / (1 + np.exp(-4 * (bins - 17.0) / softness)), atol=1e-12)
    assert np.abs(found - norm.cdf(bins, 17.0, softness * 1.702 / 4)).max() < 0.0096
    half = seen(np.ones((1, 1, 40)), early=20, softness=softness, rounded=0.5)[0, 0]
    ramp = seen(np.ones((1, 1, 40)), early=20, softness=softness)[0, 0]
    np.testing.assert_allclose(half, (found + ramp) / 2)


@given(edge=st.floats(0, 12), shape=SHAPE)
def test_late_is_early_looked_at_from_the_other_end(edge, shape):
    counts = np.random.default_rng(3).uniform(5, 9, (1, 2, 12))
    late = seen(counts[..., ::-1], 3.0, late=edge, **shape)[..., ::-1]
    np.testing.assert_allclose(late, seen(counts, 3.0, early=edge, **shape))


@given(shape=SHAPE)
def test_without_edges_nothing_is_lost_however_soft(shape):
    counts = np.random.default_rng(4).uniform(0, 9, (1, 2, 12))
    np.testing.assert_array_equal(seen(counts, 2.0, early=0, late=0, **shape), counts)


def test_what_lets_nearly_all_pass_is_no_window():
    with pytest.raises(Refusal, match=r"lost is 0\.1, expected 0\.3 to 1"):
        effect.at(early=3, lost=0.1)
    rendering = SimpleNamespace(expected=np.full((20, 3, 30), 100.0), background=0.0)
    starts = effect.starts(-8.0 * (np.arange(30) > 18) * np.ones((20, 3, 1)), rendering.expected, rendering)
    assert all(start["lost"] >= 0.3 for start in starts if "lost" in start)


def test_signal_alone_may_be_cut_and_a_share_of_it_lost():
    counts = np.array([[[3.0, 13, 23, 33]]])
    np.testing.assert_allclose(seen(counts, 3.0, early=2, background=0), [[[3, 3, 23, 33]]])
    np.testing.assert_allclose(seen(counts, 3.0, early=2, lost=0.4), [[[1.8, 7.8, 23, 33]]])
    np.testing.assert_allclose(seen(counts, 3.0, early=2, background=0, lost=0.4), [[[3, 9, 23, 33]]])


@pytest.mark.parametrize("truth", [{"early": 30.0}, {"late": 25.0, "lost": 0.5}, {"early": 33.0, "softness": 4}])
@pytest.mark.parametrize("background", [0, 1])
def test_it_suggests_the_edges_beyond_which_counts_are_lost(truth, background):
    level = 40 + 200 * np.exp(-(((np.arange(64) - 32) / 12) ** 2))
    rendering = SimpleNamespace(expected=np.broadcast_to(level, (20, 3, 64)), background=np.full((3, 1), 40.0))
    cut = effect.expected(effect.at(**truth, background=background).values, rendering)
    excess = np.random.default_rng(5).poisson(cut) - rendering.expected
    starts = effect.starts(excess, rendering.expected, rendering)
    truth = truth | {"background": background}
    near = {"early": 1.5, "late": 1.5, "softness": 0.1, "lost": 0.1, "background": 0.1}
    assert any(all(np.all(np.abs(start[n] - v) <= near[n]) for n, v in truth.items()) for start in starts)


def test_each_zone_may_have_a_window_of_its_own():
    counts = np.random.default_rng(4).uniform(0, 9, (2, 2, 12))
    found = seen(counts, 2.0, early=[3, 0], late=[0, 4.5], lost=0.6)
    for zone, (early, late) in enumerate(((3, 0), (0, 4.5))):
        alone = seen(counts[:, [zone]], 2.0, early=early, late=late, lost=0.6)
        np.testing.assert_allclose(found[:, [zone]], alone)


def test_it_suggests_a_window_for_each_zone():
    level = 40 + 200 * np.exp(-(((np.arange(64) - 32) / 12) ** 2))
    rendering = SimpleNamespace(expected=np.broadcast_to(level, (20, 3, 64)), background=np.full((3, 1), 40.0))
    truth = {"early": np.array([20.0, 12.0, 26.0]), "late": np.array([14.0, 22.0, 9.0])}
    cut = effect.expected(effect.at(**truth).values, rendering)
    excess = np.random.default_rng(5).poisson(cut) - rendering.expected
    starts = effect.starts(excess, rendering.expected, rendering)
    assert any(
        all(np.ndim(start[name]) and np.abs(start[name] - edges).max() <= 1 for name, edges in truth.items())
        for start in starts
    )


def test_it_suggests_the_one_end_that_is_cut():
    """Of all zones alike: the end where more is lost, and not a little at the other."""
    mean = np.full((4, 3, 40), 50.0)
    for at, name in ((slice(0, 6), "early"), (slice(34, None), "late")):
        short = mean.copy()
        short[..., at] = 0
        starts = effect.starts(short - mean, mean, SimpleNamespace(background=np.zeros((3, 1))))
        alone = [start for start in starts if len({"early", "late"} & start.keys()) == 1]
        assert alone
        assert all(name in start and start[name] == 6 + (start["softness"] - 1) / 2 for start in alone)


@given(before=st.integers(0, 50), after=st.integers(0, 50), aside=st.floats(0, 1), seed=st.integers(0, 99))
def test_what_is_far_from_the_highest_bin_is_lost_in_part(before, after, aside, seed):
    """One histogram after the other, bin by bin."""
    counts = np.random.default_rng(seed).exponential(size=(2, 3, 40)) ** 2
    found = seen(counts, aside=aside, before=before, after=after)
    for f, p in np.ndindex(2, 3):
        (highest,) = np.flatnonzero(counts[f, p] == counts[f, p].max())
        for t in range(40):
            kept = 1.0 if highest - before <= t <= highest + after else 1 - aside
            assert found[f, p, t] == pytest.approx(kept * counts[f, p, t])


def test_a_divided_bin_is_lost_in_proportion():
    counts = np.where(np.arange(9) == 4, 20.0, 10.0)[None]
    np.testing.assert_allclose(seen(counts, aside=1, before=1.25, after=2.5), [[0, 0, 2.5, 10, 20, 10, 10, 5, 0]])
    # A background that was set aside before stays.
    kept = seen(counts, level=4.0, aside=1, before=1, after=1, background=0)
    np.testing.assert_allclose(kept, [[4, 4, 4, 10, 20, 10, 4, 4, 4]])


@pytest.mark.parametrize(("before", "after", "aside"), [(1, 3, 0.06), (4, 2, 0.3), (0, 8, 1.0)])
def test_it_suggests_the_window_about_the_highest_bin(before, after, aside):
    rng = np.random.default_rng(5)
    at = rng.uniform(20, 90, (40, 4, 1))
    counts = 20 + 3000 * np.diff(norm(at, 3.0).cdf(np.arange(121)), axis=-1)
    found = rng.poisson(seen(counts, aside=aside, before=before, after=after))
    dimmer = counts * found.sum() / counts.sum()
    starts = effect.starts(found - dimmer, dimmer, SimpleNamespace(background=0.0))
    (start,) = (one for one in starts if one.get("aside") and one["background"] == 0)
    assert (start["before"], start["after"]) == (before, after)
    assert start["aside"] == pytest.approx(aside, abs=0.02)


def test_where_it_is_summed_all_of_a_pulse_goes_by_its_part_inside():
    """The background, which is no part of the response, stays; half way each bin is half cut and half scaled."""
    signal = np.array([[1.0, 2, 10, 4, 3], [0, 0, 0, 6, 2]])
    part = np.array([[(2 + 10 + 4) / 20], [6 / 8]])
    found = seen(signal + 5, level=5.0, early=1, late=1, summed=1)
    np.testing.assert_allclose(found, 5 + signal * part)
    cut = seen(signal + 5, level=5.0, early=1, late=1)
    np.testing.assert_allclose(seen(signal + 5, level=5.0, early=1, late=1, summed=0.5), (found + cut) / 2)
    np.testing.assert_array_equal(seen(np.full((1, 4), 5.0), level=5.0, early=1, summed=1), np.full((1, 4), 5.0))


@pytest.mark.parametrize(("early", "late"), [(40, 30), (52, 0), (0, 45)])
def test_it_suggests_the_window_whose_part_of_a_pulse_scales_it(early, late):
    rng = np.random.default_rng(6)
    at = rng.uniform(25, 95, (60, 4, 1))
    counts = 2 + 3000 * np.diff(norm(at, 9.0).cdf(np.arange(121)), axis=-1)
    found = rng.poisson(0.8 * seen(counts, level=2.0, early=early, late=late, summed=1))
    dimmer = counts * found.sum() / counts.sum()
    starts = effect.starts(found - dimmer, dimmer, SimpleNamespace(background=2.0))
    sharp = next(one for one in starts if one.get("summed"))
    assert (sharp["early"], sharp["late"]) == pytest.approx((early, late), abs=3)


def test_it_suggests_none_where_gains_are_one():
    rng = np.random.default_rng(7)
    counts = 300 * np.diff(norm(rng.uniform(25, 95, (60, 4, 1)), 9.0).cdf(np.arange(121)), axis=-1)
    starts = effect.starts(rng.poisson(counts) - counts, counts, SimpleNamespace(background=0.0))
    assert not any(one.get("summed") for one in starts)
