"""Of what zones receive of things, what an excess of counts goes with."""

import numpy as np


def evidence_of_shares(
    excess: np.ndarray, expected: np.ndarray, background: np.ndarray, shares: np.ndarray, gained: tuple[int, ...]
) -> np.ndarray:
    """(N,) deviance that a factor of each of N things explains, by weighted least squares beside gains.

    excess, expected: (F, P, T) counts; background: broadcasts with these. shares: (F, P, N) what zones receive of each.
    gained: the axes that one gain is of: (0, 1) one of the session, (1,) one of every frame.
    """
    noise = 1 / np.maximum(expected.sum(axis=-1), 1)[..., None]
    signal = np.maximum(expected - background, 0).sum(axis=-1)[..., None]

    def beside(of: np.ndarray) -> np.ndarray:
        """(F, P, N) less what goes with the signal."""
        size = np.maximum((signal**2 * noise).sum(axis=gained, keepdims=True), 1e-300)
        return of - signal * (of * signal * noise).sum(axis=gained, keepdims=True) / size

    amiss, shares = beside(excess.sum(axis=-1)[..., None]), beside(shares)
    told = (shares**2 * noise).sum(axis=(0, 1))
    return (shares * amiss * noise).sum(axis=(0, 1)) ** 2 / np.maximum(told, 1e-300)
