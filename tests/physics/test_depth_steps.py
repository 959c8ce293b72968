"""Depth in steps: known by its numbers, and surfaces between them near those it was made of."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from physics.depth_steps import between_steps, drawn_together, step_of
from physics.light import direct_light

INTRINSICS = np.array([[40.0, 0, 23.5], [0, 40.0, 17.5], [0, 0, 1]])


def slanted(frames=4):
    """(F, H, W) metres: a wall, and a box in front of it that moves."""
    v, u = np.indices((36, 48))
    out = np.empty((frames, 36, 48))
    for i in range(frames):
        wall = 1 / (0.45 + 0.004 * (u - 24) + 0.003 * (v - 18) + 0.0013 * i)
        box = (np.abs(u - 15 - 2 * i) < 8) & (np.abs(v - 20) < 7)
        out[i] = np.where(box, 1 / (0.9 + 0.002 * (u - v)), wall)
    return out


def ranges(depth):
    return depth * np.linalg.norm(direct_light(depth, INTRINSICS).rays, axis=-1)


@pytest.mark.parametrize("inverse", [True, False])
def test_surfaces_between_steps_are_nearer_to_the_true_ones(inverse):
    true, step = slanted(), 0.01 if inverse else 0.02
    seen = 1 / (np.rint(1 / true / step) * step) if inverse else np.rint(true / step) * step
    light = direct_light(seen, INTRINSICS, cosine=np.full_like(seen, 0.8))
    smooth, said = between_steps(light)
    assert said == ("0.01 1/m" if inverse else "0.02 m")
    before, after = (np.abs(way - ranges(true)) for way in (light.range_m, smooth.returns[0].range_m))
    assert np.median(after) < 0.5 * np.median(before)
    assert np.sqrt((after**2).mean()) < 0.6 * np.sqrt((before**2).mean())
    # Half a step at most, and as bright as they are near.
    numbers = [1 / r if inverse else r for r in (light.range_m, smooth.returns[0].range_m)]
    away = np.abs(np.diff(numbers, axis=0)[0]) * (light.range_m / seen) ** (1 if inverse else -1)
    assert away.max() < 0.501 * step
    power = smooth.returns[0].strength * smooth.returns[0].range_m ** 2
    np.testing.assert_allclose(power, light.returns[0].strength * light.range_m**2, rtol=1e-5)


def test_incidence_told_by_depth_is_told_by_what_is_between():
    true, seen = slanted(), 1 / (np.rint(1 / slanted() / 0.01) * 0.01)
    before, after, there = (
        way.strength * way.range_m**2
        for way in (
            direct_light(seen, INTRINSICS).returns[0],
            between_steps(direct_light(seen, INTRINSICS))[0].returns[0],
            direct_light(true, INTRINSICS).returns[0],
        )
    )
    assert np.median(np.abs(after - there)) < 0.3 * np.median(np.abs(before - there))


def test_some_frames_are_smooth_as_all_are():
    light = direct_light(1 / (np.rint(1 / slanted() / 0.01) * 0.01), INTRINSICS)
    some = np.array([1, 3])
    whole, part = (between_steps(one)[0].returns[0].range_m for one in (light, light.of(some)))
    np.testing.assert_array_equal(part, whole[some])


def test_depth_without_steps_has_none():
    assert between_steps(direct_light(slanted(), INTRINSICS)) is None


def test_what_is_not_known_stays_so():
    depth = 1 / (np.rint(1 / slanted() / 0.01) * 0.01)
    depth[:, :5] = 0
    depth[1, 20, 20] = np.nan
    light = direct_light(depth, INTRINSICS)
    smooth = between_steps(light)[0].returns[0]
    unknown = ~(light.range_m > 0)
    np.testing.assert_array_equal(smooth.range_m[unknown], light.range_m[unknown])
    assert np.isfinite(smooth.strength).all()


@settings(max_examples=30, deadline=None)
@given(st.floats(1e-4, 0.1), st.floats(0, 1), st.integers(8, 40), st.integers(0, 2**31))
def test_the_step_of_whole_multiples_is_found(step, offset, many, seed):
    rng = np.random.default_rng(seed)
    whole = np.concatenate([np.arange(20, 20 + many), rng.integers(20, 20 + many, 40 * many)])
    numbers = ((whole + offset) * step).astype(np.float32)
    assert step_of(numbers) == pytest.approx(step, rel=1e-3)
    assert step_of(numbers * rng.uniform(0.9, 1.1, numbers.size)) is None


def test_few_values_are_no_steps():
    assert step_of(np.repeat(np.arange(1.0, 8.0), 100)) is None


def test_a_plane_in_disparity_stays_one():
    v, u = np.indices((9, 12))
    plane = 100 + 0.25 * u - 0.1 * v
    np.testing.assert_allclose(drawn_together(plane), plane, atol=1e-9)
    edge = np.where(u < 6, 100.0, 140.0)
    np.testing.assert_array_equal(drawn_together(edge), edge)
