"""The plane sweep against images whose depth is known, and its likelihood against a line fitted window by window."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, map_coordinates

from fusion.sweep import INDEPENDENT, NOISE, WINDOW, plane_sweep

K = np.array([[60.0, 0, 39.5], [0, 60, 29.5], [0, 0, 1]])
DEPTHS = np.geomspace(0.8, 4, 17)
RNG = np.random.default_rng(0)
PAINT = gaussian_filter(RNG.uniform(0, 255, (400, 400)), 2) * 4 - 380


def step(x=0.0, y=0.0, z=0.0, turn=0.0):
    made = np.eye(4)
    made[:3, 3] = x, y, z
    made[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    return made


def wall(depth, way):
    """(60, 80) image of a painted wall across the axis of the camera that sees it from `depth`, seen after `way`."""
    v, u = np.mgrid[:60, :80].astype(float)
    rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(u)], axis=-1)
    back = np.linalg.inv(way)
    directions, start = rays @ back[:3, :3].T, back[:3, 3]
    points = start + directions * ((depth - start[2]) / directions[..., 2])[..., None]
    return map_coordinates(PAINT, [200 + 60 * points[..., 1], 200 + 60 * points[..., 0]], order=1, mode="wrap")


@pytest.mark.parametrize("way", [step(x=0.1), step(y=-0.12), step(x=0.08, z=0.1), step(x=0.1, turn=0.1)])
@pytest.mark.parametrize("k", [3, 8, 13])
def test_the_depth_of_a_wall_is_likeliest(way, k):
    found = plane_sweep(wall(DEPTHS[k], np.eye(4)), wall(DEPTHS[k], way), (K, K), way, DEPTHS)
    shown = np.isfinite(found).all(axis=0)
    assert shown.mean() > 0.5
    near = np.abs(found[:, shown].argmax(axis=0) - k) <= 1
    assert near.mean() > 0.9


def test_likelihood_is_what_a_line_leaves():
    now, before = wall(1.5, np.eye(4)), 0.7 * wall(1.5, step(x=0.1)) + 12
    found = plane_sweep(now, before, (K, K), step(x=0.1), np.array([1.0, 2.0, 3.0]))
    half, (v, u) = WINDOW // 2, (30, 45)
    # At 2 m a step of 0.1 m moves pixels by 3.
    a = now[v - half : v + half + 1, u - half : u + half + 1].ravel()
    b = before[v - half : v + half + 1, u + 3 - half : u + 3 + half + 1].ravel()
    fit = np.polynomial.Polynomial.fit(b, a, 1)
    left = np.mean((a - fit(b)) ** 2) if np.cov(a, b)[0, 1] > 0 else a.var()
    assert found[1, v, u] == pytest.approx(-INDEPENDENT * left / (2 * NOISE**2), rel=0.02)


def test_what_the_earlier_image_does_not_show_says_nothing():
    way = step(x=0.3)
    found = plane_sweep(wall(1.0, np.eye(4)), wall(1.0, way), (K, K), way, np.array([1.0, 2.0]))
    # 18 pixels at 1 m, and half a window.
    assert np.isnan(found[:, :, -18:]).all()
    assert np.isfinite(found[:, 5:-5, : -18 - WINDOW]).all()


def test_a_blank_wall_says_the_same_of_all_depths():
    blank = np.full((60, 80), 90.0)
    found = plane_sweep(blank, blank, (K, K), step(x=0.1), DEPTHS)
    assert np.nanmax(np.abs(found)) < 1e-3


def test_a_part_of_the_image_has_the_likelihood_of_the_whole():
    now, before, way = wall(1.5, np.eye(4)), wall(1.5, step(x=0.1)), step(x=0.1)
    whole = plane_sweep(now, before, (K, K), way, DEPTHS)
    part = plane_sweep(now[10:50, 20:70], before, (np.array([[1, 0, -20], [0, 1, -10], [0, 0, 1]]) @ K, K), way, DEPTHS)
    np.testing.assert_allclose(part[:, 3:-3, 3:-3], whole[:, 13:47, 23:67], rtol=1e-3, atol=0.05)
