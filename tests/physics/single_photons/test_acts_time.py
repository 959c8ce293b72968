"""Acts of time and estimator, each by itself: limits and closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects import find_effect
from physics.single_photons.acts import find_act
from physics.single_photons.draw import counts_of, returned
from physics.single_photons.world import NO_PIXEL, Photons

C = 299_792_458.0


@pytest.fixture
def session(both):
    return both().session


def lagged(world, lag):
    return find_act("time_lag").world(world, find_effect("time_lag").at(lag=lag).values, None)


def mean_range(world):
    """From how far a pixel's photons come on average."""
    part, metres = world.behind
    return world.range_m + part * metres


def sent(world):
    """Light by pixel, 0 where unknown."""
    return np.nan_to_num(world.reflectance * world.gloss * np.maximum(world.cosine, 0) / world.range_m**2)


@pytest.mark.parametrize(("lag", "frame"), [(0, 1), (0.1, 2), (-0.1, 0), (2, 2), (-2, 0)])
def test_a_whole_frames_lag_is_that_frame_and_ends_are_held(session, lag, frame):
    found, there = lagged(session.world(1), lag), session.world(frame)
    np.testing.assert_allclose(sent(found), sent(there), atol=1e-6)
    lit = sent(there) > 0
    np.testing.assert_allclose(mean_range(found)[lit], there.range_m[lit], atol=1e-6)
    assert found.time_s == session.world(1).time_s


def test_zones_beside_the_camera_see_the_depth_of_the_later_time(session):
    def beside(world):
        return find_act("parallax").world(
            world, {"x": 0.05, "y": -0.03, "ranges": 0.0, "whole": 0.0, "by_pixels": 0.0, "emitter": 0.0}, None
        )

    np.testing.assert_allclose(lagged(beside(session.world(1)), 0.1).weights, beside(session.world(2)).weights)


def test_between_frames_depth_and_light_are_on_their_way(session):
    before, after = session.world(1), session.world(2)
    found = lagged(before, 0.03)
    light = 0.7 * sent(before) + 0.3 * sent(after)
    np.testing.assert_allclose(sent(found), light, rtol=1e-6)
    # Ranges are drawn at random, so that nearly all jump; where they do photons come from the one or the other.
    ratio = after.range_m / before.range_m
    jumps = np.abs(np.log(ratio / np.nanmedian(ratio))) > np.log(1.05)
    assert 40 < jumps.sum() < 60
    from_after = 0.3 * sent(after)[jumps] / light[jumps]
    np.testing.assert_allclose(found.behind[0][jumps], from_after, rtol=1e-6)
    np.testing.assert_allclose(found.behind[1][jumps], (after.range_m - before.range_m)[jumps], rtol=1e-9)
    moves = np.isfinite(ratio) & ~jumps
    np.testing.assert_allclose(found.depth_m[moves], (0.7 * before.depth_m + 0.3 * after.depth_m)[moves], rtol=1e-6)


def test_where_one_frame_alone_knows_a_depth_it_is_taken_and_its_light_fades(session):
    first, second = session.world(0), session.world(1)
    assert np.isnan(first.depth_m[0, 0])
    found = lagged(first, 0.04)
    assert found.depth_m[0, 0] == second.depth_m[0, 0]
    assert sent(found)[0, 0] == pytest.approx(0.4 * sent(second)[0, 0])


def test_one_frame_alone_has_no_other_time(session):
    world = session.world(0)
    alone = replace(world, at=lambda time_s: world, times_s=np.zeros(1))
    np.testing.assert_allclose(sent(lagged(alone, 1.3)), sent(world))


@pytest.mark.parametrize("error", [-0.1, 0.0, 0.04])
def test_ranges_shrink_about_time_zero_as_bins_grow(session, error):
    world = replace(session.world(1), gain=1e4, pulse_time_s=np.arange(-1, 2) * 1e-15, pulse=np.array([0, 1.0, 0]))
    off = find_act("bin_width_error").world(world, find_effect("bin_width_error").at(error=error).values, None)
    truth, told = (returned(w, np.random.default_rng(1)) for w in (world, off))
    np.testing.assert_array_equal(truth.pixel, told.pixel)
    zero = (world.time_zero_s / world.bin_width_s)[truth.zone]
    truth_bins, told_bins = truth.time_s / world.bin_width_s - zero, told.time_s / off.bin_width_s - zero
    np.testing.assert_allclose(told_bins, truth_bins / (1 + error), rtol=1e-4)
    assert counts_of(told, off).sum() == len(told)


def at_phase(world, phase, many=20_000):
    """Photons of zone 0 from a pixel so far away that their pulse falls there in its bin; and the world."""
    time = (15 + phase) * world.bin_width_s - world.time_zero_s[0]
    depth = np.full_like(world.depth_m, np.nan)
    ray = np.linalg.norm([(3 - 4.5) / 7.5, (2 - 2.5) / 7.5, 1])
    depth[2, 3] = time * C / 2 / ray
    # When each photon is registered is another matter.
    late = np.random.default_rng(2).exponential(1e-9, many)
    photons = Photons(np.zeros(many, np.int32), 4e-9 + late, np.full(many, 23, np.int32), np.zeros(many, np.int32))
    return photons, replace(world, depth_m=depth)


@pytest.mark.parametrize("depth", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.55])
def test_as_many_photons_count_as_the_phase_says(session, depth, phase):
    act, values = find_act("bin_phase"), find_effect("bin_phase").at(depth=depth, phase=0.3).values
    photons, world = at_phase(session.world(1), phase)
    more = act.world(world, values, None)
    kept = act.photons(photons, more, values, np.random.default_rng(3))
    found = len(kept) / len(photons) * more.gain / world.gain
    assert found == pytest.approx(1 + depth * np.cos(2 * np.pi * (phase - 0.3)), abs=0.03)
    assert more.boost == pytest.approx(1 + depth)


def test_photons_from_no_pixel_count_as_at_a_mean_phase(session):
    act, values = find_act("bin_phase"), find_effect("bin_phase").at(depth=0.8, phase=0.3).values
    photons, world = at_phase(session.world(1), 0.8)
    loose = replace(photons, pixel=np.full(len(photons), NO_PIXEL))
    kept = act.photons(loose, act.world(world, values, None), values, np.random.default_rng(3))
    assert len(kept) / len(loose) == pytest.approx(1 / 1.8, abs=0.02)


def test_a_detour_is_part_of_where_a_pulse_falls(session):
    act, values = find_act("bin_phase"), find_effect("bin_phase").at(depth=1.0, phase=0.3).values
    photons, world = at_phase(session.world(1), 0.55)
    photons = replace(photons, detour_m=np.full(len(photons), 0.25 * world.bin_width_s * C))
    kept = act.photons(photons, act.world(world, values, None), values, np.random.default_rng(3))
    assert len(kept) < 1e-3 * len(photons)
