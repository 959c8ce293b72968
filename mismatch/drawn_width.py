"""How widely numbers are drawn, all alike: by maximum likelihood, the numbers themselves integrated out."""

import numpy as np
from scipy.linalg import eigvalsh_tridiagonal, solve_banded
from scipy.linalg.lapack import dsytrd, dsytrd_lwork
from scipy.optimize import minimize_scalar

# The width lies between these parts of what would be seen, and of what could be.
LEAST, MOST = 1e-3, 1e3


def likeliest_width(information: np.ndarray, score: np.ndarray) -> tuple[float, float, np.ndarray]:
    """Minus twice the logarithm of the likelihood at the likeliest width, up to a constant; that width's square.

    And (K,) information of each of as many independent numbers. information: (K, K) of numbers that are drawn each by
    itself. score: (K,) of them at nothing. Of an information I the likelihood of a width w is, with the numbers
    integrated out, |1 + w² I|^(-1/2) exp(w² s·(1 + w² I)⁻¹ s / 2). A rotation that leaves I with three diagonals is all
    that it takes (Householder 1958): its eigenvectors would take twice as long, and are not asked for.
    """
    diagonal, beside, turned = tridiagonal(information, score)
    told = eigvalsh_tridiagonal(diagonal, beside)
    # No number is told less than nothing but for rounding.
    diagonal, told = diagonal + max(-float(told[0]), 0.0), np.maximum(told, 0.0)
    banded = np.stack([np.append(0.0, beside), diagonal, np.append(beside, 0.0)])

    def loss(log_width: float) -> float:
        square = np.exp(2 * log_width)
        wider = square * banded
        wider[1] += 1
        explained = square * turned @ solve_banded((1, 1), wider, turned)
        return float(np.log(1 + square * told).sum() - explained)

    seen = -0.5 * np.log(max(told.max(initial=0.0), 1e-12))
    found = minimize_scalar(loss, bounds=(seen + np.log(LEAST), seen + np.log(MOST)), method="bounded")
    return float(found.fun), float(np.exp(2 * found.x)), told


def tridiagonal(matrix: np.ndarray, vector: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(K,) diagonal and (K - 1,) the one beside it of a symmetric (K, K) matrix once it is turned; (K,) vector, too."""
    size = len(matrix)
    mirrors, diagonal, beside, parts, _ = dsytrd(matrix, lower=1, lwork=int(dsytrd_lwork(size, lower=1)[0]))
    turned = np.array(vector, float)
    for i, part in enumerate(parts):
        mirror = np.append(1.0, mirrors[i + 2 :, i])
        turned[i + 1 :] -= part * (mirror @ turned[i + 1 :]) * mirror
    return diagonal, beside, turned
