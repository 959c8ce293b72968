"""Maps at all positions of a scan from those that an adaptive scan visited."""

import json

import numpy as np
from scipy.spatial import cKDTree

from calibrate.adaptive_fit import ROUNDS, fit
from calibrate.adaptive_posterior import Posterior
from calibrate.adaptive_start import first_guess, improved
from calibrate.flags import Flag
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

LEAST = 40
TURNS = 3  # fits, each of which moves the strengths of departures a step
BLOCK = 400
NEAR = 0.5  # of the cells' spacing: where a sample lies so near, a cell was visited


def filled(maps: ResponseMaps, centres_px: np.ndarray, patch_radius_px: float) -> ResponseMaps:
    """`maps` with what all other cells would have measured: predicted, with errors, flagged `Flag.PREDICTED`.

    centres_px: (K, 2) expected pixel of every cell. The samples of `maps` come first, unchanged; then, in the order of
    the cells and named "p" and the cell's number, those that were not visited. Raises `Refusal` for fewer than 40
    samples, and for a zone grid whose SPADs are not known.
    """
    field = np.asarray(centres_px, float)
    if field.ndim != 2 or field.shape[1] != 2 or len(field) < 2 or not np.isfinite(field).all():
        raise Refusal(f"centres_px has shape {field.shape}, expected (K, 2) finite pixels")
    if not (np.isfinite(patch_radius_px) and patch_radius_px > 0):
        raise Refusal(f"patch radius: {patch_radius_px} px, expected pixels above 0")
    if len(maps.xs) < LEAST:
        raise Refusal(f"xs: {len(maps.xs)} scan positions, expected at least {LEAST} to predict the others from")
    at = np.stack([maps.xs, maps.ys], axis=1).astype(float)
    spacing = np.median(cKDTree(field).query(field, 2)[0][:, 1])
    empty = np.flatnonzero(cKDTree(at).query(field)[0] > NEAR * spacing)
    seen = maps.by_zone.astype(float)
    scale = np.maximum(seen.max(axis=1, keepdims=True), 1e-300)
    own = np.zeros_like(seen) if maps.sigma is None else maps.sigma.reshape(seen.shape).astype(float)
    post = _posterior(maps.zone_grid, field, patch_radius_px, at, seen / scale, own / scale)
    value, sigma = _predicted(post, field[empty])
    flags = np.zeros(seen.shape, np.uint8) if maps.flags is None else maps.flags.reshape(seen.shape)
    added = np.full(value.shape, Flag.PREDICTED, np.uint8)

    def joined(measured: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        both = np.concatenate([measured, predicted], axis=1).astype(measured.dtype)
        return both.reshape(*maps.zone_grid, -1)

    nothing = np.zeros(len(empty))
    return ResponseMaps(
        responses=joined(maps.by_zone, value * scale),
        xs=np.concatenate([maps.xs, field[empty, 0]]).astype(maps.xs.dtype),
        ys=np.concatenate([maps.ys, field[empty, 1]]).astype(maps.ys.dtype),
        cap_ids=np.concatenate([maps.cap_ids, np.array([f"p{cell:04d}" for cell in empty], "U8")]),
        meta_json=json.dumps(maps.meta | {"predicted": len(empty), "measured": len(at)}),
        sigma=joined(own, sigma * scale),
        flags=joined(flags, added),
        position_sigma_px=_extended(maps.position_sigma_px, nothing),
        position_confidence=_extended(maps.position_confidence, nothing),
    )


def _extended(values: np.ndarray | None, more: np.ndarray) -> np.ndarray | None:
    return None if values is None else np.concatenate([values, more]).astype(values.dtype)


def _posterior(
    grid: tuple[int, int], field: np.ndarray, radius_px: float, at: np.ndarray, seen: np.ndarray, sigma: np.ndarray
) -> Posterior:
    """The fit to all samples (P, n) at (n, 2), in units of the zones' scales."""
    start = improved(first_guess(grid, field, radius_px, at, seen), at, seen)
    post = fit(start.model, start.unknown, start.unknown, None, at, seen, sigma, 2 * ROUNDS)
    for _ in range(TURNS - 1):
        post = fit(start.model, start.unknown, post.unknown, post.strengths, at, seen, sigma)
    return post


def _predicted(post: Posterior, field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(P, N) responses and their standard errors at (N, 2) pixels, in units of the zones' scales."""
    values, sigmas = [np.empty((len(post.seen), 0))], [np.empty((len(post.seen), 0))]
    for begin in range(0, len(field), BLOCK):
        here = field[begin : begin + BLOCK]
        value, kept = post.expected(here)
        variance = post.far_variance(here)
        rows = post.model.rows(post.unknown, *here.T, kept)
        variance[kept] = np.maximum(np.diag(post.covariance(rows, here)), 0) * post.candour[rows.zone]
        values.append(value)
        sigmas.append(np.sqrt(variance))
    return np.concatenate(values, axis=1), np.concatenate(sigmas, axis=1)
