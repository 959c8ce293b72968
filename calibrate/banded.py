"""Penalised least squares whose normal equations are banded: one factorisation serves every zone."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.linalg.lapack import dtbtrs
from scipy.optimize import minimize_scalar
from threadpoolctl import threadpool_limits

LOG_SMOOTHNESS = (-12.0, 6.0)  # natural logarithm; below, the equations are singular to double precision
RIDGE = 1e-3  # keeps the penalty invertible, so that its determinant, and with it the evidence, is finite
COLUMNS = 512  # right-hand sides solved at a time, to bound the memory


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep linear algebra to one thread: the blocks of a band are so small that threads mostly wait for each other.

    A factorisation takes 16 ms so, 65 ms with two threads, and 700 ms with two where another process is busy.
    """
    with threadpool_limits(1, user_api="blas"):
        yield


@dataclass(frozen=True, eq=False)
class Penalised:
    """The minimiser of |y − A c|² + λ cᵀ Q c, and the posterior it is the mean of.

    design: (K, M) A. smoothness: λ. factor: banded Cholesky factor of AᵀA + λQ. The posterior of c for noise of unit
    variance has the covariance (AᵀA + λQ)⁻¹ (Eilers & Marx 1996; Wood 2017, §4.2.4 and §5.8).
    """

    design: sparse.csr_array
    smoothness: float
    factor: np.ndarray

    def coefficients(self, y: np.ndarray) -> np.ndarray:
        """(P, M) coefficients for (P, K) data."""
        with one_thread():
            return cho_solve_banded((self.factor, True), self.design.T @ y.T).T

    def variance(self, rows: sparse.csr_array) -> np.ndarray:
        """(N,) posterior variance of `rows` (N, M) times the coefficients, for noise of unit variance."""
        found = np.empty(rows.shape[0])
        starts = np.full(rows.shape[0], rows.shape[1])
        np.minimum.at(starts, np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr)), rows.indices)
        order = np.argsort(starts)
        with one_thread():
            for begin in range(0, len(order), COLUMNS):
                some = order[begin : begin + COLUMNS]
                # With S = LLᵀ, bᵀS⁻¹b = |L⁻¹b|²; before the first entry of b the solution of Lz = b is 0.
                first = min(starts[some[0]], rows.shape[1] - 1)
                right = np.asfortranarray(rows[some].toarray().T[first:])
                solved, _ = dtbtrs(self.factor[:, first:], right, uplo="L", overwrite_b=True)
                found[some] = np.square(solved).sum(axis=0)
        return found

    @cached_property
    def leverage(self) -> np.ndarray:
        """(K,) diagonal of the hat matrix: how much each datum pulls the fit to itself, 0 to 1."""
        return self.variance(self.design)


def solve(design: sparse.csr_array, penalty: sparse.csr_array, y: np.ndarray) -> Penalised:
    """Factorise with the smoothness λ of largest evidence, one for all P rows of `y` (P, K).

    The evidence is the marginal likelihood of y under c ~ N(0, φ (λQ)⁻¹) and noise of variance φ, with φ of each row
    at its maximum (Wood 2017, §6.2).
    """
    normal, banded_penalty = (
        banded(design.T @ design),
        banded(penalty + RIDGE * sparse.eye_array(penalty.shape[0])),
    )
    moments, energy = design.T @ y.T, np.square(y).sum(axis=1)
    rows, data = y.shape

    def factorised(log_smoothness: float) -> np.ndarray:
        total = np.zeros((max(len(normal), len(banded_penalty)), normal.shape[1]))
        total[: len(normal)] += normal
        total[: len(banded_penalty)] += np.exp(log_smoothness) * banded_penalty
        return cholesky_banded(total, lower=True)

    def minus_log_evidence(log_smoothness: float) -> float:
        factor = factorised(log_smoothness)
        misfit = energy - (moments * cho_solve_banded((factor, True), moments)).sum(axis=0)
        log_determinant = 2 * np.log(factor[0]).sum() - normal.shape[1] * log_smoothness
        return 0.5 * (data * np.log(misfit).sum() + rows * log_determinant)

    with one_thread():
        best = minimize_scalar(minus_log_evidence, bounds=LOG_SMOOTHNESS, method="bounded", options={"xatol": 0.1}).x
        return Penalised(design, float(np.exp(best)), factorised(best))


def banded(matrix: sparse.csr_array) -> np.ndarray:
    """Lower banded storage of a symmetric sparse matrix, as LAPACK wants it."""
    lower = sparse.coo_array(sparse.tril(matrix))
    offset = lower.row - lower.col
    stored = np.zeros((int(offset.max(initial=0)) + 1, matrix.shape[0]))
    stored[offset, lower.col] = lower.data
    return stored
