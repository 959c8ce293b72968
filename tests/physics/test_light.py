"""Direct light of planes and spheres, whose range and incidence are known in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.geometry import full_size_pixels, incidence_cosine, pixel_rays
from physics.light import direct_light
from recordings.refusal import Refusal

INTRINSICS = np.array([[60.0, 0, 31.5], [0, 60.0, 23.5], [0, 0, 1]])
SHAPE = (48, 64)


def plane_depth(normal, distance):
    """Depth of the plane n·X = d along every pixel's ray."""
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    rays = np.stack([(u - 31.5) / 60, (v - 23.5) / 60, np.ones(SHAPE)], axis=-1)
    return distance / (rays @ normal), rays


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(0.2, 5))
def test_a_plane(tilt_x, tilt_y, distance):
    normal = np.array([tilt_x, tilt_y, 1.0])
    normal /= np.linalg.norm(normal)
    depth, rays = plane_depth(normal, distance)
    cosine = np.abs(rays @ normal) / np.linalg.norm(rays, axis=-1)
    found = incidence_cosine(depth[None], INTRINSICS)[0]
    # Finite differences chord the ray's sweep: a part in the square of a pixel's angle, and float32.
    np.testing.assert_allclose(found, cosine, atol=0.02)
    light = direct_light(depth[None], INTRINSICS, np.full(SHAPE, 0.5), cosine)
    r = np.linalg.norm(depth[..., None] * rays, axis=-1)
    np.testing.assert_allclose(light.returns[0].range_m[0], r, rtol=1e-5)
    np.testing.assert_allclose(light.returns[0].strength[0], 0.5 * cosine / r**2, rtol=1e-4)
    assert light.missing.tolist() == [0]


def test_a_sphere_is_as_bright_at_every_incidence_as_lambert_says():
    _, rays = plane_depth(np.array([0, 0, 1.0]), 1)
    unit = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    b = unit[..., 2] * 1.5
    inside = b**2 - 1.5**2 + 0.4**2
    t = np.where(inside > 0.01, b - np.sqrt(np.maximum(inside, 0)), np.nan)
    depth = (t[..., None] * unit)[..., 2]
    point = t[..., None] * unit
    cosine = -np.sum(unit * (point - [0, 0, 1.5]) / 0.4, axis=-1)
    found = incidence_cosine(depth[None], INTRINSICS)[0]
    good = np.isfinite(found) & (cosine > 0.5)
    assert good.sum() > 400
    assert np.median(np.abs(found - cosine)[good]) < 0.01
    assert np.isnan(found[np.isnan(depth)]).all()


def test_slopes_do_not_cross_an_edge():
    depth = np.full((1, *SHAPE), 1.0, np.float32)
    depth[:, :, 32:] = 2.0
    _, rays = plane_depth(np.array([0, 0, 1.0]), 1)
    np.testing.assert_allclose(incidence_cosine(depth, INTRINSICS)[0], 1 / np.linalg.norm(rays, axis=-1), atol=1e-5)


def test_pixels_without_depth_contribute_nothing_and_are_counted():
    depth = np.ones((2, *SHAPE), np.float32)
    depth[1, 3, 4] = np.nan
    depth[1, 5, 6] = 0
    reflectance = np.ones_like(depth)
    reflectance[1, 7, 8] = np.nan
    cosine = np.ones_like(depth)
    cosine[0, 0, 0] = -0.2  # Faces away: nothing returns, and nothing is missing.
    light = direct_light(depth, INTRINSICS, reflectance, cosine)
    assert light.missing.tolist() == [0, 3]
    strength = light.returns[0].strength
    assert (strength[1, [3, 5, 7], [4, 6, 8]] == 0).all()
    assert strength[0, 0, 0] == 0
    assert np.isfinite(strength).all()


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("depth", -1.0, r"depth_m\[1, 2, 3\] is -1.0, expected finite metres of 0 or more"),
        ("depth", np.inf, r"depth_m\[1, 2, 3\] is inf"),
        ("reflectance", 1.5, r"reflectance\[1, 2, 3\] is 1.5, expected 0 to 1"),
        ("reflectance", -0.1, r"reflectance\[1, 2, 3\] is -0.1"),
        ("cosine", 1.1, r"incidence_cosine\[1, 2, 3\] is 1.1"),
    ],
)
def test_values_that_cannot_be_are_refused_by_name_and_place(name, value, sentence):
    arrays = {key: np.ones((2, *SHAPE), np.float32) for key in ("depth", "reflectance", "cosine")}
    arrays[name][1, 2, 3] = value
    with pytest.raises(Refusal, match=sentence):
        direct_light(arrays["depth"], INTRINSICS, arrays["reflectance"], arrays["cosine"])


def test_shapes_that_do_not_match_are_refused():
    with pytest.raises(Refusal, match=r"reflectance has shape \(2, 2\)"):
        direct_light(np.ones((1, 4, 5)), INTRINSICS, np.ones((2, 2)))
    with pytest.raises(Refusal, match="expected \\(F, H, W\\)"):
        direct_light(np.ones((4, 5)), INTRINSICS)


def test_pixels_of_a_grid_in_the_full_size_image():
    x, y = full_size_pixels((2, 4), (8, 6))
    assert x[0].tolist() == [0.5, 2.5, 4.5, 6.5]
    assert y[:, 0].tolist() == [1.0, 4.0]


def test_rays_go_through_their_pixels():
    skewed = INTRINSICS.copy()
    skewed[0, 1] = 1.5
    pixel = pixel_rays(skewed, SHAPE)[5, 7] @ skewed.T
    assert pixel == pytest.approx([7, 5, 1])
