"""Solids: boxes, cylinders and pyramids of views, in millimetres, and parts that are printed from them."""

from dataclasses import dataclass
from functools import reduce
from pathlib import Path

import numpy as np
import trimesh
from manifold3d import Manifold

from recordings.atomic import written_aside

# Chords of a circle: 96 leave a hole of 6.6 mm out of round by 2 micrometres.
SEGMENTS = 96


@dataclass(frozen=True, eq=False)
class Part:
    """A solid to print, flat on its lowest face.

    name: of its file. solid: millimetres, in whatever frame it was drawn; z is up when it is printed.
    note: what to know of it.
    """

    name: str
    solid: Manifold
    note: str = ""

    @property
    def size(self) -> np.ndarray:
        """(3,) extents, millimetres."""
        low, high = bounds(self.solid)
        return high - low

    def save(self, folder: Path) -> Path:
        """Write NAME.stl, binary, millimetres, middle of the base at the origin and flat on z = 0."""
        low, high = bounds(self.solid)
        path = folder / f"{self.name}.stl"
        at_origin = self.solid.translate([-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, -low[2]])
        with written_aside(path) as aside:
            aside.write_bytes(trimesh.exchange.stl.export_stl(mesh(at_origin)))
        return path


def box(low: np.ndarray | tuple, high: np.ndarray | tuple) -> Manifold:
    """A box between two corners."""
    low, high = np.minimum(low, high).astype(float), np.maximum(low, high).astype(float)
    return Manifold.cube(high - low).translate(low)


def cylinder(at: np.ndarray | tuple, length: float, diameter: float, top: float | None = None) -> Manifold:
    """A cylinder that stands at a point along +z, or a cone with another diameter on top."""
    radii = diameter / 2, (diameter if top is None else top) / 2
    return Manifold.cylinder(length, *radii, SEGMENTS).translate(np.asarray(at, float))


def lying(at: np.ndarray | tuple, length: float, diameter: float, segments: int = SEGMENTS) -> Manifold:
    """A cylinder, or a prism of few segments, that begins at a point and lies along +y."""
    return Manifold.cylinder(length, diameter / 2, diameter / 2, segments).rotate([-90, 0, 0]).translate(list(at))


def posed(solid: Manifold, rotation: np.ndarray, position: np.ndarray) -> Manifold:
    """The solid, rotated by (3, 3) and then moved by (3,)."""
    return solid.transform(np.column_stack([rotation, position]))


def view(angles_deg: tuple[float, float], window: tuple[float, float] = (0, 0), reach: float = 400) -> Manifold:
    """What is seen along +z from a window about the origin, as a pyramid.

    angles_deg: full angles along x and y; window: width and height of the window the pyramid begins at.
    """
    half = np.array(window) / 2
    far = half + reach * np.tan(np.radians(angles_deg) / 2)
    signs = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
    # The start is a hair wide, since a point makes no face.
    near = signs * np.maximum(half, 1e-3)
    return Manifold.hull_points(np.vstack([np.c_[near, np.zeros(4)], np.c_[signs * far, np.full(4, reach)]]))


def joined(solids: list[Manifold]) -> Manifold:
    """One solid out of several."""
    return reduce(lambda a, b: a + b, solids)


def bounds(solid: Manifold) -> tuple[np.ndarray, np.ndarray]:
    """(3,) lowest and (3,) highest corner."""
    corners = np.array(solid.bounding_box())
    return corners[:3], corners[3:]


def mesh(solid: Manifold) -> trimesh.Trimesh:
    """The surface as triangles."""
    triangles = solid.to_mesh()
    return trimesh.Trimesh(triangles.vert_properties[:, :3], triangles.tri_verts, process=True)
