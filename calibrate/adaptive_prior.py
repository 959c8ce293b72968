"""Where an adaptive scan begins that is given maps of the same sensor in another mode."""

from dataclasses import replace

import numpy as np

from calibrate.adaptive_fit import ROUNDS, fit
from calibrate.adaptive_model import SEEN
from calibrate.adaptive_start import Start, first_guess
from calibrate.kernel import patch_radius_of
from calibrate.sparse import spread_order
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

PRIOR_SAMPLES = 300


def start_from(prior: ResponseMaps, grid: tuple[int, int], field: np.ndarray, radius_px: float) -> Start:
    """Where to begin from maps of another mode of the same sensor."""
    if tuple(prior.zone_grid) != grid:
        raise Refusal(f"adaptive scan: the prior has {prior.zone_grid} zones, expected {grid}")
    at = np.stack([prior.xs, prior.ys], axis=1).astype(float)
    lit = np.flatnonzero((prior.normalised > SEEN).any(axis=0))
    some = lit[spread_order(at[lit], min(PRIOR_SAMPLES, len(lit)))]
    seen = prior.by_zone[:, some] / prior.by_zone[:, some].max(axis=1, keepdims=True)
    radius = patch_radius_of(prior)
    guess = first_guess(grid, field, radius, at[some], seen)
    found = fit(guess.model, guess.unknown, guess.unknown, None, at[some], seen, np.zeros_like(seen), 2 * ROUNDS)
    model = replace(guess.model, optics=replace(guess.model.optics, radius_px=radius_px))
    return Start(model, found.unknown, guess.cost)
