"""Derivatives of expected counts, a row of all cells for each coordinate: written out, or sparse.

Where every bin of every zone has its own number, coordinates are as many as cells of a frame, and each moves one or two
of these: written out they would be mostly nothing, and more than memory holds.
"""

import numpy as np
from scipy.sparse import csr_array, issparse, vstack

# Of what each has a number of its own, and moves cells of one zone only.
OF_ZONES = ("zone bin", "zone edge")
# (N, F·P·T), of numbers or of some.
Rows = np.ndarray | csr_array


def rows_of(axis: str, change: np.ndarray, after: np.ndarray | None = None) -> csr_array:
    """(M, F·P·T) change of each zone, bin, edge, or of those of each zone, sparse.

    change: (F, P, T); of edges, with the one before each bin, and `after` with the one after it.
    """
    zones, bins = change.shape[1:]
    zone, bin_ = np.indices((zones, bins))
    coordinate = {"zone": zone, "bin": bin_, "edge": bin_}.get(axis, zone * bins + bin_)
    count = int(coordinate.max()) + 1
    own = _rows(change, coordinate, count)
    if "edge" not in axis or after is None:
        return own
    inside = bin_ + 1 < bins
    return own + _rows(np.where(inside, after, 0.0), np.where(inside, coordinate + 1, 0), count)


def _rows(change: np.ndarray, coordinate: np.ndarray, count: int) -> csr_array:
    """Rows of which each cell of a frame goes with one coordinate (P, T)."""
    frames = len(change)
    each = np.tile(coordinate.ravel(), frames)
    return csr_array((change.ravel(), (each, np.arange(change.size))), shape=(count, change.size))


def spread(rows: Rows, which: np.ndarray, count: int, times: np.ndarray | float = 1.0) -> csr_array:
    """(N, F·P·T) of which rows are those that these coordinates (n,) have, each so many times, others nothing."""
    times = np.broadcast_to(times, len(which))
    return csr_array((times, (which, np.arange(len(which)))), shape=(count, len(which))) @ csr_array(rows)


def scaled(rows: Rows, factor: np.ndarray) -> Rows:
    """Each cell times its factor (F·P·T,)."""
    if not issparse(rows):
        return rows * factor
    return csr_array((rows.data * factor[rows.indices], rows.indices, rows.indptr), shape=rows.shape)


def product(rows: Rows, others: Rows) -> np.ndarray:
    """(N, M) sums over cells."""
    found = rows @ others.T
    return found.toarray() if issparse(found) else found


def by_frame(rows: Rows, weighted: np.ndarray) -> np.ndarray:
    """(N, F) sums over each frame's cells, times weights (F, P, T)."""
    frames = len(weighted)
    flat = weighted.reshape(frames, -1)
    if not issparse(rows):
        each_frame = rows.reshape(-1, *flat.shape).transpose(1, 0, 2)
        return np.matmul(each_frame, flat[..., None].astype(rows.dtype))[..., 0].T
    each = csr_array((weighted.ravel(), (np.arange(flat.size), np.repeat(np.arange(frames), flat.shape[1]))))
    return product(rows, each.T)


def together(rows: Rows, more: np.ndarray) -> Rows:
    """These and more, which are written out."""
    if not issparse(rows):
        return np.concatenate([rows, more])
    return vstack([rows, csr_array(more)], format="csr") if len(more) else rows


def of_frames(rows: Rows, frames: int, chosen: np.ndarray) -> Rows:
    """Those cells that belong to some of the frames."""
    if not issparse(rows):
        return rows.reshape(len(rows), frames, -1)[:, chosen].reshape(len(rows), -1)
    cells = np.arange(rows.shape[1]).reshape(frames, -1)
    return rows[:, cells[chosen].ravel()]
