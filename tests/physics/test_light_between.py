"""Light between frames against numpy's own interpolation of every pixel, and where a frame knows nothing."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.light import Return, direct_light
from physics.light_between import light_at
from recordings.refusal import Refusal

TIMES = np.array([0.0, 0.1, 0.1, 0.4, 0.45])


def scene(seed=7, shape=(5, 2, 3), times=TIMES):
    rng = np.random.default_rng(seed)
    some = [rng.uniform(0.3, 1, shape) for _ in range(3)]
    light = direct_light(some[0] * 2, np.eye(3), some[1], some[2], time_s=times)
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


def test_frames_out_of_order_are_refused():
    with pytest.raises(Refusal, match=r"time_s\[2\] is 0.1, expected 0.2 or later as frames go by time"):
        light_at(scene(times=np.array([0, 0.2, 0.1, 0.3, 0.4])), TIMES)
