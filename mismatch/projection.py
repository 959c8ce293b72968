"""What a fit can make is taken out of residuals and changes, so that what is left is news."""

import numpy as np

from mismatch.fit import Fit
from mismatch.noise import Nuisances
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation

TINY = 1e-12


class Projection:
    """Whitened counts with a fit's own directions, and the frames' gains, taken out.

    residual: what is left of counts, for scores. left: the same less what the frames' most likely gains take up, to
    judge a fit by: how much gain fluctuates is a guess from few frames, and what fluctuates more is no misfit.
    """

    def __init__(self, simulation: Simulation, fitted: Fit) -> None:
        self.shape = fitted.expected.shape
        self.fitted, self.simulation = fitted, simulation
        nuisances = Nuisances(simulation, fitted.frame_gain_sigma)
        self.root = 1 / np.sqrt(np.maximum(nuisances.applied(fitted.expected), LEAST)).ravel()
        self.signal = None
        if nuisances.sigma:
            signal = np.maximum(fitted.expected - simulation.dark, 0)
            white = signal * self.root.reshape(self.shape)
            self.signal = white, np.sqrt((white**2).sum(axis=(1, 2)) + 1 / nuisances.sigma**2)
        own = np.concatenate([fitted.columns.T, nuisances.clock_rows(nuisances.settled(fitted.expected))]).T
        own = self.frames_out(own * self.root[:, None])
        scale = np.sqrt((own**2).sum(axis=0))
        own = own[:, scale > TINY] / scale[scale > TINY]
        u, s, _ = np.linalg.svd(own, full_matrices=False)
        self.own = u[:, s > 1e-6 * s.max(initial=0)]
        # Not less what the frames' gains take up: they are taken out here, and would be twice.
        self.residual = self.out(self.frames_out((simulation.counts - fitted.expected).ravel() * self.root))
        applied = nuisances.applied(fitted.expected)
        self.left = self.out(self.frames_out((simulation.counts - applied).ravel() * self.root))

    def frames_out(self, white: np.ndarray) -> np.ndarray:
        """Whitened (F·P·T, ...) less what the frames' gains could make."""
        if self.signal is None:
            return white
        signal, norm = self.signal
        flat = white.reshape(self.shape[0], -1, *white.shape[1:])
        part = np.einsum("fc,fc...->f...", signal.reshape(self.shape[0], -1), flat)
        # Shrunk by the prior: 1 - sqrt(1/σ²/information) of it is taken, so that squares come out as information.
        inner = (signal**2).sum(axis=(1, 2))
        taken = (1 - np.sqrt(np.maximum(1 - inner / norm**2, 0))) / np.maximum(inner, TINY)
        back = (
            signal.reshape(self.shape[0], -1)[(..., *(None,) * (white.ndim - 1))]
            * (part * taken[(..., *(None,) * (white.ndim - 1))])[:, None]
        )
        return (flat - back).reshape(white.shape)

    def out(self, white: np.ndarray) -> np.ndarray:
        """Less what the fit's own parameters could make."""
        return white - self.own @ (self.own.T @ white)

    def divided(self, change: np.ndarray, axis: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Changes of which each "zone", "bin" or "edge" has its own multiple, M of them.

        change: (1, F, P, T), or (2, F, P, T) what moves with the edge before each bin and with the edge after it.
        (M, M) information and (M,) score of the multiples, projected; and (M,) information before that. No array of
        cells times M is made: columns are disjoint, those of edges but for their neighbours'.
        """
        white = change * self.root.reshape(self.shape)
        before = _summed(axis, *(white**2)).sum(axis=0)
        information = np.diag(before)
        if axis == "edge":
            # Bin t goes with the edge before it, t, and that after it, t + 1.
            shared = (white[0] * white[1]).sum(axis=(0, 1))[:-1]
            information += np.diag(shared, 1) + np.diag(shared, -1)
        if self.signal is not None:
            signal, norm = self.signal
            # By frame and zone, bin or edge: what of the column a frame's gain can make.
            mixed = _summed(axis, *(white * signal)) / norm[:, None]
            information = information - mixed.T @ mixed
        # Taking frames out is symmetric: it is done to the few that columns are multiplied with.
        own = np.moveaxis(self.frames_out(self.own).reshape(*self.shape, -1), -1, 0)
        residual = self.frames_out(self.residual).reshape(self.shape)
        taken = np.array([_summed(axis, *(white * one)).sum(axis=0) for one in own]).reshape(-1, len(before))
        promised = _summed(axis, *(white * residual)).sum(axis=0)
        return information - taken.T @ taken, promised, before

    def whitened(self, change: np.ndarray) -> np.ndarray:
        """A change of expected counts (F·P·T, ...), whitened and projected."""
        return self.out(self.frames_out(change * self.root[(..., *(None,) * (change.ndim - 1))]))


def _summed(axis: str, change: np.ndarray, after: np.ndarray | None = None) -> np.ndarray:
    """(F, M) sums of cells (F, P, T) that go with each zone, bin or edge. after: what goes with the edge after."""
    found = change.sum(axis=2 if axis == "zone" else 1)
    if after is not None:
        found[:, 1:] += after.sum(axis=1)[:, :-1]
    return found
