"""Directions in which a fit can move whitened counts: what it makes of them, and what is left."""

from functools import cached_property

import numpy as np
from scipy.sparse import issparse

from mismatch.columns import Rows, by_frame, product, spread

TINY = 1e-12
# Part of the strongest below which a direction is one of the others: of its length, and of its information, which is
# told as exactly as numbers are.
SAME, TOLD = 1e-6, 1e-9


class Frames:
    """What gains of the frames, each of which fluctuates by itself, can make of whitened counts.

    signal: (F, P, T) whitened, norm: (F,) root of the information of each gain, prior included.
    """

    def __init__(self, signal: np.ndarray, sigma: float) -> None:
        inner = (signal**2).sum(axis=(1, 2))
        self.signal, self.norm = signal, np.sqrt(inner + 1 / sigma**2)
        # Shrunk by the prior: 1 - sqrt(1/σ²/information) of it is taken, so that squares come out as information.
        self._taken = (1 - np.sqrt(np.maximum(1 - inner / self.norm**2, 0))) / np.maximum(inner, TINY)

    def out(self, white: np.ndarray) -> np.ndarray:
        """Whitened (F·P·T, ...) less what the frames' gains could make."""
        signal = self.signal.reshape(len(self.norm), -1, 1)
        flat = white.reshape(*signal.shape[:2], -1)
        part = np.matmul(signal.transpose(0, 2, 1), flat) * self._taken[:, None, None]
        return (flat - signal * part).reshape(white.shape)

    def mixed(self, rows: Rows) -> np.ndarray:
        """(N, F) of which products are what gains take of the information of whitened rows."""
        return by_frame(rows, self.signal) / self.norm

    def products(self, rows: Rows, others: Rows) -> np.ndarray:
        """(N, M) of whitened rows with others, as far as it is what `out` takes."""
        return (by_frame(rows, self.signal) * self._taken) @ by_frame(others, self.signal).T


def orthonormal(columns: np.ndarray) -> np.ndarray:
    """(C, K) directions of columns (C, N) of length 1, those that are one of the others left out.

    By products of columns, in less time than a singular value decomposition takes; twice, as weak ones come out
    orthogonal to half of their digits only (Yamamoto, Nakatsukasa, Yanagisawa and Fukaya 2015, Electronic Transactions
    on Numerical Analysis 44, 306).
    """
    squares, ways = np.linalg.eigh(columns.T @ columns)
    strong = squares > SAME**2 * squares.max(initial=0)
    found = columns @ (ways[:, strong] / np.sqrt(squares[strong]))
    return found @ np.linalg.inv(np.linalg.cholesky(found.T @ found)).T


class Directions:
    """K directions of a fit's rows (N, F·P·T), whitened, less what gains of frames could make; orthonormal.

    Written out where there are few. Where every bin of every zone has its own number they are as many as cells of a
    frame, and known by their information alone. frames: None where gains do not fluctuate.
    """

    def __init__(self, rows: Rows, frames: Frames | None) -> None:
        self.frames, self._own, self._rows = frames, None, None
        if issparse(rows):
            told = self._squares(rows, rows)
            some = np.flatnonzero(np.diag(told) > TINY**2)
            size = np.sqrt(np.diag(told)[some])
            self._rows = spread(rows[some], np.arange(len(some)), len(some), 1 / size)
            told, ways = np.linalg.eigh(told[np.ix_(some, some)] / np.outer(size, size))
            strong = told > TOLD * told.max(initial=0)
            self._ways = ways[:, strong] / np.sqrt(told[strong])
            return
        own = self._frames_out(rows.T)
        size = np.sqrt((own**2).sum(axis=0))
        own = own[:, size > TINY] / size[size > TINY]
        self._own = orthonormal(own)

    @cached_property
    def written(self) -> np.ndarray | None:
        """(F·P·T, K) gains of frames taken out once more, which is symmetric; None where there are too many."""
        return None if self._own is None else self._frames_out(self._own)

    def out(self, white: np.ndarray) -> np.ndarray:
        """Whitened (F·P·T, ...) less what the fit could make."""
        if self._own is not None:
            return white - self._own @ (self._own.T @ white)
        made = self._ways @ (self._ways.T @ (self._rows @ self._frames_out(white)))
        return white - self._frames_out(self._rows.T @ made)

    def products(self, rows: Rows) -> np.ndarray:
        """(M, K) of rows (M, F·P·T) with each."""
        if self._own is not None:
            return rows @ self._own
        found = product(rows, self._rows)
        found = found if self.frames is None else found - self.frames.products(rows, self._rows)
        return found @ self._ways

    def taken(self, rows: Rows) -> np.ndarray:
        """(M, K) of whitened rows, from which gains of frames are to be taken out, with each."""
        return rows @ self.written if self._own is not None else self._squares(rows, self._rows) @ self._ways

    def _squares(self, rows: Rows, others: Rows) -> np.ndarray:
        """(N, M) products of whitened rows, gains of frames taken out of both."""
        found = product(rows, others)
        return found if self.frames is None else found - self.frames.mixed(rows) @ self.frames.mixed(others).T

    def _frames_out(self, white: np.ndarray) -> np.ndarray:
        """Whitened (F·P·T, ...) less what gains of frames could make."""
        return white if self.frames is None else self.frames.out(white)
