"""What samples tell of the maps: what to expect anywhere, and the error left."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.spatial.distance import cdist

from calibrate.adaptive_kernel import FLOOR, REACH, alone_noise, departures, matern
from calibrate.adaptive_model import SEEN, Model, Rows
from calibrate.banded import one_thread

FAR_REACH, FAR_DEPARTURE = 6.0, 0.01  # of stray light: patch radii, share of the peak
BELIEF = 20.0  # samples' worth of belief that the errors are as the model states them
LEAST_CANDOUR = 0.3
OVERLOOKED = 0.03  # of the peak: what may be wrong with the model where no sample is near


@dataclass(frozen=True, eq=False)
class Posterior:
    """Given samples (P, n) at (n, 2) pixels, in units of each zone's scale; those in `rows` were fitted.

    A Gaussian process about the model, linearised at its most probable unknowns (Rasmussen & Williams 2006, §2.7).
    """

    model: Model
    prior: np.ndarray
    unknown: np.ndarray
    strengths: np.ndarray
    xy: np.ndarray
    seen: np.ndarray
    sigma: np.ndarray
    rows: Rows
    factor: np.ndarray
    lever: np.ndarray
    pull: np.ndarray

    @property
    def far(self) -> np.ndarray:
        """(P, n) which samples were not fitted: stray light alone."""
        far = np.ones(self.seen.shape, bool)
        far[self.rows.zone, self.rows.cell] = False
        return far

    def expected(self, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(P, N) the maps at (N, 2) pixels, and which of them are more than stray light."""
        value, near = self.model.maps(self.unknown, *xy.T)
        kept = near > SEEN
        zone, cell = np.nonzero(kept)
        there = Rows(zone, cell, value[kept], near[kept], None, None)
        value[kept] += self._local(there, xy) @ self.pull
        for p, far in enumerate(self.far):
            weights = self._far(p, xy[~kept[p]])[0]
            at = self.xy[far]
            modelled = self.model.maps(self.unknown, *at.T)[0][p]
            value[p, ~kept[p]] += weights @ (self.seen[p, far] - modelled)
        return np.maximum(value, 0), kept

    def covariance(self, there: Rows, xy: np.ndarray) -> np.ndarray:
        """(N, N) covariance of the responses in `there`, cells of which lie at `xy`."""
        spread = self.model.spread**2
        prior = (there.slope * spread) @ there.slope.T
        prior = prior.toarray() + self._departures(there, there, xy, xy)
        across = ((there.slope * spread) @ self.rows.slope.T).toarray() + self._local(there, xy)
        with one_thread():
            half = solve_triangular(self.factor, across.T, lower=True, check_finite=False)
            return prior - half.T @ half

    def far_variance(self, xy: np.ndarray) -> np.ndarray:
        """(P, N) variance of the responses at (N, 2) pixels where they are stray light."""
        return np.stack([self._far(p, xy)[1] for p in range(len(self.seen))])

    def overlooked(self, there: Rows, xy: np.ndarray) -> np.ndarray:
        """(N, N) covariance of what neither model nor samples tell of: each zone may be off where none was near."""
        nearest = cdist(xy, self.xy).min(axis=1)
        alike = matern(cdist(xy, xy) / self._reach)[there.cell[:, None], there.cell]
        unseen = np.sqrt(1 - np.square(matern(nearest / self._reach)))[there.cell]
        size = OVERLOOKED * unseen * np.sqrt(np.clip(np.maximum(there.value, there.near), 0, 1))
        return alike * np.outer(size, size) * (there.zone[:, None] == there.zone)

    def noise(self, there: Rows) -> np.ndarray:
        """(N,) variances of the errors that a scan would make in the responses `there`."""
        alone = alone_noise(there.value, there.value, np.zeros(len(there.value)))
        moved = np.square(there.tilt).sum(axis=1) * self.model.optics.radius_px**2
        return alone + (self.strengths[2] * np.minimum(there.value, 1)) ** 2 + self.strengths[3] ** 2 * moved

    @cached_property
    def candour(self) -> np.ndarray:
        """(P,) how much larger the squared errors of samples predicted from all others are than stated, by zone.

        Leave-one-out residuals in closed form (Rasmussen & Williams 2006, Eq. 5.12), all zones of a sample at a time.
        """
        with one_thread():
            inverse = cho_solve((self.factor, True), np.eye(len(self.factor)), check_finite=False)
        error, stated = np.empty(len(self.factor)), np.empty(len(self.factor))
        for cell in np.unique(self.rows.cell):
            mine = np.flatnonzero(self.rows.cell == cell)
            covariance = np.linalg.inv(inverse[np.ix_(mine, mine)])
            error[mine], stated[mine] = np.square(covariance @ self.lever[mine]), np.diag(covariance)
        believed = BELIEF * stated.mean()
        overall = (error.sum() + believed) / (stated.sum() + believed)
        zones = len(self.seen)
        error, stated = (np.bincount(self.rows.zone, values, zones) for values in (error, stated))
        return np.maximum((error + believed * overall) / (stated + believed), LEAST_CANDOUR)

    def _local(self, there: Rows, xy: np.ndarray) -> np.ndarray:
        """(N, n) covariance of departures with those of the samples."""
        return self._departures(there, self.rows, xy, self.xy)

    def _departures(self, a: Rows, b: Rows, xy_a: np.ndarray, xy_b: np.ndarray) -> np.ndarray:
        texture, own = departures(a, b, xy_a, xy_b, self._reach)
        return self.strengths[0] ** 2 * texture + self.strengths[1] ** 2 * own

    @property
    def _reach(self) -> float:
        return REACH * self.model.optics.radius_px

    def _far(self, p: int, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N, n) weights of the samples of stray light in a zone, (N,) the variance left."""
        at, reach = self.xy[self.far[p]], FAR_REACH * self.model.optics.radius_px
        across = FAR_DEPARTURE**2 * matern(cdist(xy, at) / reach)
        if not len(at):
            return across, np.full(len(xy), FAR_DEPARTURE**2)
        within = FAR_DEPARTURE**2 * matern(cdist(at, at) / reach)
        within[np.diag_indices_from(within)] += FLOOR**2 + self.sigma[p, self.far[p]] ** 2
        with one_thread():
            weights = cho_solve(cho_factor(within, lower=True), across.T).T
        return weights, FAR_DEPARTURE**2 - (weights * across).sum(axis=1)
