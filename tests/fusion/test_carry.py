"""What an earlier frame says of this view."""

import numpy as np

from fusion.carry import carried
from fusion.sight import Sight

K = np.array([[300.0, 0, 319.5], [0, 300, 239.5], [0, 0, 1]])
SHAPE = (480, 640)
WHERE = Sight(np.ones((1, *SHAPE), np.float32), K, (1, 1), np.zeros(3), np.inf)


def moved(x=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, 0, z
    return pose


def test_a_camera_that_did_not_move_sees_the_same():
    depth = np.random.default_rng(0).uniform(1, 3, (60, 80)).repeat(8, 0).repeat(8, 1)
    np.testing.assert_allclose(carried(WHERE, depth, moved(1), moved(1)), depth[::8, ::8], rtol=1e-6)


def test_walking_towards_a_wall():
    found = carried(WHERE, np.full(SHAPE, 2.0), moved(), moved(z=0.5))
    np.testing.assert_allclose(found[np.isfinite(found)], 1.5, rtol=1e-6)
    assert np.isfinite(found[28:32, 38:42]).all()


def test_a_step_aside_shifts_by_disparity_and_leaves_a_border_unknown():
    # 300 px · x / 2 m = 16 px, two coarse pixels.
    found = carried(WHERE, np.full(SHAPE, 2.0), moved(), moved(x=16 * 2 / 300))
    assert np.isnan(found[:, -2:]).all()
    np.testing.assert_allclose(found[:, :-2], 2.0, rtol=1e-6)


def test_the_nearer_of_two_points_is_seen_and_the_unknown_stays_behind():
    depth = np.full(SHAPE, 4.0)
    depth[:, 320:] = 1.0
    depth[:8] = np.nan
    found = carried(WHERE, depth, moved(), moved(x=0.06))
    assert np.isnan(found[0]).all()
    # 18 px for the near half, 4.5 for the far one: the near half covers columns from 302 px on.
    assert (found[1:, 39:77] == 1).all()


def test_what_is_behind_is_not_seen():
    assert np.isnan(carried(WHERE, np.full(SHAPE, 2.0), moved(), moved(z=3))).all()
