"""What patches exchange against sums over all pairs at once, and against what is known of it in advance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from physics.exchange import exchange

PATCHES, ZONES, KNOTS = 30, 4, 64


def scene(seed, patches=PATCHES, zones=ZONES):
    """Points two metres ahead and their normals; areas and what they send; the response of zones, a half of it none."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(patches, 3)) - [0, 0, 1]
    response = rng.uniform(0.1, 1, (patches, zones)) * (rng.random((patches, zones)) < 0.5)
    return (
        rng.uniform(-1, 1, (patches, 3)) + np.array([0, 0, 2]), normal / np.linalg.norm(normal, axis=1)[:, None],
        rng.uniform(1e-3, 1e-2, patches), rng.uniform(0, 1, patches), response,
    )  # fmt: skip


def by_pairs(point, normal, area, sent, response, rough, per_metre, first, knots):
    """(P, J) by the formula of `physics.bounce`, all pairs in one array, each pulse split between two knots."""
    between = point[:, None] - point[None]  # From the second to the first.
    distance = np.linalg.norm(between, axis=-1)
    way = np.where(distance[..., None] > 0, between / np.maximum(distance, 1e-12)[..., None], 0)
    leaving, coming = np.einsum("ijk,jk->ij", way, normal), -np.einsum("ijk,ik->ij", way, normal)
    facing = np.full(leaving.shape, 0.25) if rough else np.clip(leaving, 0, None) * np.clip(coming, 0, None)
    given_to = sent * facing / (np.pi * distance**2 + area)
    np.fill_diagonal(given_to, 0)
    far = np.linalg.norm(point, axis=1)
    at = (far[:, None] + distance + far[None]) * per_metre + first
    given_to[(at < 0) | (at >= knots - 1)] = 0
    out = np.zeros((knots, response.shape[1]))
    knot = np.clip(np.floor(at).astype(int), 0, knots - 2)
    for later, part in ((0, 1 - (at - knot)), (1, at - knot)):
        np.add.at(out, knot + later, (given_to * part)[..., None] * response[:, None])
    return out.T


def exchanged(arrays, rough, per_metre=8.0, first=2.0, knots=KNOTS):
    out = np.zeros((arrays[-1].shape[1], knots))
    exchange(*arrays, rough, per_metre, first, out)
    return out


@given(st.integers(0, 10**6), st.booleans(), st.floats(0.5, 20), st.floats(-20, 20))
@settings(deadline=None, max_examples=30)
def test_all_pairs(seed, rough, per_metre, first):
    """Also where light comes before the first knot, or after the last."""
    arrays = scene(seed)
    found = exchanged(arrays, rough, per_metre, first)
    np.testing.assert_allclose(found, by_pairs(*arrays, rough, per_metre, first, KNOTS), rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize("rough", [False, True])
def test_it_is_added_and_patches_in_one_place_blind_nothing(rough):
    arrays = scene(1)
    arrays[0][1] = arrays[0][0]
    out = np.ones((ZONES, KNOTS))
    exchange(*arrays, rough, 8.0, 2.0, out)
    assert np.isfinite(out).all()
    np.testing.assert_allclose(out - 1, exchanged(arrays, rough), atol=1e-12)


def test_two_patches_face_each_other_at_a_known_distance():
    """One metre apart, of which each gets the other's light a metre later, as much as a disc would send."""
    point = np.array([[-0.5, 0, 0], [0.5, 0, 0]])
    normal = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    area, sent, response = np.array([0.1, 0.2]), np.array([0.3, 0.0]), np.eye(2)
    found = exchanged((point, normal, area, sent, response), False, per_metre=10.0, first=0.0)
    # Half a metre there, one across, half a metre back: ten knots each.
    assert found[1, 20] == pytest.approx(0.3 / (np.pi + 0.1))
    assert found.sum() == pytest.approx(found[1, 20])
    turned = exchanged((point, -normal, area, sent, response), False, per_metre=10.0, first=0.0)
    assert not turned.any()
    either = exchanged((point, -normal, area, sent, response), True, per_metre=10.0, first=0.0)
    assert either[1, 20] == pytest.approx(0.25 * 0.3 / (np.pi + 0.1))


def test_none_and_one_exchange_nothing():
    for patches in (0, 1):
        assert not exchanged(scene(2, patches), True).any()
