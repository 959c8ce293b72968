"""Light between frames against numpy's own interpolation of every pixel, and where a frame knows nothing."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.light import Return, direct_light
from physics.light_between import from_neighbours, light_at
from recordings.refusal import Refusal

TIMES = np.array([0.0, 0.1, 0.1, 0.4, 0.45])


def scene(seed=7, shape=(5, 2, 3), times=TIMES):
    rng = np.random.default_rng(seed)
    some = [rng.uniform(0.3, 1, shape) for _ in range(3)]
    # Surfaces move a little; where they jump is another test.
    depth = some[0][:1] * 2 * rng.uniform(0.99, 1.01, shape)
    light = direct_light(depth, np.eye(3), some[1], some[2], time_s=times)
    way = Return(light.range_m * np.float32(1.5), light.returns[0].strength / 3)
    return replace(light, returns=(*light.returns, way))


@given(lag=st.floats(-1, 1), seed=st.integers(0, 99))
def test_every_pixel_is_interpolated_in_time(lag, seed):
    times = np.array([0.0, 0.1, 0.15, 0.4, 0.45])
    light = scene(seed, times=times)
    found = light_at(light, times + lag)
    pairs = [(light.range_m, found.range_m), (light.reflectance, found.reflectance), (light.cosine, found.cosine)]
    for before, after in zip(light.returns, found.returns, strict=True):
        pairs += [(before.range_m, after.range_m), (before.strength, after.strength)]
    for before, after in pairs:
        for v, u in np.ndindex(2, 3):
            np.testing.assert_allclose(after[:, v, u], np.interp(times + lag, times, before[:, v, u]), rtol=1e-5)
    np.testing.assert_array_equal(found.time_s, times)


def test_frames_of_one_time_are_passed_over():
    light = scene()
    found = light_at(light, np.array([0.0, 0.05, 0.1, 0.25, 9.0]))
    r = light.range_m
    np.testing.assert_array_equal(found.range_m[[0, 2, 4]], r[[0, 2, 4]])
    np.testing.assert_allclose(found.range_m[[1, 3]], [(r[0] + r[1]) / 2, (r[2] + r[3]) / 2], rtol=1e-6)


def test_what_one_frame_knows_is_taken_and_its_strength_fades():
    depth = np.array([[[1.0, np.nan, 1, np.nan]], [[2.0, 2, np.nan, 0]]])
    light = direct_light(depth, np.eye(3), None, np.ones(depth.shape), time_s=np.array([0.0, 1]))
    found = light_at(light, np.array([0.25, 1.0]))
    r, strength = light.range_m, light.returns[0].strength
    np.testing.assert_allclose(found.range_m[0, 0, :3], [0.75 * r[0, 0, 0] + 0.25 * r[1, 0, 0], r[1, 0, 1], r[0, 0, 2]])
    np.testing.assert_allclose(
        found.returns[0].strength[0, 0, 1:], [strength[1, 0, 1] / 4, strength[0, 0, 2] * 0.75, 0]
    )
    assert light.missing.tolist() == [2, 2]
    # At its own time the second frame is as it was.
    assert found.missing.tolist() == [1, 2]


def swept(at):
    """A plate at 0.5 m before a wall at 1.5 m; its edge is at pixel `at`, which it covers in part."""
    covered = np.clip(at - np.arange(400), 0, 1)
    return covered[None, None], np.where(covered > 0.5, 0.5, 1.5)[None, None]


def test_where_an_edge_passes_no_surface_is_seen_between_its_sides():
    """The plate sweeps from pixel 60 to 100 of 400: by the time between, half of these pixels have seen it come."""
    depth = np.concatenate([swept(60)[1], swept(100)[1]])
    light = direct_light(depth, np.diag([1e6, 1e6, 1]), None, np.ones(depth.shape), time_s=np.array([0.0, 1]))
    for part in (1e-6, 0.3, 0.5, 1 - 1e-6):
        found = light_at(light, np.array([part, 1.0]))
        ranges = np.concatenate([way.range_m[0].ravel() for way in found.returns])
        strength = np.concatenate([way.strength[0].ravel() for way in found.returns])
        seen = strength > 0
        assert set(np.round(ranges[seen], 3)) == {0.5, 1.5}
        covered = swept(60 + 40 * part)[0].sum()
        assert strength[seen & (ranges < 1)].sum() == pytest.approx(covered / 0.25, rel=1e-5)
        assert strength[seen & (ranges > 1)].sum() == pytest.approx((400 - covered) / 2.25, rel=1e-5)


def test_a_wall_that_nears_as_a_whole_is_no_edge():
    depth = np.stack([np.full((2, 3), 1.0), np.full((2, 3), 0.8)])
    light = direct_light(depth, np.diag([1e6, 1e6, 1]), None, np.ones(depth.shape), time_s=np.array([0.0, 1]))
    found = light_at(light, np.array([0.5, 1.0]))
    assert len(found.returns) == 1
    np.testing.assert_allclose(found.returns[0].range_m[0], 0.9, rtol=1e-6)


def test_frames_out_of_order_are_refused():
    with pytest.raises(Refusal, match=r"time_s\[2\] is 0.1, expected 0.2 or later as frames go by time"):
        light_at(scene(times=np.array([0, 0.2, 0.1, 0.3, 0.4])), TIMES)


@given(seed=st.integers(0, 99), off=st.floats(0, 0.1), part=st.floats(0, 1))
def test_beyond_its_ends_a_scene_moves_on_as_it_did(seed, off, part):
    times = np.array([0.0, 0.1, 0.2])
    light = scene(seed, (3, 2, 3), times)
    found = light_at(light, np.array([-off, 0.1, 0.2 + off]), part)
    r = light.range_m
    np.testing.assert_allclose(found.range_m[0], r[0] - part * off / 0.1 * (r[1] - r[0]), rtol=1e-5)
    np.testing.assert_array_equal(found.range_m[1], r[1])
    np.testing.assert_allclose(found.range_m[2], r[2] + part * off / 0.1 * (r[2] - r[1]), rtol=1e-5)
    assert all((way.strength >= 0).all() for way in found.returns)


def test_a_frame_is_guessed_from_its_neighbours():
    times = np.array([0.0, 0.1, 0.4])
    light = scene(3, (3, 2, 3), times)
    r = light.range_m
    found = from_neighbours(light)
    np.testing.assert_array_equal(found.range_m[[0, 2]], r[[0, 2]])
    np.testing.assert_allclose(found.range_m[1], 0.75 * r[0] + 0.25 * r[2], rtol=1e-6)
