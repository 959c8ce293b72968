"""Surfaces told apart: rooms and boxes cast ray by ray, whose faces are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.segments import segments

INTRINSICS = np.array([[40.0, 0, 31.5], [0, 40.0, 23.5], [0, 0, 1]])
SHAPE = (48, 64)
V, U = np.mgrid[: SHAPE[0], : SHAPE[1]]
RAYS = np.stack([(U - 31.5) / 40, (V - 23.5) / 40, np.ones(SHAPE)], axis=-1)


def cast(*walls, ball=None):
    """Range and number of the nearest of planes (normal, distance), and of a ball (centre, radius), the last."""
    at = [np.where(RAYS @ normal > 0, away / (RAYS @ normal), np.inf) for normal, away in walls]
    if ball is not None:
        centre, radius = ball
        along, square = RAYS @ centre, (RAYS**2).sum(axis=-1)
        inside = along**2 - square * (centre @ centre - radius**2)
        at.append(np.where(inside > 0, (along - np.sqrt(np.maximum(inside, 0))) / square, np.inf))
    return np.min(at, axis=0) * np.linalg.norm(RAYS, axis=-1), np.argmin(at, axis=0)


def alike(found, truth, least=0.97):
    """Each true face has one number of its own, nearly everywhere."""
    given = []
    for face in np.unique(truth):
        numbers, counts = np.unique(found[truth == face], return_counts=True)
        assert counts.max() > least * counts.sum()
        given.append(numbers[np.argmax(counts)])
    assert len(set(given)) == len(given)
    return given


def corner(turn):
    c, s = np.cos(turn), np.sin(turn)
    return [(np.array([c, 0, s]), 1.5), (np.array([-s, 0, c]), 1.5), (np.array([0, 1.0, 0]), 0.5)]


@pytest.mark.parametrize("turn", [0.4, 0.8, 1.1])
def test_walls_that_meet_are_two(turn):
    ranges, truth = cast(*corner(turn))
    found = segments(ranges[None].astype(np.float32), INTRINSICS)[0]
    alike(found, truth)
    assert found.min() == 1


def test_a_ball_that_moves_keeps_its_number_and_the_wall_it_divides_is_one():
    frames = [
        cast((np.array([0, 0, 1.0]), 2.0), ball=(np.array([x, 0.1, 1.2]), 0.3)) for x in np.linspace(-0.8, 0.8, 25)
    ]
    found = segments(np.stack([f[0] for f in frames]).astype(np.float32), INTRINSICS)
    assert alike(found, np.stack([f[1] for f in frames]), 0.85) == [1, 2]


def test_a_wall_that_leaps_nearer_is_the_same():
    """A depth camera that is slower than the sensor shows it an eighth nearer at once."""
    frames = [cast((np.array([0, 0, 1.0]), away), (np.array([0.8, 0, 0.6]), 1.5)) for away in (2.0, 1.75, 1.53, 1.34)]
    found = segments(np.stack([f[0] for f in frames]).astype(np.float32), INTRINSICS)
    alike(found, np.stack([f[1] for f in frames]))


def test_a_bar_before_a_wall_leaves_it_one_surface():
    bar = np.where(np.abs(U - 30) < 6, 1.0, 2.0) * np.linalg.norm(RAYS, axis=-1)
    found = segments(bar[None], INTRINSICS)[0]
    assert found.max() == 2
    assert alike(found, np.abs(U - 30) < 6, 1 - 1e-9) == [1, 2]


def test_a_camera_that_turns_sees_the_same_walls():
    frames = [cast(*corner(turn)) for turn in np.linspace(0.6, 0.9, 12)]
    alike(segments(np.stack([f[0] for f in frames]), INTRINSICS), np.stack([f[1] for f in frames]))


def test_noise_of_a_depth_camera_leaves_what_stands_before_a_wall_apart():
    ranges, truth = cast((np.array([0, 0, 1.0]), 2.0), ball=(np.array([0.1, 0, 1.2]), 0.3))
    noisy = ranges * (1 + 3e-3 * np.random.default_rng(1).standard_normal(SHAPE))
    alike(segments(noisy[None], INTRINSICS)[0], truth, 0.9)


def test_a_ball_too_small_to_have_a_flat_middle_is_neither_wall_nor_floor():
    """Every pixel of it is next to its rim; it stands well before the wall and on the floor."""
    walls = (np.array([0, 0, 1.0]), 2.0), (np.array([0, 1.0, 0]), 0.6)
    frames = [cast(*walls, ball=(np.array([x, 0.3, 1.0]), 0.08)) for x in np.linspace(-0.3, 0.3, 9)]
    ranges, truth = np.stack([f[0] for f in frames]), np.stack([f[1] for f in frames])
    assert (truth == 2).sum() < 40 * len(frames)
    assert alike(segments(ranges, INTRINSICS), truth, 0.9) == [1, 2, 3]


def test_what_is_too_small_for_a_thing_and_stands_apart_is_none():
    ranges, _ = cast((np.array([0, 0, 1.0]), 2.0))
    ranges[20, 30:32] = 1.2
    found = segments(ranges[None], INTRINSICS)[0]
    assert np.argwhere(found != 1).tolist() == [[20, 30], [20, 31]]
    assert not found[20, 30:32].any()


def test_unknown_depth_is_no_surface():
    ranges, _ = cast((np.array([0, 0, 1.0]), 2.0))
    ranges[10:20, 5:9] = np.nan
    ranges[:, 40:] = 0
    found = segments(ranges[None], INTRINSICS)[0]
    assert ((found == 0) == (~np.isfinite(ranges) | (ranges == 0))).all()
    assert found.max() == 1
    assert not segments(np.full((2, 5, 5), np.nan), INTRINSICS).any()


@given(seed=st.integers(0, 999), height=st.integers(1, 6), width=st.integers(1, 6))
def test_whatever_the_ranges_numbers_go_by_size(seed, height, width):
    ranges = np.random.default_rng(seed).uniform(0.2, 3, (3, height, width))
    sizes = np.bincount(segments(ranges, INTRINSICS).ravel())[1:]
    assert (np.diff(sizes) <= 0).all()
    assert (sizes > 0).all()
