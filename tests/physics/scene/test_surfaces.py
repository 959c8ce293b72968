"""Where rays meet surfaces, against a march along the ray through a function that is 0 on the surface."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from physics.scene.mesh import Mesh
from physics.scene.surfaces import Box, Corner, Plane, Sphere

ROTATION = Rotation.from_euler("xyz", [20, -35, 50], degrees=True).as_matrix()
CENTRE = np.array([0.1, -0.2, 1.5])
SIZE = np.array([0.6, 0.9, 0.5])


def box_distance(point):
    return np.max(np.abs((point - CENTRE) @ ROTATION) - SIZE / 2, axis=-1)


SURFACES = {
    "sphere": (Sphere(CENTRE, 0.4), lambda x: np.linalg.norm(x - CENTRE, axis=-1) - 0.4),
    "box": (Box(CENTRE, SIZE, ROTATION), box_distance),
    "corner": (Corner(CENTRE, ROTATION), lambda x: np.min((x - CENTRE) @ ROTATION, axis=-1)),
    "plane": (Plane(CENTRE, np.array([0.2, 0.3, 2.0])), lambda x: (x - CENTRE) @ np.array([0.2, 0.3, 2.0])),
}


@pytest.mark.parametrize("kind", SURFACES)
@given(seed=st.integers(0, 10_000), inside=st.booleans())
def test_the_first_meeting(kind, seed, inside):
    surface, implicit = SURFACES[kind]
    rng = np.random.default_rng(seed)
    origin = CENTRE + rng.uniform(-0.1, 0.1, 3) if inside else rng.uniform(-0.5, 0.5, 3)
    directions = rng.normal(size=(20, 3))
    length, normal = surface.hit(origin, directions)
    steps = np.linspace(1e-4, 6, 6001)
    along = implicit(origin + steps[:, None, None] * directions)
    # Touching the seam of two faces between steps may be missed by either.
    for ray in range(20):
        crossing = np.flatnonzero(np.diff(np.sign(along[:, ray])))
        if np.isfinite(length[ray]) and length[ray] < 5.9:
            point = origin + length[ray] * directions[ray]
            assert implicit(point) == pytest.approx(0, abs=1e-9)
            assert length[ray] <= steps[crossing[0] + 1] + 1e-9 if len(crossing) else True
            step = 1e-6 * normal[ray]
            assert abs(implicit(point + step)) == pytest.approx(abs(implicit(point - step)), abs=2e-8) or kind in (
                "box",
                "corner",
            )
            assert np.linalg.norm(normal[ray]) == pytest.approx(1)
        else:
            assert len(crossing) == 0 or steps[crossing[0]] > 5.8


def test_a_mesh_of_a_box_is_the_box():
    import open3d

    mesh = open3d.geometry.TriangleMesh.create_box(*SIZE)
    vertices = (np.asarray(mesh.vertices) - SIZE / 2) @ ROTATION.T + CENTRE
    found = Mesh(vertices, np.asarray(mesh.triangles))
    directions = np.random.default_rng(0).normal(size=(500, 3)) * 0.3 + [0, 0, 1]
    length, normal = found.hit(np.zeros(3), directions)
    expected, face = Box(CENTRE, SIZE, ROTATION).hit(np.zeros(3), directions)
    np.testing.assert_allclose(length, expected, rtol=1e-5)
    hit = np.isfinite(length)
    assert 0 < hit.sum() < 500
    np.testing.assert_allclose(np.abs((normal * face).sum(axis=1))[hit], 1, atol=1e-5)
