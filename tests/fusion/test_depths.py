"""Surfaces against the truth that drew the photons, and against a likelihood maximised by another program."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize

from fusion.depths import zone_depths
from fusion.range_response import range_response
from fusion.zone_view import DEAD, GOOD, SATURATED
from physics.effects import find_effect
from recordings.refusal import Refusal


def draw(response, light, seed, level=3.0):
    """Poisson counts (F, P, T) of light (F, P, B) under all of a sensor's effects."""
    expected = response.expected(light, np.full(light.shape[:2], level))
    return np.random.default_rng(seed).poisson(expected)


def walls(response, frames, amounts, at):
    """Light (F, P, B) of surfaces at grid ranges `at`, the same in all zones."""
    light = np.zeros((frames, 4, len(response.range_m)))
    for amount, b in zip(amounts, at, strict=True):
        light[:, :, b] += amount
    return light


def test_one_surface_is_found_within_its_stated_error(rig):
    seen = zone_depths(draw(rig.response, walls(rig.response, 60, [400], [30]), 1), rig.response)
    assert (np.isfinite(seen.surface_m).sum(axis=-1) == 1).mean() > 0.97
    pulls = (seen.surface_m[..., 0] - rig.response.range_m[30]) / seen.surface_sigma_m[..., 0]
    assert np.std(pulls) == pytest.approx(1, abs=0.2)
    assert np.mean(pulls) == pytest.approx(0, abs=0.4)
    assert np.mean(seen.surface_counts[..., 0]) == pytest.approx(400, rel=0.03)
    assert seen.nothing.max() < 1e-6
    np.testing.assert_allclose(seen.level.mean(), 3, rtol=0.1)


def exactly(rig, light, range_m, level=3.0):
    """(4, 48) expected counts of light from any range, on no grid: every step of the pulse against every bin."""
    edges = np.arange(rig.sensor.bins + 1) * rig.sensor.bin_width_s
    pulse = rig.sensor.response
    step = pulse.time_s[1] - pulse.time_s[0]
    low = rig.sensor.time_zero_s[:, None] + 2 * range_m / 299_792_458.0 + pulse.time_s - step / 2
    passed = np.clip((edges - low[..., None]) / step, 0, 1)
    return light * np.diff(np.einsum("s,pse->pe", pulse.probability, passed), axis=1) + level


@pytest.mark.parametrize("light", [300, 3000, 30_000])
def test_the_range_is_where_another_program_finds_the_highest_likelihood(rig, light):
    place = rig.response.range_m[33] + 0.013
    counts = np.random.default_rng(2).poisson(exactly(rig, light, place))
    seen = zone_depths(counts, rig.response)

    def loss(values):
        rate = exactly(rig, np.exp(values[0]), values[1], np.exp(values[2]))[2]
        return (rate - counts[2] * np.log(rate)).sum()

    start = [np.log(light), place, np.log(3)]
    best = minimize(loss, start, method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-7, "maxiter": 3000})
    assert seen.surface_m[2, 0] == pytest.approx(best.x[1], abs=0.25 * seen.surface_sigma_m[2, 0])
    assert seen.surface_counts[2, 0] == pytest.approx(np.exp(best.x[0]), rel=0.01)


@pytest.mark.parametrize("light", [100, 1000, 10_000])
def test_stated_errors_hold_between_the_steps(rig, light):
    rng = np.random.default_rng(light)
    places = rng.uniform(rig.response.range_m[10], rig.response.range_m[55], 75)
    seen = zone_depths(np.stack([rng.poisson(exactly(rig, light, place)) for place in places]), rig.response)
    pulls = (seen.surface_m[..., 0] - places[:, None]) / seen.surface_sigma_m[..., 0]
    assert np.isfinite(pulls).mean() > 0.97
    # 68 % of 300 have a standard error of 2.7 %.
    assert (np.abs(pulls[np.isfinite(pulls)]) < 1).mean() == pytest.approx(0.683, abs=0.08)


def test_two_surfaces_too_close_to_tell_apart_are_one_of_some_width(rig):
    """Its range is their mean, and less certain than that of one as bright."""
    rng, places, gap = np.random.default_rng(3), np.linspace(0.6, 1.6, 40), 0.03
    close = [rng.poisson(exactly(rig, 5000, a) + exactly(rig, 5000, a + gap, 0.0)) for a in places]
    seen = zone_depths(np.stack(close), rig.response)
    one = zone_depths(np.stack([rng.poisson(exactly(rig, 10_000, a)) for a in places]), rig.response)
    assert (np.isfinite(seen.surface_m).sum(axis=-1) == 1).mean() > 0.95
    pulls = (seen.surface_m[..., 0] - places[:, None] - gap / 2) / seen.surface_sigma_m[..., 0]
    assert 0.55 < (np.abs(pulls) < 1).mean() < 0.8
    assert np.median(seen.surface_sigma_m[..., 0]) > 1.1 * np.median(one.surface_sigma_m[..., 0])
    assert np.median(seen.surface_spread_m[..., 0]) == pytest.approx(gap / 2, rel=0.2)


def test_two_surfaces_in_one_zone(rig):
    seen = zone_depths(draw(rig.response, walls(rig.response, 20, [900, 500], [20, 40]), 3), rig.response)
    assert (np.isfinite(seen.surface_m).sum(axis=-1) == 2).mean() > 0.95
    near, far = rig.response.range_m[[20, 40]]
    np.testing.assert_allclose(np.nanmedian(seen.surface_m[..., 0]), near, atol=0.005)
    np.testing.assert_allclose(np.nanmedian(seen.surface_m[..., 1]), far, atol=0.005)
    # Counts fall with r²: by area the far one is the larger.
    area = np.array([900 * near**2, 500 * far**2])
    np.testing.assert_allclose(np.nanmean(seen.area[..., :2], axis=(0, 1)), area / area.sum(), atol=0.03)
    np.testing.assert_allclose(np.nanmean(seen.mean_m), area @ [near, far] / area.sum(), atol=0.01)
    apart = np.sqrt((area / area.sum()) @ (np.array([near, far]) - area @ [near, far] / area.sum()) ** 2)
    np.testing.assert_allclose(np.nanmean(seen.deviation_m), apart, rtol=0.1)


def test_where_nothing_is_it_says_so(rig):
    dark = draw(rig.response, walls(rig.response, 100, [], []), 4)
    seen = zone_depths(dark, rig.response)
    assert (seen.nothing > 0.5).mean() > 0.9
    assert np.isfinite(seen.surface_m).any(axis=-1).mean() < 0.03
    assert np.isnan(seen.mean_m[~np.isfinite(seen.surface_m).any(axis=-1)]).all()


def test_a_background_that_is_known_is_held(rig):
    counts = draw(rig.response, walls(rig.response, 1, [200], [30]), 5)[0]
    held = zone_depths(counts, rig.response, np.full(4, 3.0))
    np.testing.assert_array_equal(held.level, 3.0)
    sunny = zone_depths(draw(rig.response, walls(rig.response, 1, [2000], [30]), 5, level=40.0)[0], rig.response)
    np.testing.assert_allclose(sunny.level, 40, rtol=0.15)


@pytest.mark.parametrize(
    ("setting", "worst_m"),
    [
        (find_effect("pile_up").at(share=1.0), 0.006),
        (find_effect("range_walk").at(walk=1e-10), 0.006),
        (find_effect("time_zero_offset").at(delay=2e-10), 0.004),
        (find_effect("counter_saturation").at(ceiling=4095.0), 0.02),
    ],
)
def test_what_the_sensor_does_is_undone(rig, setting, worst_m):
    """Bright light, which the nominal sensor would take for another range."""
    response = range_response(replace(rig.sensor, effects=(setting,)))
    counts = draw(response, walls(response, 3, [30_000], [30]), 6)
    told, untold = zone_depths(counts, response), zone_depths(counts, rig.response)
    off = np.abs(told.surface_m[..., 0] - response.range_m[30])
    assert off.max() < worst_m
    assert off.mean() < 0.5 * np.abs(untold.surface_m[..., 0] - response.range_m[30]).mean()


def test_stray_light_makes_no_surface(rig):
    """What three zones see of the bright fourth is no surface of theirs."""
    response = range_response(replace(rig.sensor, effects=(find_effect("stray_light").at(share=0.02),)))
    light = walls(response, 4, [300], [40])
    light[:, 0, 20] = 20_000
    seen = zone_depths(draw(response, light, 7), response)
    assert (np.isfinite(seen.surface_m[:, 1:]).sum(axis=-1) == 1).all()
    np.testing.assert_allclose(seen.surface_m[:, 1:, 0], response.range_m[40], atol=0.02)


def test_dead_and_saturated_zones_say_nothing(rig):
    counts = draw(rig.response, walls(rig.response, 1, [5000], [30]), 8)[0]
    counts[1] = 0
    counts[2] = np.minimum(counts[2], 255)
    seen = zone_depths(counts, rig.response)
    assert seen.state.tolist() == [GOOD, DEAD, SATURATED, GOOD]
    assert np.isfinite(seen.mean_m).tolist() == [True, False, False, True]
    assert np.isnan(seen.nothing[[1, 2]]).all()


def test_a_frame_alone_is_as_among_others(rig):
    counts = draw(rig.response, walls(rig.response, 3, [500, 300], [20, 45]), 9)
    several = zone_depths(counts, rig.response).frame(1)
    alone = zone_depths(counts[1], rig.response)
    for name in ("surface_m", "surface_sigma_m", "mean_m", "nothing", "light"):
        np.testing.assert_array_equal(getattr(several, name), getattr(alone, name))


@settings(max_examples=25, deadline=None)
@given(arrays(np.int64, (4, 48), elements=st.integers(0, 10**6) | st.integers(0, 5)))
def test_any_counts_become_something_finite_or_nothing(rig, counts):
    seen = zone_depths(counts, rig.response)
    known = np.isfinite(seen.surface_m)
    assert (seen.surface_m[known] > 0).all()
    assert (seen.surface_sigma_m[known] > 0).all()
    assert (seen.light >= 0).all()
    np.testing.assert_allclose(np.nansum(seen.area, axis=-1), known.any(axis=-1))
    good = seen.state == GOOD
    assert ((seen.nothing[good] >= 0) & (seen.nothing[good] <= 1)).all()


@pytest.mark.parametrize(
    ("counts", "sentence"),
    [
        (np.zeros((4, 47)), r"counts have shape \(4, 47\), expected \(4, 48\)"),
        (np.full((4, 48), np.nan), "counts hold NaN"),
        (np.full((4, 48), -1), "values below 0"),
    ],
)
def test_counts_that_cannot_be_are_refused(rig, counts, sentence):
    with pytest.raises(Refusal, match=sentence):
        zone_depths(counts, rig.response)
