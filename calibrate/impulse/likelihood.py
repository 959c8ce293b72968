"""How likely counts are where a channel registers the first photon after a shot only.

Of T shots, R_t have registered nothing before bin t. Each of these registers in bin t with probability
1 − exp(−λ_t / T), where λ_t are the counts that a detector without loss would register in all shots. So the counts
c_t are binomial, one bin after the other (Coates 1968, J. Phys. E 1, 878, whose estimator λ_t = −T log(1 − c_t / R_t)
is the maximum of this likelihood where every bin is free):

    log L = Σ_t c_t log h_t + c_t λ_t / T − λ_t R_t / T,    h_t = T (1 − exp(−λ_t / T))

It is concave in λ_t. Without end of shots it is that of Poisson counts, c log λ − λ. Several channels that share a
zone's light evenly are one with as many times the shots.
"""

from dataclasses import dataclass

import numpy as np

from recordings.refusal import Refusal


def exposure(counts: np.ndarray, shots: np.ndarray | None) -> np.ndarray:
    """(F, P, T) share of the shots that have registered nothing before each bin; 1 where shots are not counted.

    counts: (F, P, T). shots: (F,) laser shots, times the channels of a zone.
    """
    if shots is None:
        return np.ones(counts.shape)
    used = np.cumsum(counts, axis=-1)
    over = used[..., -1] >= shots[:, None]
    if over.any():
        frame, zone = (int(i) for i in np.argwhere(over)[0])
        found = f"counts[{frame}, {zone}] sum to {used[frame, zone, -1]:g}"
        raise Refusal(f"{found}, expected fewer than the {shots[frame]:g} laser shots of all channels")
    return 1 - (used - counts) / shots[:, None, None]


@dataclass(frozen=True, eq=False)
class Counted:
    """N cells that were counted.

    counts: (N,). alive: (N,) share of the shots before which nothing was registered, or how many such cells are taken
    together. shots: (N,), infinite where nothing is lost.
    """

    counts: np.ndarray
    alive: np.ndarray
    shots: np.ndarray

    def registered(self, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """h and dh/dλ at `rate` λ (N,): counts that shots still alive would register, were all of them alive."""
        lossless = np.isinf(self.shots)
        shots = np.where(lossless, 1.0, self.shots)
        h = np.where(lossless, rate, -shots * np.expm1(-rate / shots))
        return h, np.exp(-rate / self.shots)

    def log_likelihood(self, rate: np.ndarray) -> np.ndarray:
        """(N,) log likelihood of each cell, constants left out."""
        h, _ = self.registered(rate)
        return self.counts * (np.log(h) + rate / self.shots) - rate * self.alive

    def score_and_information(self, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) derivative of the log likelihood by λ, and the expected information."""
        h, slope = self.registered(rate)
        return self.counts / h - self.alive, self.alive * slope / h

    def moments(self, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N,) mean and variance of the counts, given what was registered before."""
        h, slope = self.registered(rate)
        return self.alive * h, self.alive * h * slope

    def deviance(self, rate: np.ndarray) -> np.ndarray:
        """(N,) twice the log likelihood that the best rate of each cell by itself would gain."""
        share = np.minimum(self.counts / (self.alive * self.shots), 1 - 1e-12)
        best = np.where(
            np.isinf(self.shots), self.counts / self.alive, -np.where(share > 0, self.shots, 1) * _log1m(share)
        )
        best = np.where(self.counts > 0, np.maximum(best, 1e-300), 1e-300)
        return 2 * np.maximum(self.log_likelihood(best) - self.log_likelihood(rate), 0)


def _log1m(share: np.ndarray) -> np.ndarray:
    """log(1 − share), 0 where the share is 0: infinite shots times 0 has no value."""
    return np.where(share > 0, np.log1p(-share), 0.0)
