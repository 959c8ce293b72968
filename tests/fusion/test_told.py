"""Two walls that zones mix, told apart by a camera that moves."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from fusion.motion import Motion, finer, grey
from fusion.prior import Prior
from fusion.shares import shares
from fusion.sight import Sight
from fusion.told import told
from fusion.unmix import unmix

from .light_tables import RANGE_M, zone_view

SHAPE = (96, 128)
K = np.array([[400.0, 0, 63.5], [0, 400, 47.5], [0, 0, 1]])
NEAR, FAR = 1.2, 2.4
# Grey all over, lighter and darker by chance: no colour tells where the near wall ends.
PAINT = np.clip(gaussian_filter(np.random.default_rng(0).normal(size=(96, 256)), 3) * 400 + 128, 0, 255)


def seen_from(x):
    """(image, depth) of a far wall and of a near one that hides its left half, from x metres to the right."""
    u = np.arange(SHAPE[1]) - 63.5
    # Where a pixel looks on each wall, in pixels of the picture taken from the middle.
    on_near, on_far = (u + 400 * x / z for z in (NEAR, FAR))
    hides = on_near < 0
    columns = np.where(hides, on_near, on_far)
    image = np.stack([np.interp(columns + 127.5, np.arange(256), row) for row in PAINT])
    return image.repeat(3).reshape(*SHAPE, 3).astype(np.uint8), np.broadcast_to(np.where(hides, NEAR, FAR), SHAPE)


def nine_zones():
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    bells = [np.exp(-(((u - x) / 22) ** 2) - ((v - y) / 17) ** 2) for y in (16, 48, 80) for x in (22, 64, 106)]
    return Sight(np.stack(bells).astype(np.float32), K, (3, 3), np.zeros(3), np.inf)


def view_of(where, depth):
    length = where.ray_length.ravel()
    entry = np.abs(RANGE_M[:, None] - depth.ravel() * length).argmin(axis=0)
    strength = 1 / (depth.ravel() * length) ** 2
    return zone_view(np.array([np.bincount(entry, w.ravel() * strength, RANGE_M.size) for w in where.weights]) * 50)


def earlier_by(where, x):
    step = np.eye(4)
    step[0, 3] = x
    return Motion(grey(seen_from(-x)[0], finer(where.coarse.shape)), step)


@pytest.fixture(scope="module")
def scene():
    where = nine_zones()
    rgb, depth = seen_from(0.0)
    return where, rgb, depth, view_of(where, depth)


def test_motion_tells_where_in_one_zone_two_walls_are(scene):
    _, rgb, depth, _ = scene
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    bell = np.exp(-(((u - 63.5) / 40) ** 2) - ((v - 47.5) / 40) ** 2)[None].astype(np.float32)
    where = Sight(bell, K, (1, 1), np.zeros(3), np.inf)
    view = view_of(where, depth)
    alone, _, confidence = unmix(where, view, rgb)
    moving = unmix(where, view, rgb, motion=earlier_by(where, 0.04))[0]
    errors = [np.abs(found - depth)[confidence > 0.3].mean() for found in (alone, moving)]
    assert errors[1] < 0.4 * errors[0]


def test_ranges_that_are_told_are_right(scene):
    where, rgb, depth, view = scene
    grid = where.coarse
    value, precision = told(grid, shares(view, Prior().certain), rgb, earlier_by(where, 0.06))
    rows, columns = ((np.arange(n) * m / n).astype(int) for n, m in zip(grid.shape, SHAPE, strict=True))
    truth = np.log(depth[np.ix_(rows, columns)] * grid.ray_length)
    sure = precision > 0.5 * precision.max()
    assert sure.mean() > 0.2
    assert np.median(np.abs(value - truth)[sure]) < 0.03
    assert ((precision > 0) | (value == 0)).all()


def test_a_wrong_pose_does_no_harm(scene):
    where, rgb, _, view = scene
    right = earlier_by(where, 0.06)
    alone = unmix(where, view, rgb)[0]
    for wrong in (0.02, 0.18):
        step = right.step.copy()
        step[0, 3] = wrong
        found, _, confidence = unmix(where, view, rgb, motion=Motion(right.grey, step))
        seen = confidence > 0.3
        depth = scene[2]
        rms = [np.sqrt(np.mean((one - depth)[seen] ** 2)) for one in (found, alone)]
        assert rms[0] < 1.1 * rms[1]


def test_without_an_image_or_with_a_blank_one_it_is_as_if_alone(scene):
    where, _, _, view = scene
    motion = earlier_by(where, 0.06)
    alone = unmix(where, view, None)[0]
    np.testing.assert_array_equal(unmix(where, view, None, motion=motion)[0], alone)


def test_zones_of_one_surface_are_no_trouble(scene):
    where, rgb, _, _ = scene
    view = view_of(where, np.full(SHAPE, 1.5))
    found, _, confidence = unmix(where, view, rgb, motion=earlier_by(where, 0.06))
    np.testing.assert_allclose(found[confidence > 0.3], 1.5, rtol=0.05)
