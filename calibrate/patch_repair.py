"""Which positions of a scan depart from what their neighbours in the grid say, and what these predict."""

from dataclasses import dataclass

import numpy as np

from calibrate.plan import ScanPlan

NEIGHBOURHOOD = 2  # Cells on each side.
ENOUGH = 3
LEAST_PX, SIGMAS = 3.0, 8.0


@dataclass(frozen=True)
class Expectation:
    """What neighbours predict.

    at_px: (K, 2) place of each cell in the image. limit_px: how far a patch may be from it. trusted: (K,) bool,
    where enough neighbours were seen; elsewhere the grid model alone speaks, and only predicts.
    """

    at_px: np.ndarray
    limit_px: float
    trusted: np.ndarray

    def departs(self, at_px: np.ndarray) -> np.ndarray:
        """(K, repeats) bool: which places (K, repeats, 2) are further away than that; NaN are not."""
        away = np.linalg.norm(at_px - self.at_px[:, None], axis=-1)
        return self.trusted[:, None] & (away > self.limit_px)


def expect(plan: ScanPlan, model_px: np.ndarray, at_px: np.ndarray) -> Expectation:
    """Predict each cell from the cells around it, itself left out.

    model_px: (K, 2) what the grid model predicts; at_px: (K, repeats, 2) what was seen, NaN where nothing was.
    Robots and lenses leave smooth departures from the model, which neighbours share: the prediction is the model
    plus the median departure of the neighbours.
    """
    column, row = plan.cells.T
    reach = NEIGHBOURHOOD
    departure = np.full((plan.rows + 2 * reach, plan.columns + 2 * reach, 2), np.nan)
    departure[row + reach, column + reach] = _median(np.moveaxis(at_px - model_px[:, None], 1, 0))[0]
    around = [
        departure[row + reach + down, column + reach + right]
        for down in range(-reach, reach + 1)
        for right in range(-reach, reach + 1)
        if (down, right) != (0, 0)
    ]
    shared, count = _median(np.stack(around))
    trusted = count >= ENOUGH
    expected = model_px + np.where(trusted[:, None], shared, 0)
    away = np.linalg.norm(at_px - expected[:, None], axis=-1)[trusted]
    away = away[np.isfinite(away)]
    scatter = float(np.median(away)) if away.size else 0.0
    return Expectation(expected, max(LEAST_PX, SIGMAS * scatter), trusted)


def _median(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Median over the first axis of (n, K, 2), NaN left out, NaN where all are; and how many there were, (K,)."""
    ordered = np.sort(places, axis=0)
    count = np.isfinite(places[..., 0]).sum(axis=0)
    middle = np.stack([np.maximum(count - 1, 0) // 2, np.minimum(count // 2, len(places) - 1)])
    return np.take_along_axis(ordered, middle[..., None], axis=0).mean(axis=0), count
