import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from calibrate.space import ScanGeometry, at_depth, rays
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

INTRINSICS = np.array([[612.0, 0, 424], [0, 610, 238], [0, 0, 1]])


def transform(seed):
    rng = np.random.default_rng(seed)
    found = np.eye(4)
    found[:3, :3] = Rotation.from_rotvec(0.1 * rng.standard_normal(3)).as_matrix()
    found[:3, 3] = 0.03 * rng.standard_normal(3)
    return found


def maps_in_space(seed=0, depth=0.6, **meta):
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0, 848, 50), rng.uniform(0, 480, 50)
    geometry = ScanGeometry(INTRINSICS, transform(seed), depth)
    meta = geometry.to_meta() | meta
    responses = rng.random((2, 2, 50)) * 1e5
    return ResponseMaps(responses, x, y, np.array([f"{i:04d}" for i in range(50)]), json.dumps(meta), responses**0.5)


@given(st.integers(0, 2**32 - 1), st.floats(0.2, 5))
def test_pixels_undo_points(seed, depth):
    rng = np.random.default_rng(seed)
    geometry = ScanGeometry(INTRINSICS, transform(seed), depth)
    x, y = rng.uniform(0, 848, 9), rng.uniform(0, 480, 9)
    np.testing.assert_allclose(geometry.pixels(geometry.points(x, y)), np.stack([x, y], axis=1), atol=1e-6)


def test_point_by_hand():
    shift = np.eye(4)
    shift[0, 3] = -0.02  # the LiDAR sits 20 mm to the right of the camera
    points = ScanGeometry(INTRINSICS, shift, 0.5).points(np.array([424.0, 424 + 61.2]), np.array([238.0, 238.0]))
    np.testing.assert_allclose(points, [[-0.02, 0, 0.5], [0.03, 0, 0.5]], atol=1e-12)


@given(st.integers(0, 1000), st.floats(0.25, 4))
def test_there_and_back_again(seed, depth):
    maps = maps_in_space(seed)
    back = at_depth(at_depth(maps, depth), 0.6)
    np.testing.assert_allclose(back.xs, maps.xs, atol=1e-6)
    np.testing.assert_allclose(back.responses, maps.responses, rtol=1e-9)
    np.testing.assert_allclose(back.sigma, maps.sigma, rtol=1e-9)


def test_parallax_is_that_of_a_stereo_pair():
    """Displacement f · b · (1/Z₂ − 1/Z₁), and responses falling with the fourth power of the range."""
    shift = np.eye(4)
    shift[0, 3] = -0.02
    meta = ScanGeometry(INTRINSICS, shift, 0.5).to_meta() | {"patch_radius_px": 18.0}
    maps = ResponseMaps(np.full((1, 1, 1), 800.0), [424 + 612 * 0.02 / 0.5], [238.0], np.array(["1"]), json.dumps(meta))
    far = at_depth(maps, 1.0)
    assert far.xs[0] - maps.xs[0] == pytest.approx(612 * 0.02 * (1 / 1.0 - 1 / 0.5))
    assert far.responses[0, 0, 0] == pytest.approx(800 / 16)
    assert far.meta["patch_radius_px"] == 18.0
    assert far.meta["calibration_range_m"] == 1.0


def test_rays_point_at_the_patch_and_keep_no_range():
    near, far = maps_in_space(3), at_depth(maps_in_space(3), 2.0)
    np.testing.assert_allclose(rays(near).directions, rays(far).directions, atol=1e-9)
    np.testing.assert_allclose(rays(near).weights, rays(far).weights, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(rays(near).directions, axis=1), 1)


def test_image_plane_maps_say_so():
    maps = ResponseMaps(np.ones((1, 1, 3)), np.arange(3.0), np.zeros(3), np.array(list("abc")))
    with pytest.raises(Refusal, match="image-plane maps"):
        at_depth(maps, 1.0)


@pytest.mark.parametrize("depth", [0.0, -1.0, np.nan, np.inf])
def test_impossible_distances_are_refused(depth):
    with pytest.raises(Refusal, match="distance"):
        at_depth(maps_in_space(), depth)
