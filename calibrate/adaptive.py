"""A scan that looks where the maps are least certain, and ends when they are certain enough."""

import numpy as np

from calibrate.adaptive_choice import farthest, short_order
from calibrate.adaptive_fit import ROUNDS, fit
from calibrate.adaptive_model import SEEN
from calibrate.adaptive_outlook import Outlook, outlook
from calibrate.adaptive_posterior import Posterior
from calibrate.adaptive_prior import start_from
from calibrate.adaptive_start import Start, first_guess, improved, known
from calibrate.sparse import spread_order
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

COARSE, LIT = 24, 30  # positions all over the image, then in what turned out to be lit
LIT_SHARE = 0.03  # of the largest sum of all zones
SETTLED = 75  # samples from which the first guess is not made anew
COUNTING = 120  # samples from which an estimate counts: with fewer, what was overlooked is most of the error


class AdaptivePlan:
    """Chooses positions by what is known so far: `next`, measure there, `learn`, and again until `next` is empty.

    centres_px: (K, 2) pixel at which the patch is expected in each cell. patch_radius_px: of its image.
    accuracy: cosine to the full map that the worst zone must reach, as the plan estimates it.
    zone_grid: rows and columns of zones. batch: positions a time. prior: maps of the same sensor in another mode, from
    the same place, which make the coarse pass unnecessary. most: positions at most.

    What the full map would be is predicted with a model of the sensor's optics; see `calibrate.adaptive_model`. Raises
    `Refusal` for a zone grid whose SPADs are not known, and for numbers that make no scan.
    """

    def __init__(
        self,
        centres_px: np.ndarray,
        patch_radius_px: float,
        *,
        accuracy: float = 0.995,
        zone_grid: tuple[int, int] = (3, 3),
        batch: int = 24,
        prior: ResponseMaps | None = None,
        most: int | None = None,
    ) -> None:
        self._field = np.array(centres_px, float)
        if self._field.ndim != 2 or self._field.shape[1] != 2 or not np.isfinite(self._field).all():
            raise Refusal(f"adaptive scan: centres_px has shape {self._field.shape}, expected (K, 2) finite pixels")
        if len(self._field) < COARSE + LIT:
            raise Refusal(f"adaptive scan: {len(self._field)} cells, expected at least {COARSE + LIT}")
        if not (np.isfinite(patch_radius_px) and patch_radius_px > 0):
            raise Refusal(f"adaptive scan: patch radius {patch_radius_px} px, expected pixels above 0")
        if not 0 < accuracy < 1:
            raise Refusal(f"adaptive scan: accuracy {accuracy}, expected a cosine between 0 and 1")
        if batch < 1:
            raise Refusal(f"adaptive scan: batches of {batch}, expected at least 1")
        known(zone_grid)
        self._radius, self._accuracy, self._grid = float(patch_radius_px), accuracy, tuple(zone_grid)
        self._batch, self._most = int(batch), len(self._field) if most is None else min(int(most), len(self._field))
        self._visited = np.zeros(len(self._field), bool)
        self._xy, self._cells = np.empty((0, 2)), np.empty(0, int)
        zones = self._grid[0] * self._grid[1]
        self._seen, self._sigma = np.empty((zones, 0)), np.empty((zones, 0))
        self._scale = np.ones((zones, 1))
        self._start: Start | None = None
        self._posterior: Posterior | None = None
        self._outlook: Outlook | None = None
        self.reached = self._before = 0.0
        self._given = prior is not None
        if prior is not None:
            self._start = start_from(prior, self._grid, self._field, self._radius)

    def next(self) -> np.ndarray:
        """(n,) indices of the cells to visit next, in an order of short travel; empty when the scan may end."""
        left = self._most - int(self._visited.sum())
        if left <= 0 or self.reached >= self._accuracy or self._visited.all():
            return np.empty(0, int)
        count = min(self._batch, left)
        chosen = self._coarse()[:left] if self._outlook is None else self._outlook.best(count)
        if not len(chosen):
            chosen = farthest(self._field, ~self._visited, self._xy, count)
        return chosen[short_order(self._field[chosen])]

    def learn(
        self,
        cells: np.ndarray,
        responses: np.ndarray,
        sigma: np.ndarray | None = None,
        centres_px: np.ndarray | None = None,
    ) -> None:
        """Take in what was measured in cells (n,): responses (P, n) and errors, counts, at (n, 2) pixels.

        Cells whose responses are not finite (a lost capture) count as visited and tell nothing.
        """
        cells, responses = np.asarray(cells, int), np.asarray(responses, float)
        sigma = np.zeros_like(responses) if sigma is None else np.asarray(sigma, float)
        at = self._field[cells] if centres_px is None else np.asarray(centres_px, float)
        if responses.shape != (len(self._seen), len(cells)) or sigma.shape != responses.shape:
            raise Refusal(
                f"adaptive scan: responses {responses.shape} and sigma {sigma.shape}, "
                f"expected {(len(self._seen), len(cells))}"
            )
        if at.shape != (len(cells), 2):
            raise Refusal(f"adaptive scan: centres_px has shape {at.shape}, expected {(len(cells), 2)}")
        good = np.isfinite(responses).all(axis=0) & np.isfinite(sigma).all(axis=0) & np.isfinite(at).all(axis=1)
        self._visited[cells] = True
        self._cells = np.concatenate([self._cells, cells[good]])
        self._xy = np.concatenate([self._xy, at[good]])
        self._seen = np.concatenate([self._seen, responses[:, good]], axis=1)
        self._sigma = np.concatenate([self._sigma, sigma[:, good]], axis=1)
        # A zone that saw nothing yet has to be found first.
        if (self._seen > 0).any(axis=1).all() and (self._given or len(self._cells) > max(COARSE, LIT)):
            self._update()

    def expected(self) -> np.ndarray:
        """(P, K) counts: the maps at all cells, measured where they were, predicted elsewhere.

        Raises `Refusal` before the coarse pass is over.
        """
        if self._posterior is None:
            raise Refusal(f"adaptive scan: {len(self._cells)} cells measured, expected the whole coarse pass")
        value = self._posterior.expected(self._field)[0] * self._scale
        value[:, self._cells] = self._seen
        return value

    def _coarse(self) -> np.ndarray:
        """The next of the coarse pass: all over the image, then farthest from all others where there is light."""
        if self._start is None and not self._visited.any():
            return spread_order(self._field, COARSE)
        lit, visited = np.ones(len(self._field), bool), self._field[self._visited]
        if self._start is None and (self._seen > 0).any():
            total = (self._seen / np.maximum(self._seen.max(axis=1, keepdims=True), 1e-300)).sum(axis=0)
            apart = np.linalg.norm(self._field[:, None] - self._xy, axis=2)
            lit = total[apart.argmin(axis=1)] > LIT_SHARE * total.max()
        elif self._start is not None:
            lit = (self._start.model.maps(self._start.unknown, *self._field.T)[1] > SEEN).any(axis=0)
        return farthest(self._field, lit & ~self._visited, visited, LIT)

    def _update(self) -> None:
        """Fit the model to all samples, and estimate how well the maps are known."""
        scale = np.maximum(self._seen.max(axis=1, keepdims=True), 1e-300)
        seen, sigma = self._seen / scale, self._sigma / scale
        before, rounds = self._posterior, 1
        if before is not None and before.xy.shape[0] >= SETTLED:
            prior, unknown, shift = before.prior, before.unknown, np.log(self._scale / scale)[:, 0]
        else:
            if not self._given:
                self._start = (
                    first_guess(self._grid, self._field, self._radius, self._xy, seen)
                    if self._start is None
                    else improved(self._start, self._xy, seen)
                )
            # So few samples tell the parameters of the optics, but not every SPAD's.
            rounds = ROUNDS if len(self._cells) >= SETTLED else 0
            prior, unknown, shift = self._start.unknown, self._start.unknown, 0.0
        gains, stray, _ = self._start.model.start
        prior, unknown = prior.copy(), unknown.copy()
        prior[gains:stray] += shift
        unknown[gains:stray] += shift
        strengths = self._posterior.strengths if self._posterior else None
        self._scale = scale
        self._posterior = fit(self._start.model, prior, unknown, strengths, self._xy, seen, sigma, rounds)
        self._outlook = outlook(self._posterior, self._field, self._visited)
        # An estimate counts once another batch has confirmed it: what was overlooked shows in new samples.
        estimate = self._outlook.cosine if len(self._cells) >= COUNTING else 0.0
        self.reached, self._before = min(estimate, self._before), estimate
