"""Each cause outside the library against arithmetic of its own."""

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from physics.clock import Clock
from physics.effects import all_effects
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import tailed_pulse
from physics.rendering import Rendering

from ..conftest import BACKGROUND, BINS, INTRINSICS, WIDTH_S
from .conftest import CAUSES, changed


def test_none_has_a_name_of_the_library():
    assert not CAUSES.keys() & all_effects().keys()
    assert {"frame_average", "depth_bowl", "depth_error"} <= CAUSES.keys()


@pytest.mark.parametrize("name", CAUSES)
def test_where_it_vanishes_nothing_changes(scene, name):
    model, *_ = scene
    np.testing.assert_array_equal(model.expected(1000.0, (CAUSES[name].vanished(),)), model.expected(1000.0))


@pytest.mark.parametrize("name", CAUSES)
def test_a_little_of_it_changes_a_little(scene, name):
    model, *_ = scene
    effect, nothing = CAUSES[name], model.expected(1000.0)
    (strength, *_) = [n for n in effect.forms[0] if effect.parameter(n).vanishes_at is not None]
    start = effect.parameter(strength).start
    whole, part = (np.abs(changed(model, name, **{strength: start * s}) - nothing).max() for s in (1.0, 0.01))
    assert 0 < part < 0.1 * whole


def test_a_recursive_filter(scene):
    model, *_ = scene
    plain = model.expected(1000.0)
    # Begun as if the first frame had been shown for ever.
    oracle = lfilter([0.7], [1, -0.3], plain, axis=0, zi=0.3 * plain[:1])[0]
    np.testing.assert_allclose(changed(model, "frame_average", share=0.3), oracle, rtol=1e-12)


@pytest.mark.parametrize("half", [0.3, 1.0, 2.6])
def test_a_long_exposure_is_a_mean_over_time(scene, half):
    """Counts between frames by interpolation, averaged over many times; the ends stand still."""
    model, *_ = scene
    plain = model.expected(1000.0)
    found = changed(model, "long_exposure", half=half)
    frames = np.arange(len(plain))
    moments = frames[:, None] + half * (np.arange(20000) + 0.5) / 10000 - half
    for zone, bin_ in ((0, 20), (3, 25)):
        seen = np.interp(moments, frames, plain[:, zone, bin_]).mean(axis=1)
        np.testing.assert_allclose(found[:, zone, bin_], seen, rtol=1e-5, atol=1e-6 * plain.max())


@pytest.mark.parametrize(
    ("feeds", "mates"), [(0, {0: (1, 2, 3), 3: (0, 1, 2)}), (1, {0: (1,), 3: (2,)}), (2, {0: (2,)})]
)
def test_a_supply_that_sags(scene, feeds, mates):
    """Four zones in two rows of two."""
    model, *_ = scene
    light = model.expected(1000.0) - BACKGROUND[:, None]
    together = {0: [{0, 1, 2, 3}], 1: [{0, 1}, {2, 3}], 2: [{0, 2}, {1, 3}]}[feeds]
    for background, straight, (zone, others) in product((0, 1), (0, 1), mates.items()):
        total = (light + background * BACKGROUND[:, None]).sum(axis=-1)
        most = max(total[:, list(group - {zone})].sum(axis=1).max() for group in together for zone in group)
        how = {"drawn": 0.2, "feeds": feeds, "background": background, "straight": straight}
        found = changed(model, "shared_supply", **how)[:, zone]
        drawn = (0.2 * total[:, others].sum(axis=1) / most)[:, None]
        left = 1 - drawn if straight else 1 / (1 + drawn)
        level = BACKGROUND[zone] * (left if background else 1)
        np.testing.assert_allclose(found, light[:, zone] * left + level, rtol=1e-9)


def test_a_bias_that_droops_for_all_zones(scene):
    """Count after count: what the array has counted in all bins before, each less the longer ago."""
    model, *_ = scene
    plain, found = model.expected(1000.0), changed(model, "bias_droop", droop=0.3, recovery=2e-9)
    drawn = np.zeros((len(plain), BINS))
    for later in range(BINS):
        for t in range(later):
            drawn[:, later] += plain[:, :, t].sum(axis=1) * np.exp(-(later - t - 1) * WIDTH_S / 2e-9)
    left = np.exp(-0.3 * drawn / drawn.max())
    np.testing.assert_allclose(found, plain * left[:, None], rtol=1e-9)


@pytest.mark.parametrize("stamped", [0.5, 0.0])
def test_rows_are_taken_one_after_another(scene, stamped):
    """Against frames cut and put together row by row, of a wall that comes nearer evenly: there between is linear."""
    _, light, clock = scene
    depth = 1.0 - 0.4 * light.time_s[:, None, None] * np.ones((1, *light.range_m.shape[1:]))
    wall = direct_light(depth, light.intrinsics, time_s=light.time_s)
    readout, height = 0.03, depth.shape[1]
    found = CAUSES["rolling_shutter"].at(readout=readout, stamped=stamped)
    seen = found.effect.light(found.values, Rendering(wall, None, clock, 1.0))
    late = (np.floor(np.arange(height) * 6 / height) + 0.5) / 6 - stamped
    for row in range(height):
        then = np.clip(light.time_s - readout * late[row], light.time_s[0], light.time_s[-1])
        ratio = np.interp(then, light.time_s, wall.range_m[:, row, 0]) / wall.range_m[:, row, 0]
        np.testing.assert_allclose(seen.returns[0].range_m[:, row, 0] / wall.range_m[:, row, 0], ratio, rtol=1e-5)


def test_rows_may_be_taken_from_either_end(scene, maps):
    _, light, clock = scene
    there = Rendering(light, footprints(maps, light.range_m.shape[1:]), clock, 1.0)
    starts = CAUSES["rolling_shutter"].starts(None, None, there)
    step_s = light.time_s[1]
    assert {np.sign(start["readout"]) for start in starts} == {-1, 1}
    assert all(abs(start["readout"]) < step_s / 2 for start in starts)
    still = replace(light, time_s=np.zeros_like(light.time_s))
    assert not CAUSES["rolling_shutter"].starts(None, None, Rendering(still, None, clock, 1.0))


def test_a_stale_frame(scene):
    model, *_ = scene
    plain, found = model.expected(1000.0), changed(model, "stale_frame", share=0.2, age=2)
    np.testing.assert_allclose(found[5], 0.8 * plain[5] + 0.2 * plain[3], rtol=1e-12)
    np.testing.assert_allclose(found[1], 0.8 * plain[1] + 0.2 * plain[0], rtol=1e-12)
    np.testing.assert_allclose(changed(model, "stale_frame", ever=0.1)[3], plain[3] + 0.1 * plain[0], rtol=1e-12)


def test_one_frame_that_stays_is_found_among_all(scene):
    model, light, _ = scene
    plain, at = model.expected(1000.0), float(light.time_s[4])
    found = changed(model, "stale_frame", ever=0.1, at=at)
    np.testing.assert_allclose(found, plain + 0.1 * plain[4], rtol=1e-12)
    starts = CAUSES["stale_frame"].starts(found - plain, plain, SimpleNamespace(light=light))
    assert {"ever": 0.01, "at": at} in starts[8:]
    assert 1 < len(starts[8:]) <= 9
    between = changed(model, "stale_frame", ever=0.1, at=float(0.75 * light.time_s[4] + 0.25 * light.time_s[5]))
    np.testing.assert_allclose(between, plain + 0.1 * (0.75 * plain[4] + 0.25 * plain[5]), rtol=1e-12)


def test_depth_that_errs_with_its_square(scene, maps):
    model, light, clock = scene
    found = changed(model, "depth_error", error=0.05)
    true = light.range_m * (1 + 0.05 * light.range_m)
    scale = np.linalg.norm(light.rays, axis=-1)
    # The same surfaces, seen at the same angles.
    moved = direct_light(true / scale, INTRINSICS, cosine=light.cosine, time_s=light.time_s)
    there = ForwardModel(moved, footprints(maps, true.shape[1:]), clock, BACKGROUND)
    np.testing.assert_allclose(found, there.expected(1000.0), rtol=1e-4)


def test_depth_that_errs_to_and_fro_with_range(scene, maps):
    model, light, clock = scene
    found = changed(model, "depth_ripple", sine=0.02, cosine=-0.01, period=0.3)
    phase = 2 * np.pi * light.range_m / 0.3
    true = light.range_m + 0.02 * np.sin(phase) - 0.01 * np.cos(phase)
    scale = np.linalg.norm(light.rays, axis=-1)
    moved = direct_light(true / scale, INTRINSICS, cosine=light.cosine, time_s=light.time_s)
    there = ForwardModel(moved, footprints(maps, true.shape[1:]), clock, BACKGROUND)
    np.testing.assert_allclose(found, there.expected(1000.0), rtol=1e-4)


def test_depth_that_errs_to_and_fro_over_its_image(scene, maps):
    model, light, clock = scene
    found = changed(model, "depth_waves", sine=0.02, cosine=-0.01, across=1.5, down=-0.5)
    (height, width), true = light.range_m.shape[1:], light.range_m.copy()
    for row, column in product(range(height), range(width)):
        phase = 2 * np.pi * (1.5 * column / width - 0.5 * row / height)
        true[:, row, column] *= 1 + 0.02 * np.sin(phase) - 0.01 * np.cos(phase)
    moved = direct_light(
        true / np.linalg.norm(light.rays, axis=-1), INTRINSICS, cosine=light.cosine, time_s=light.time_s
    )
    there = ForwardModel(moved, footprints(maps, true.shape[1:]), clock, BACKGROUND)
    np.testing.assert_allclose(found, there.expected(1000.0), rtol=1e-4)


def test_periods_are_looked_for_in_the_ranges_in_view(scene):
    _, light, _ = scene
    starts = CAUSES["depth_ripple"].starts(np.zeros(1), np.zeros(1), SimpleNamespace(light=light))
    most = max(start["period"] for start in starts)
    assert 0.5 * np.ptp(light.range_m) < most <= np.ptp(light.range_m)
    nothing = SimpleNamespace(light=SimpleNamespace(range_m=np.full((2, 3, 4), np.nan)))
    assert CAUSES["depth_ripple"].starts(np.zeros(1), np.zeros(1), nothing) == []


def test_counts_that_go_by_a_power(scene):
    model, *_ = scene
    found = changed(model, "power_law", more=0.1, full=200.0)
    np.testing.assert_allclose(found, np.exp(1.1 * np.log(model.expected(1000.0)) - 0.1 * np.log(200)), rtol=1e-12)


def test_depth_along_the_ray_is_a_bowl(scene, maps):
    """Ranges along the ray that were taken for depths, by trigonometry; to first order in tan²."""
    model, light, clock = scene
    square = (light.rays[..., :2] ** 2).sum(axis=-1)
    found = changed(model, "depth_bowl", bowl=0.3, scale=0.02)
    true = light.range_m * (1 + 0.3 * square + 0.02)
    scale = np.linalg.norm(light.rays, axis=-1)
    moved = direct_light(true / scale, INTRINSICS, cosine=light.cosine, time_s=light.time_s)
    there = ForwardModel(moved, footprints(maps, true.shape[1:]), clock, BACKGROUND)
    np.testing.assert_allclose(found, there.expected(1000.0), rtol=1e-4)


@pytest.mark.parametrize(
    ("settles", "at_first", "stays"), [(0.2, 0.0, 0.0), (20.0, 0.0, 0.0), (20.0, 1.0, 0.0), (20.0, 0.5, 0.1)]
)
def test_a_beam_narrows_as_the_session_goes_on(scene, maps, settles, at_first, stays):
    model, light, clock = scene
    found = changed(model, "narrowing_beam", narrowed=2.0, settles=settles, at_first=at_first, stays=stays)
    elapsed = np.asarray(light.time_s) / light.time_s[-1]
    gone = (1 - np.exp(-elapsed / settles)) / (1 - np.exp(-1 / settles))
    square = (light.rays[..., :2] ** 2).sum(axis=-1)
    # Darker surfaces where less light falls on them.
    darker = np.exp(-(at_first + 2.0 * gone[:, None, None]) * (square - stays)) / 2
    depth = light.range_m / np.linalg.norm(light.rays, axis=-1)
    dim = direct_light(depth, INTRINSICS, reflectance=darker, cosine=light.cosine, time_s=light.time_s)
    there = ForwardModel(dim, footprints(maps, depth.shape[1:]), clock, BACKGROUND)
    np.testing.assert_allclose(found, there.expected(2000.0), rtol=1e-4)
    assert np.allclose(found[0], model.expected(1000.0)[0], rtol=1e-6) == (not at_first)


def test_detectors_that_tire(scene):
    model, *_ = scene
    light = model.expected(1000.0) - BACKGROUND[:, None]
    total, memory = light.sum(axis=-1), 2.5
    found = changed(model, "fatigue", tired=0.3, memory=memory)
    kept = np.exp(-1 / memory)
    # A recursive filter of what was received up to the frame before.
    mean = lfilter([0.0, 1 - kept], [1, -kept], total, axis=0)
    wanted = light / (1 + 0.3 * mean / total.max())[..., None] + BACKGROUND[:, None]
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    every = light + BACKGROUND[:, None]
    mean = lfilter([0.0, 1 - kept], [1, -kept], every.sum(axis=-1), axis=0)
    wanted = every / (1 + 0.3 * mean / every.sum(axis=-1).max())[..., None]
    np.testing.assert_allclose(changed(model, "fatigue", tired=0.3, memory=memory, background=1.0), wanted, rtol=1e-9)
    # Together, and as if the first frame had always been seen: the filter begins as one that has settled.
    mean_zone = total.mean(axis=1)
    mean, _ = lfilter([0.0, 1 - kept], [1, -kept], mean_zone, zi=mean_zone[:1])
    left = 1 / (1 + 0.3 * mean / mean_zone.max())[:, None, None]
    found = changed(model, "fatigue", tired=0.3, memory=memory, shared=1.0, before=1.0)
    np.testing.assert_allclose(found, light * left + BACKGROUND[:, None], rtol=1e-9)
    # The background was recorded with detectors as tired as in the mean.
    total = every.sum(axis=-1)
    left = 1 / (1 + 0.3 * lfilter([0.0, 1 - kept], [1, -kept], total, axis=0) / total.max())[..., None]
    found = changed(model, "fatigue", tired=0.3, memory=memory, background=1.0, usual=1.0)
    np.testing.assert_allclose(found, light * left + BACKGROUND[:, None] * left / left.mean(), rtol=1e-9)


def test_times_that_scatter_in_proportion_to_range(scene):
    model, _, clock = scene
    light = model.expected(1000.0) - BACKGROUND[:, None]
    found = changed(model, "range_jitter", rate=0.02) - BACKGROUND[:, None]
    bins = np.arange(BINS) + 0.5
    one, zone = 2, 1

    def moments(counts):
        mean = counts @ bins / counts.sum()
        return mean, counts @ (bins - mean) ** 2 / counts.sum()

    (mean, before), (mean_after, after) = moments(light[one, zone]), moments(found[one, zone])
    flight = bins - clock.time_zero_s[zone] / WIDTH_S
    assert found[one, zone].sum() == pytest.approx(light[one, zone].sum(), rel=1e-3)
    assert mean_after == pytest.approx(mean, abs=0.02)
    added = 0.02**2 * (light[one, zone] @ np.maximum(flight, 0) ** 2) / light[one, zone].sum()
    assert after - before == pytest.approx(added, rel=0.05)


def test_a_dark_level_that_falls_and_one_that_rises(scene):
    model, *_ = scene
    t, plain = (np.arange(BINS) + 0.5) / BINS, model.expected(1000.0)
    falling = changed(model, "dark_slope", falling=np.array([1.0, 2, 3, 4]), rate=4.0)
    np.testing.assert_allclose((falling - plain)[3, 2], 3 * np.exp(-4 * t), atol=1e-9)
    rising = changed(model, "dark_slope", rising=5.0, power=2.0)
    np.testing.assert_allclose((rising - plain)[0, 0], 5 * t**2, atol=1e-9)


@pytest.mark.parametrize("axis", [(0.0, 0.0), (0.2, -0.3)])
def test_a_lens_pulls_maps_outward(scene, maps, axis):
    _, light, clock = scene
    where = footprints(maps, light.range_m.shape[1:])
    found = CAUSES["lens_distortion"].at(cubic=0.1, axis_x=axis[0], axis_y=axis[1])
    start = Rendering(light, where, clock, 1.0)
    moved = found.effect.footprints(found.values, start)
    width, height = maps.image_size
    half = np.hypot(width, height) / 2
    x, y = where.x_px[2, 3] - (width - 1) / 2 - half * axis[0], where.y_px[2, 3] - (height - 1) / 2 - half * axis[1]
    by = 0.1 * (np.hypot(x, y) / half) ** 2
    read = where.field.faded(np.array([where.x_px[2, 3] - by * x]), np.array([where.y_px[2, 3] - by * y]))[:, 0]
    np.testing.assert_allclose(moved.weights[:, 2, 3], read / where.scale, rtol=1e-9)


# A grid of 2 rows and 2 columns: which zone's light each receives, -1 where there is none.
@pytest.mark.parametrize(
    ("of", "there"), [(1, [3, 2, 1, 0]), (2, [1, 0, 3, 2]), (3, [2, 3, 0, 1]), (4, [-1, 0, 1, 2]), (5, [1, 2, 3, -1])]
)
def test_a_ghost_is_another_zones_light_some_bins_later(scene, of, there):
    model, *_ = scene
    light = model.expected(1000.0) - BACKGROUND[:, None]
    found = changed(model, "zone_ghost", share=0.1, delay=3 * WIDTH_S, of=of) - BACKGROUND[:, None]
    theirs = np.where((np.array(there) >= 0)[:, None], light[:, there], 0)
    np.testing.assert_allclose(found[..., 3:], (light[..., 3:] + 0.1 * theirs[..., :-3]), atol=1e-9 * light.max())


@pytest.mark.parametrize("of", [1, 3, 5])
def test_a_ghost_is_looked_for_where_it_is(scene, of):
    model, _, clock = scene
    ghost = CAUSES["zone_ghost"]
    plain = model.expected(1000.0)
    found = changed(model, "zone_ghost", share=0.1, delay=5 * WIDTH_S, of=of)
    rendering = SimpleNamespace(
        clock=clock, background=BACKGROUND[:, None], footprints=SimpleNamespace(zone_grid=(2, 2))
    )
    starts = ghost.starts(found - plain, plain, rendering)
    delays = [start["delay"] for start in starts if start.get("of") == of]
    assert min(abs(delay - 5 * WIDTH_S) for delay in delays) <= WIDTH_S


def test_data_tell_whose_ghost_a_zone_receives(scene):
    model, _, clock = scene
    plain = model.expected(1000.0)
    found = changed(model, "zone_ghost", share=0.3, delay=4 * WIDTH_S, source=[2, 1, 1, 3])
    light = plain - BACKGROUND[:, None]
    np.testing.assert_allclose((found - plain)[:, 0, 4:], 0.3 * light[:, 2, :-4], atol=1e-9 * light.max())
    np.testing.assert_allclose(found[:, [1, 3]], plain[:, [1, 3]], rtol=1e-12)
    rendering = SimpleNamespace(
        clock=clock, background=BACKGROUND[:, None], footprints=SimpleNamespace(zone_grid=(2, 2))
    )
    start = CAUSES["zone_ghost"].starts(found - plain, plain, rendering)[-1]
    assert start["source"].tolist() == [2, 1, 1, 3]
    assert start["delay"] == pytest.approx(4 * WIDTH_S, abs=WIDTH_S / 2)


@pytest.mark.parametrize("pixels", [1, 2])
def test_what_is_near_is_narrower_than_the_camera_shows_it(maps, pixels):
    """A board that loses its border all round, against the scene with the narrower board."""
    seen, true = np.full((2, 10, 17), 1.0), np.full((2, 10, 17), 1.0)
    seen[:, 1:9, 4:12] = 0.5
    true[:, 1 + pixels : 9 - pixels, 4 + pixels : 12 - pixels] = 0.5
    pulse = tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.1, step_s=WIDTH_S / 16)
    clock = Clock(WIDTH_S, BINS, np.full(4, 2e-9), pulse)
    plane = np.array([[1e4, 0, 8.0], [0, 1e4, 4.5], [0, 0, 1]])  # Rays as good as parallel: strengths are 1/r².
    models = [
        ForwardModel(
            direct_light(depth, plane, None, np.ones(depth.shape), time_s=np.arange(2)),
            footprints(maps, (10, 17)),
            clock,
            BACKGROUND,
        )
        for depth in (seen, true)
    ]
    whole, half = (changed(models[0], "fat_edges", share=s, pixels=pixels) for s in (1.0, 0.5))
    np.testing.assert_allclose(whole, models[1].expected(1000.0), rtol=1e-5)
    np.testing.assert_allclose(half, (whole + models[0].expected(1000.0)) / 2, rtol=1e-5)


@pytest.mark.parametrize("azimuth", [0, 30, 135])
def test_what_is_polarised_goes_with_the_plane_of_incidence(maps, azimuth):
    """A plane that leans by 40 degrees towards an azimuth, seen from so far that all rays meet it alike."""
    way, sine = np.radians(azimuth), np.sin(np.radians(40))
    focal = 1e4
    y, x = np.mgrid[:10, :17] - np.array([4.5, 8.0])[:, None, None]
    depth = 1 / (1 + np.tan(np.radians(40)) * (np.cos(way) * x + np.sin(way) * y) / focal)
    pulse = tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.1, step_s=WIDTH_S / 16)
    clock, far = Clock(WIDTH_S, BINS, np.full(4, 2e-9), pulse), np.array([[focal, 0, 8.0], [0, focal, 4.5], [0, 0, 1]])
    light = direct_light(depth[None], far, time_s=np.zeros(1))
    model = ForwardModel(light, footprints(maps, (10, 17)), clock, BACKGROUND)
    found = changed(model, "polarised", along=0.5, across=-0.3) - BACKGROUND[:, None]
    brighter = 1 + sine**2 * (0.5 * np.cos(2 * way) - 0.3 * np.sin(2 * way))
    np.testing.assert_allclose(found, brighter * (model.expected(1000.0) - BACKGROUND[:, None]), rtol=5e-3, atol=1e-9)


def test_what_analyses_light_behind_the_lens_sees_one_azimuth_of_a_plane():
    """Each ray meets it under an angle of its own; its normal, whose azimuth is 20 degrees, is the same for all."""
    matrix = np.array([[15.0, 0, 8], [0, 15, 4.5], [0, 0, 1]])
    v, u = np.mgrid[:10, :17]
    rays = np.stack([(u - 8) / 15, (v - 4.5) / 15, np.ones((10, 17))], axis=-1)
    normal = np.array([0.6 * np.cos(np.radians(20)), 0.6 * np.sin(np.radians(20)), -0.8])
    light = direct_light((-1.0 / (rays @ normal))[None], matrix, time_s=np.zeros(1))
    values = CAUSES["polarised"].at(along=0.4, across=0.1, telecentric=1).values
    found = CAUSES["polarised"].light(values, SimpleNamespace(light=light)).returns[0].strength
    cosine = -(rays @ normal) / np.linalg.norm(rays, axis=-1)
    oracle = 1 + (1 - cosine**2) * (0.4 * np.cos(np.radians(40)) + 0.1 * np.sin(np.radians(40)))
    brighter = (found / light.returns[0].strength)[0]
    np.testing.assert_allclose(brighter[1:-1, 1:-1], oracle[1:-1, 1:-1], rtol=2e-3)
