"""A mark on a surface, ink, tape or a label: where it is in space, as the excess of counts tells."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from physics.effect import Parameter, Values
from physics.light import Light
from physics.rendering import Rendering
from physics.shares_amiss import evidence_of_shares
from physics.texture import places

# Width of a mark's rim, as a part of its size.
RIM = 0.1
# About so many pixels of an image are looked at, at most so many places and these sizes, as parts of the median range.
PIXELS, PLACES, SIZES = 1500, 60, (0.08, 0.2)


def place_parameters(name: str) -> tuple[Parameter, ...]:
    """What says where a ball in space of this name is, and how large."""
    return (
        Parameter(
            f"{name}_x", "m", -20.0, 20.0, 0.0, "How far to the right it is, of the camera when the session began."
        ),
        Parameter(f"{name}_y", "m", -20.0, 20.0, 0.0, "How far below."),
        Parameter(f"{name}_z", "m", -20.0, 20.0, 1.0, "How far ahead."),
        Parameter(f"{name}_size", "m", 0.005, 5.0, 0.1, "Its radius."),
    )


def in_ball(values: Values, name: str, light: Light) -> np.ndarray:
    """(F, H, W) how far pixels are in the ball of this name, 0 to 1; see `within`."""
    return within(light, *(values[f"{name}_{what}"] for what in ("x", "y", "z", "size")))


def within(light: Light, x: float, y: float, z: float, size: float) -> np.ndarray:
    """(F, H, W) 1 in a ball of radius `size` about a place in space, 0 outside, 1/2 on its rim.

    x, y, z, size: metres, in the camera's frame when the session began.
    """
    square = sum((along - at) ** 2 for along, at in zip(places_kept(light), (x, y, z), strict=True))
    return 1 / (1 + np.exp(np.clip((np.sqrt(square) / size - 1) / RIM, -60, 60)))


# Kept for the lights that were asked for last, as a fit moves a mark many times.
@lru_cache(maxsize=3)
def places_kept(light: Light) -> list[np.ndarray]:
    """See `places`."""
    return places(light)


def looked_at(light: Light) -> tuple:
    """Which pixels (..., H, W) are looked at: every so many rows and columns."""
    every = max(1, round(np.sqrt(np.prod(light.range_m.shape[1:]) / PIXELS)))
    return (..., slice(None, None, every), slice(None, None, every))


def balls(light: Light) -> Iterator[tuple[dict[str, float], np.ndarray]]:
    """Balls spread over what was seen: "x", "y", "z", "size" in metres, and which of the pixels `looked_at` are in."""
    some = looked_at(light)
    points, seen = [along[some] for along in places_kept(light)], np.nan_to_num(light.returns[0].strength[some]) > 0
    if not seen.any():
        return
    middle = float(np.median(np.nan_to_num(light.range_m[some])[seen]))
    for size in (part * middle for part in SIZES):
        for place in spread(np.stack([along[seen] for along in points], axis=-1), size):
            square = sum((along - at) ** 2 for along, at in zip(points, place, strict=True))
            yield dict(zip("xyz", place.tolist(), strict=True)) | {"size": size}, square < size**2


def received(strength: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(F, P) what zones receive of strengths (F, h, w), by weights (P, h, w) or (F, P, h, w)."""
    ways = "fhw,fphw->fp" if weights.ndim == 4 else "fhw,phw->fp"
    return np.einsum(ways, strength, weights, optimize=True)


def likely_marks(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, most: int = 2
) -> list[dict[str, float]]:
    """The places and sizes of marks that explain most of an excess by zone and frame, the best first.

    excess, expected: (F, P, T) counts. Beside a gain of the session, at places spread over what was seen.
    """
    some = looked_at(rendering.light)
    weights, strength = rendering.footprints.weights[some], np.nan_to_num(rendering.light.returns[0].strength[some])
    found = list(balls(rendering.light))
    if not found:
        return []
    shares = np.stack([received(strength * inside, weights) for _, inside in found], axis=-1)
    evidence = evidence_of_shares(excess, expected, rendering.background, shares, gained=(0, 1))
    best = np.argsort(-evidence, kind="stable")[:most]
    return [{f"mark_{name}": value for name, value in found[k][0].items()} for k in best]


def spread(points: np.ndarray, apart: float) -> np.ndarray:
    """(M, 3) of points (N, 3): the mean in each cell of a grid as wide as `apart`, of the PLACES fullest."""
    cells = np.floor(points / apart).astype(int)
    cells -= cells.min(axis=0)
    # As one number each, which sort alike and much sooner.
    numbers = np.ravel_multi_index(tuple(cells.T), cells.max(axis=0) + 1)
    _, which, many = np.unique(numbers, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(which, points[:, axis]) for axis in range(3)], axis=-1) / many[:, None]
    return means[np.argsort(-many, kind="stable")[:PLACES]]
