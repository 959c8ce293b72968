"""What a fit can make is taken out of residuals and changes, so that what is left is news."""

import numpy as np

from mismatch.columns import OF_ZONES, rows_of, scaled, together
from mismatch.directions import Directions, Frames
from mismatch.fit import Fit
from mismatch.noise import Nuisances
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation


class Projection:
    """Whitened counts with a fit's own directions, and the frames' gains, taken out.

    residual: what is left of counts, for scores. left: the same less what the frames' most likely gains take up, to
    judge a fit by: how much gain fluctuates is a guess from few frames, and what fluctuates more is no misfit.
    """

    def __init__(self, simulation: Simulation, fitted: Fit) -> None:
        self.shape = fitted.expected.shape
        self.fitted, self.simulation = fitted, simulation
        nuisances = Nuisances(simulation, fitted.frame_gain_sigma)
        applied = nuisances.applied(fitted.expected)
        self.root = 1 / np.sqrt(np.maximum(applied, LEAST)).ravel()
        self.frames = None
        if nuisances.sigma:
            signal = np.maximum(fitted.expected - simulation.dark, 0)
            self.frames = Frames(signal * self.root.reshape(self.shape), nuisances.sigma)
        own = together(fitted.columns.T, nuisances.clock_rows(nuisances.settled(fitted.expected)))
        self.own = Directions(scaled(own, self.root), self.frames)
        # Not less what the frames' gains take up: they are taken out here, and would be twice.
        self.residual = self.whitened((simulation.counts - fitted.expected).ravel())
        self.left = self.whitened((simulation.counts - applied).ravel())

    def frames_out(self, white: np.ndarray) -> np.ndarray:
        """Whitened (F·P·T, ...) less what the frames' gains could make."""
        return white if self.frames is None else self.frames.out(white)

    def whitened(self, change: np.ndarray) -> np.ndarray:
        """A change of expected counts (F·P·T, ...), whitened and projected."""
        return self.own.out(self.frames_out(change * self.root[(..., *(None,) * (change.ndim - 1))]))

    def divided(self, change: np.ndarray, axis: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Changes of which each zone, bin or edge, or those of each zone, has its own multiple, M of them.

        change: (1, F, P, T), or (2, F, P, T) what moves with the edge before each bin and with the edge after it.
        (M, M) information and (M,) score of the multiples, projected; and (M,) information before that. No array of
        cells times M is made: columns are disjoint, those of edges but for their neighbours'.
        """
        white = change * self.root.reshape(self.shape)
        before = _summed(axis, *(white**2)).sum(axis=0)
        information = np.diag(before)
        if len(white) == 2:
            # Bin t goes with the edge before it, t, and that after it, t + 1.
            shared = (white[0] * white[1])[..., :-1].sum(axis=0)
            shared = shared.sum(axis=0) if axis == "edge" else np.pad(shared, ((0, 0), (0, 1))).ravel()[:-1]
            information += np.diag(shared, 1) + np.diag(shared, -1)
        if self.frames is not None:
            # By frame and zone, bin or edge: what of the column a frame's gain can make.
            mixed = _summed(axis, *(white * self.frames.signal)) / self.frames.norm[:, None]
            information = information - mixed.T @ mixed
        # Taking frames out is symmetric: it is done to the few that columns are multiplied with.
        taken = self.own.taken(rows_of(axis, *white)).T
        residual = self.frames_out(self.residual).reshape(self.shape)
        promised = _summed(axis, *(white * residual)).sum(axis=0)
        return information - taken.T @ taken, promised, before


def _summed(axis: str, change: np.ndarray, after: np.ndarray | None = None) -> np.ndarray:
    """(F, M) sums of cells (F, P, T) that go with each zone, bin or edge. after: what goes with the edge after."""
    found = change if axis in OF_ZONES else change.sum(axis=2 if axis == "zone" else 1)
    if after is not None:
        found = found.copy()
        found[..., 1:] += (after if axis in OF_ZONES else after.sum(axis=1))[..., :-1]
    return found.reshape(len(found), -1)
