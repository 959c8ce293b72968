"""The edges of solids as a drawing shows them: what is seen as lines, what is hidden as dashes."""

from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold

from devices.parts.solids import mesh

SHARP_DEG = 25.0  # edges at which the surface turns by less belong to a curved surface
PIECE_MM = 0.8  # edges are seen or hidden in pieces of this length
OFF_MM = 0.03  # how far off the surface the line of sight begins


@dataclass(frozen=True, eq=False)
class Looking:
    """A direction to look from: right, up and towards the viewer, each (3,) in the frame of the solid."""

    right: tuple[float, float, float]
    up: tuple[float, float, float]

    @property
    def axes(self) -> np.ndarray:
        """(3, 3) rows: right, up, towards the viewer."""
        return np.array([self.right, self.up, np.cross(self.right, self.up)], float)

    def flat(self, points: np.ndarray) -> np.ndarray:
        """(..., 2) on the page, of points (..., 3)."""
        return np.asarray(points, float) @ self.axes[:2].T

    def outline(self, solid: Manifold) -> list[np.ndarray]:
        """Outlines, each (N, 2), of what a solid covers on the page."""
        turned = solid.transform(np.column_stack([self.axes, np.zeros(3)]))
        return [np.asarray(p) for p in turned.project().to_polygons()]


def edges(solid: Manifold, looking: Looking, among: list[Manifold]) -> tuple[np.ndarray, np.ndarray]:
    """(N, 2, 2) pieces of the edges of `solid` that are seen, and (M, 2, 2) that are hidden, on the page.

    among: all solids in the picture that can hide them, `solid` itself as well.
    """
    import open3d

    ends, off = _edges(solid, looking)
    if not len(ends):
        return np.empty((0, 2, 2)), np.empty((0, 2, 2))
    pieces, off = _divided(ends, off)
    scene = open3d.t.geometry.RaycastingScene()
    for other in among:
        surface = mesh(other)
        scene.add_triangles(surface.vertices.astype(np.float32), surface.faces.astype(np.uint32))
    towards = looking.axes[2]
    start = pieces.mean(axis=1) + OFF_MM * (off + towards)
    rays = np.hstack([start, np.broadcast_to(towards, start.shape)]).astype(np.float32)
    hidden = scene.test_occlusions(open3d.core.Tensor(rays)).numpy()
    page = looking.flat(pieces)
    long = np.linalg.norm(page[:, 1] - page[:, 0], axis=1) > 1e-6
    return page[long & ~hidden], page[long & hidden]


def _edges(solid: Manifold, looking: Looking) -> tuple[np.ndarray, np.ndarray]:
    """(E, 2, 3) ends of edges worth drawing, and (E, 3) directions off the surface there."""
    surface = mesh(solid)
    normals = surface.face_normals[surface.face_adjacency]
    facing = normals @ looking.axes[2]
    turn = np.degrees(surface.face_adjacency_angles)
    # Where a curved surface turns away from the viewer it has an outline without having an edge.
    turns_away = (facing[:, 0] > 1e-6) != (facing[:, 1] > 1e-6)
    chosen = (turn > SHARP_DEG) | (turns_away & (turn > 0.1))
    return surface.vertices[surface.face_adjacency_edges[chosen]], normals[chosen].mean(axis=1)


def _divided(ends: np.ndarray, off: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges cut into pieces short enough to be seen or hidden as a whole."""
    count = np.maximum(1, np.ceil(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / PIECE_MM)).astype(int)
    which = np.repeat(np.arange(len(ends)), count)
    number = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    along = (ends[:, 1] - ends[:, 0])[which] / count[which, None]
    first = ends[which, 0] + along * number[:, None]
    return np.stack([first, first + along], axis=1), off[which]
