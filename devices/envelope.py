"""The line under a cloud of points: where it lies, and how surely.

Points come in blocks along x. In a block of n points whose delays are alike, the least delay is Weibull distributed
where the delays' density starts like a power of the delay: shape 1 for exponential and uniform delays, k for gamma ones
of shape k (extreme value theory; de Haan and Ferreira 2006, "Extreme Value Theory", chapter 1). Its scale is
s n^(-1/shape). The posterior of the line follows on a grid, with flat priors of height, slope and shape; the scale's
prior is 1/s and it integrates out in closed form. Only the lower half of the blocks counts by its values, the upper by
being above (type II censoring): bursts of delay may cover whole blocks.
"""

import math

import numpy as np

SHAPES = np.array([1.0, 1.5, 2.0, 3.0, 4.0])
SLOPES, DEPTHS = 49, 48
MOST_POINTS = 32
FINEST_S = 1e-7  # delays are not told apart below that


class Block:
    """The lower hull of the points in one stretch of x, and how many points there were."""

    def __init__(self, index: int, count: int = 0, hull: list[tuple[float, float]] | None = None) -> None:
        self.index, self.count, self.hull = index, count, hull or []

    def add(self, x: float, y: float) -> None:
        """One more point; x may come a little out of order."""
        self.count += 1
        self._keep(lower_hull([*self.hull, (x, y)]))

    def take(self, other: "Block") -> None:
        """All that another block has."""
        self.count += other.count
        self._keep(lower_hull([*self.hull, *other.hull]))

    def _keep(self, hull: list[tuple[float, float]]) -> None:
        # A clock whose rate drifts within a block makes a smooth arc of many points; every other one describes it.
        self.hull = hull if len(hull) <= MOST_POINTS else [*hull[:-1:2], hull[-1]]


def lower_hull(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The corners under which no point lies, by x (Andrew 1979, the monotone chain)."""
    hull: list[tuple[float, float]] = []
    for point in sorted(points):
        if hull and hull[-1][0] == point[0]:
            continue  # the lower of the two came first
        while len(hull) > 1 and _turn(hull[-2], hull[-1], point) <= 0:
            hull.pop()
        hull.append(point)
    return hull


def posterior(blocks: list[Block]) -> tuple[float, np.ndarray, np.ndarray]:
    """Middle x, the line's (value there, slope), and their (2, 2) covariance."""
    x = np.concatenate([[p[0] for p in b.hull] for b in blocks])
    y = np.concatenate([[p[1] for p in b.hull] for b in blocks])
    starts = np.cumsum([0, *(len(b.hull) for b in blocks[:-1])])
    counts = np.array([b.count for b in blocks], float)
    middle = float(counts @ np.add.reduceat(x, starts) / (counts @ np.array([len(b.hull) for b in blocks])))
    x = x - middle
    span = max(float(np.ptp(x)), FINEST_S)
    slope, spread = _first_guess(x, y, starts)
    # Coarse to fine: the grid shrinks to where the weight is.
    width, centre, depth = 16 * spread / span, slope, 12 * spread
    for _ in range(4):
        slopes = centre + width * np.linspace(-1, 1, SLOPES)
        depths = depth * ((np.arange(DEPTHS) + 0.5) / DEPTHS) ** 2
        tops, weight = _weights(x, y, starts, counts, slopes, depths)
        centre, deviation = _moments(slopes, weight.sum(1))
        width = max(5 * deviation, 2 * width / SLOPES)
        depth = max(depths[np.searchsorted(np.cumsum(weight.sum(0)), 0.9999).clip(max=DEPTHS - 1)] * 1.5, FINEST_S)
    values = tops[:, None] - depths[None]
    mean = np.array([np.sum(weight * values), np.sum(weight * slopes[:, None])])
    off = np.stack([values - mean[0], np.broadcast_to(slopes[:, None] - mean[1], values.shape)])
    return middle, mean, np.einsum("ijk,ljk,jk->il", off, off, weight)


def _weights(
    x: np.ndarray, y: np.ndarray, starts: np.ndarray, counts: np.ndarray, slopes: np.ndarray, depths: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Height (S,) of the highest line of each slope under all points, and posterior weight (S, D) of lines below it."""
    least = np.minimum.reduceat(y - slopes[:, None] * x, starts, axis=1)  # (S, B)
    tops = least.min(1)
    order = np.argsort(least, axis=1)
    kept = max((counts.size + 1) // 2, min(counts.size, 3))
    # The scale goes with s n^(-1/shape), so a block's excess enters as n excess^shape.
    n = counts[order]
    excess = np.maximum(np.take_along_axis(least, order, 1) - tops[:, None], 0)[:, None, :] + depths[:, None]
    seen = np.log(excess[..., :kept])  # (S, D, k)
    above = n[:, None, kept:].sum(-1)
    total = np.full((slopes.size, depths.size), -np.inf)
    for shape in SHAPES:
        powers = np.exp(shape * (seen - seen[..., -1:]))  # relative to the highest kept, against underflow
        mass = np.sum(n[:, None, :kept] * powers, -1) + above
        said = kept * math.log(shape) + (shape - 1) * seen.sum(-1) - kept * (np.log(mass) + shape * seen[..., -1])
        total = np.logaddexp(total, said)
    cells = np.gradient(depths)
    weight = np.exp(total - total.max()) * cells
    return tops, weight / weight.sum()


def _first_guess(x: np.ndarray, y: np.ndarray, starts: np.ndarray) -> tuple[float, float]:
    """Slope of the hull's edge under the middle of x, and how far block minima usually lie above it."""
    points = lower_hull(list(zip(x.tolist(), y.tolist(), strict=True)))
    right = next((i for i, point in enumerate(points) if point[0] > 0), len(points) - 1)
    (x0, y0), (x1, y1) = points[max(right - 1, 0)], points[max(right, 1) if len(points) > 1 else 0]
    slope = (y1 - y0) / (x1 - x0) if x1 > x0 else 0.0
    least = np.minimum.reduceat(y - slope * x, starts)
    return slope, max(float(np.median(least - least.min())), FINEST_S)


def _moments(values: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    mean = float(values @ weight)
    return mean, math.sqrt(max(float((values - mean) ** 2 @ weight), 0.0))


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Above 0 where the way from a over b to c turns to larger y."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
