"""Incidence told from depth, within surfaces and across edges."""

import numpy as np
import pytest

from physics.geometry import incidence_cosine, incidence_cosine_across_edges, pixel_rays
from recordings.files import load

K = np.array([[40.0, 0, 15.5], [0, 40.0, 11.5], [0, 0, 1]])
SHAPE = (24, 32)


def plane(normal, away):
    """(1, H, W) depth of a plane, and (H, W) cosine between its normal and rays."""
    rays, normal = pixel_rays(K, SHAPE), np.array(normal) / np.linalg.norm(normal)
    depth = away / (rays @ normal)
    return depth[None], rays @ normal / np.linalg.norm(rays, axis=-1)


@pytest.mark.parametrize("told", [incidence_cosine, incidence_cosine_across_edges])
def test_on_a_plane_both_are_the_cosine_to_its_normal(told):
    depth, cosine = plane([0.4, -0.2, 1.0], 1.3)
    np.testing.assert_allclose(told(depth, K)[0][1:-1, 1:-1], cosine[1:-1, 1:-1], atol=2e-3)


def test_at_an_edge_one_keeps_to_surfaces_and_the_other_takes_it_for_one():
    near, far = (plane([0, 0, 1.0], away) for away in (0.5, 2.0))
    depth = np.where(np.arange(SHAPE[1]) < 16, near[0], far[0])
    within, across = incidence_cosine(depth, K)[0], incidence_cosine_across_edges(depth, K)[0]
    np.testing.assert_allclose(within[2:-2, 14:18], near[1][2:-2, 14:18], atol=1e-3)
    assert (across[2:-2, 15:17] < 0.1).all()
    assert across.min() >= 0.05
    np.testing.assert_allclose(across[2:-2, 2:14], near[1][2:-2, 2:14], atol=1e-3)


def test_beside_what_is_unknown_it_is_that_within_surfaces():
    depth, _ = plane([0.1, 0.2, 1.0], 1.0)
    depth[0, 10, 12] = np.nan
    within, across = incidence_cosine(depth, K)[0], incidence_cosine_across_edges(depth, K)[0]
    for v, u in ((9, 12), (11, 12), (10, 11), (10, 13)):
        assert across[v, u] == within[v, u] > 0
    assert np.isnan(across[10, 12])


def test_the_published_recording_tells_it_across_edges(shared_data):
    seen = load(shared_data / "conformance" / "recording.npz")
    depth = np.asarray(seen.depth_m, np.float32)
    told = incidence_cosine_across_edges(depth if depth.ndim == 3 else depth[None], seen.intrinsics)
    np.testing.assert_allclose(told, np.asarray(seen.incidence_cosine).reshape(told.shape), atol=1e-5)
