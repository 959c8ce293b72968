"""Surfaces in closed form: where a ray from one point first meets them, and which way they face there."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

# A surface nearer than this is the sensor's own.
NEAREST = 1e-6


class Surface(Protocol):
    """Something light falls on."""

    def hit(self, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Along rays from origin (3,) in directions (N, 3): lengths (N,) in units of them, inf where it is missed,

        and unit normals (N, 3), of either sign.
        """


@dataclass(frozen=True, eq=False)
class Plane:
    """Through `point`, at right angles to `normal`."""

    point: np.ndarray
    normal: np.ndarray

    def hit(self, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `Surface`."""
        unit = self.normal / np.linalg.norm(self.normal)
        with np.errstate(divide="ignore", invalid="ignore"):
            length = ((self.point - origin) @ unit) / (directions @ unit)
        return _ahead(length), np.broadcast_to(unit, directions.shape)


@dataclass(frozen=True, eq=False)
class Sphere:
    """Round `centre`; seen from inside, too."""

    centre: np.ndarray
    radius: float

    def hit(self, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `Surface`."""
        to_centre = self.centre - origin
        square, along = (directions**2).sum(axis=-1), directions @ to_centre
        root = np.sqrt(
            np.where(_room(self, square, along, to_centre) >= 0, _room(self, square, along, to_centre), np.nan)
        )
        near, far = (along - root) / square, (along + root) / square
        length = _ahead(np.where(near > NEAREST, near, far))
        finite = np.where(np.isfinite(length), length, 0)
        return length, (finite[:, None] * directions - to_centre) / self.radius


def _room(sphere: Sphere, square: np.ndarray, along: np.ndarray, to_centre: np.ndarray) -> np.ndarray:
    """Discriminant of the ray's quadratic."""
    return along**2 - square * (to_centre @ to_centre - sphere.radius**2)


@dataclass(frozen=True, eq=False)
class Box:
    """Sides of `size` round `centre`, turned by `rotation` (3, 3), world from box; seen from inside it is a room."""

    centre: np.ndarray
    size: np.ndarray
    rotation: np.ndarray

    def hit(self, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `Surface`; by slabs (Kay and Kajiya 1986)."""
        start, along = (origin - self.centre) @ self.rotation, directions @ self.rotation
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = (np.array([-0.5, 0.5])[:, None, None] * self.size - start) / along
        ends = np.where(np.isnan(ends), np.inf, ends)
        enter, leave = ends.min(axis=0), ends.max(axis=0)
        near, far = enter.max(axis=1), leave.min(axis=1)
        outside = near > NEAREST
        side = np.where(outside, enter.argmax(axis=1), leave.argmin(axis=1))
        length = np.where(near <= far, np.where(outside, near, far), np.inf)
        return _ahead(length), self.rotation.T[side]


@dataclass(frozen=True, eq=False)
class Corner:
    """Three walls that meet at `apex` at right angles and end there; `rotation` (3, 3) holds their edges as columns."""

    apex: np.ndarray
    rotation: np.ndarray

    def hit(self, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `Surface`."""
        start, along = (origin - self.apex) @ self.rotation, directions @ self.rotation
        lengths = np.full((len(directions), 3), np.inf)
        for axis in range(3):
            with np.errstate(divide="ignore", invalid="ignore"):
                length = _ahead(-start[axis] / along[:, axis])
                point = start + np.where(np.isfinite(length), length, 0)[:, None] * along
            others = [a for a in range(3) if a != axis]
            lengths[:, axis] = np.where((point[:, others] >= 0).all(axis=1), length, np.inf)
        side = lengths.argmin(axis=1)
        return lengths[np.arange(len(side)), side], self.rotation.T[side]


def _ahead(length: np.ndarray) -> np.ndarray:
    """Lengths that are finite and before the origin; inf otherwise."""
    return np.where(np.isfinite(length) & (length > NEAREST), length, np.inf)
