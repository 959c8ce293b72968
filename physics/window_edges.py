"""Where a window of bins seems to begin and end, by what counts lack."""

import numpy as np

# Deviance from which an edge is one zone's own, and from which the part of a pulse in a window tells its brightness.
SHOWN = 10.0
# Edges are looked for at so many bins at most.
EDGES = 80
# Fewer counts than this are expected nowhere that tells anything.
LEAST = 1.0


def share_lost(lacking: np.ndarray, there: np.ndarray, least: float) -> tuple[float, float, float]:
    """How many of the first of T bins lack one share of what should be there most clearly, how clearly, which share.

    least: share that is the least.
    """
    lacks, has = np.maximum(np.cumsum(lacking), 0), np.maximum(np.cumsum(there), 1e-9)
    edge = int(np.argmax(lacks**2 / has))
    return edge + 1.0, float(lacks[edge] ** 2 / has[edge]), float(np.clip(lacks[edge] / has[edge], least, 1))


def emptied(lacking: np.ndarray, there: np.ndarray) -> np.ndarray:
    """(P,) how many of the first of (P, T) bins lack all that should be there, by least squares; one at least."""
    gains = np.cumsum(2 * lacking - there, axis=-1)
    return np.where(gains.max(axis=-1) > SHOWN, np.argmax(gains, axis=-1) + 1.0, 1.0)


def summed_window(excess: np.ndarray, expected: np.ndarray, background: np.ndarray) -> tuple[float, float] | None:
    """Bins before and after a window whose part of the signal says best how bright that is, None where none does.

    excess, expected, background: (F, P, T), the last broadcast. Each zone and frame has one brightness, as a gain for
    all times the part of its signal in the window: weighted least squares of the gain, for all pairs of edges.
    """
    signal = expected - np.minimum(background, expected)
    total, noise = signal.sum(axis=-1).ravel(), np.maximum(expected.sum(axis=-1).ravel(), LEAST)
    seen = total + excess.sum(axis=-1).ravel()
    until = np.concatenate([np.zeros((len(total), 1)), np.cumsum(signal.reshape(len(total), -1), axis=-1)], axis=-1)
    bins = signal.shape[-1]
    places = np.unique(np.linspace(0, bins, min(bins, EDGES) + 1).astype(int))

    def left(inside: np.ndarray) -> np.ndarray:
        """(N,) chi² that a gain for what is (N, F·P) inside leaves."""
        gain = (inside * seen / noise).sum(axis=-1) / np.maximum((inside**2 / noise).sum(axis=-1), 1e-300)
        return ((seen - gain[:, None] * inside) ** 2 / noise).sum(axis=-1)

    alone, best, edges = float(left(total[None])[0]), np.inf, (0, bins)
    for first in places[:-1]:
        ends = places[places > first]
        chi = left((until[:, ends] - until[:, [first]]).T)
        if chi.min() < best:
            best, edges = float(chi.min()), (int(first), int(ends[np.argmin(chi)]))
    return (float(edges[0]), float(bins - edges[1])) if alone - best > SHOWN else None
