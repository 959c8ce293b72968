"""How well the maps are known while a scan goes on, and where it would help most to look."""

from dataclasses import dataclass

import numpy as np

from calibrate.adaptive_choice import best_cells
from calibrate.adaptive_model import SEEN, Rows
from calibrate.adaptive_posterior import Posterior

CANDIDATES, FAR_CELLS = 450, 150


@dataclass(frozen=True, eq=False)
class Outlook:
    """share: (P,) expected squared error of each zone's map over its square. power: (P,) that square.

    some: cells looked at, (N,). rows, covariance: their responses as expected; noise: variances of the
    errors a full scan would make in them. All None where no cell is left in the light.
    """

    share: np.ndarray
    power: np.ndarray
    some: np.ndarray
    rows: Rows | None
    covariance: np.ndarray | None
    noise: np.ndarray | None

    @property
    def cosine(self) -> float:
        """Of the worst zone to the full map: errors at right angles to a map turn it by their share of its length."""
        return float((1 / np.sqrt(1 + self.share)).min())

    def best(self, count: int) -> np.ndarray:
        """Cells that reduce the expected errors most, those of the worst zones above all; empty where none is left."""
        if self.rows is None:
            return np.empty(0, int)
        cost = (self.share / self.power)[self.rows.zone]
        return self.some[best_cells(self.covariance, self.rows.cell, cost, self.noise, count)]


def outlook(post: Posterior, field: np.ndarray, visited: np.ndarray) -> Outlook:
    """The errors expected in a sample of the cells (K, 2) not yet visited, (K,): ours, and those of the full map."""
    zones, samples = post.seen.shape
    value, near = post.model.maps(post.unknown, *field.T)
    kept = (near > SEEN) & ~visited
    lit = np.flatnonzero(kept.any(axis=0))
    dark = np.flatnonzero(~visited & ~kept.any(axis=0))
    missing, rows, covariance, noise = np.zeros(zones), None, None, None
    # Another sample each time: a cell that is passed over has its chance later.
    some = np.sort(np.random.default_rng(samples).permutation(lit)[:CANDIDATES])
    if len(some):
        rows = post.model.rows(post.unknown, *field[some].T, kept[:, some])
        errors = post.candour[rows.zone]
        covariance = post.covariance(rows, field[some]) * np.sqrt(np.outer(errors, errors))
        covariance += post.overlooked(rows, field[some])
        noise = post.noise(rows) * errors
        missing += np.bincount(rows.zone, np.diag(covariance) + noise, zones) * len(lit) / len(some)
    # Stray light is smooth: a few cells tell how well it is known.
    for cells in (lit, dark):
        few = cells[:: max(len(cells) // FAR_CELLS, 1)]
        if len(few):
            stray = post.far_variance(field[few]) * ~kept[:, few]
            missing += stray.sum(axis=1) * len(cells) / len(few)
    power = np.square(post.seen).sum(axis=1) + (np.square(value) * ~visited).sum(axis=1)
    return Outlook(missing / power, power, some, rows, covariance, noise)
