import numpy as np
import pytest
from scipy.spatial.distance import cdist

from calibrate.adaptive_fit import fit
from calibrate.adaptive_kernel import FLOOR, MOST, REACH, RELATIVE
from calibrate.adaptive_model import FLOOD_STEP, Model
from calibrate.adaptive_optics import SIZE, SpadOptics
from calibrate.adaptive_posterior import BELIEF, LEAST_CANDOUR, OVERLOOKED
from calibrate.spline import SplineBasis
from physics.spads import spad_map

RADIUS_PX = 17.75


@pytest.fixture(scope="module")
def known():
    """A model, its true unknowns, samples of it at 70 points, and what was made of them."""
    rng = np.random.default_rng(5)
    field = np.stack(np.meshgrid(np.arange(20, 840, 20.0), np.arange(20, 470, 20.0)), axis=-1).reshape(-1, 2)
    optics = SpadOptics(spad_map(6), np.array([424.0, 240.0]), 250.0, RADIUS_PX)
    model = Model(optics, SplineBasis.covering(*field.T, RADIUS_PX, FLOOD_STEP * RADIUS_PX), 9)
    values = optics.nominal()
    values[:8] = [0.02, 0.41, 0.01, -0.03, -0.015, 0.42, 0.01, -0.02]
    prior = model.nominal(values, np.full(9, 3.0))
    truth = prior.copy()
    truth[8:] += 0.3 * rng.normal(size=len(prior) - 8) * model.spread[8:]
    inside = field[(np.abs(field - [424, 240]) < [220, 220]).all(axis=1)]
    xy = inside[rng.permutation(len(inside))[:70]]
    seen = model.maps(truth, *xy.T)[0] + 0.004 * rng.normal(size=(9, 70))
    return model, truth, field, fit(model, prior, prior, None, xy, seen, np.zeros_like(seen), 4)


def test_slopes_are_differences_of_maps(known):
    model, truth, field, _ = known
    xy = field[::17]
    kept = np.ones((9, len(xy)), bool)
    # Scattered light follows the other unknowns too, which the slopes leave out but for the gains.
    there, (gains, scattered, flood) = truth.copy(), model.start
    there[scattered:flood] = 0
    slope = model.rows(there, *xy.T, kept).slope.toarray()
    for i in (8, 13, SIZE, SIZE + 20, SIZE + 100, gains, gains + 4, gains + 9, gains + 10, gains + 40, gains + 41):
        step = np.zeros(len(there))
        step[i] = 1e-5
        ends = [model.maps(there + sign * step, *xy.T)[0] for sign in (1, -1)]
        change = (ends[0] - ends[1]).ravel() / 2e-5
        assert slope[:, i] == pytest.approx(change, abs=0.05 * np.abs(change).max() + 2e-3)


def test_maps_come_back_within_their_errors(known):
    model, truth, field, found = known
    expected, kept = found.expected(field)
    full = model.maps(truth, *field.T)[0]
    cosine = (expected * full).sum(axis=1) / np.linalg.norm(expected, axis=1) / np.linalg.norm(full, axis=1)
    assert cosine.min() > 0.95
    some = np.zeros(len(field), bool)
    some[::3] = True
    kept = kept & some
    rows = model.rows(found.unknown, *field.T, kept)
    sigma = np.sqrt(np.diag(found.covariance(rows, field)))
    within = np.abs(full[kept] - expected[kept]) < 2 * sigma
    assert within.mean() > 0.85


def test_a_sample_is_predicted_where_it_was_taken(known):
    _, _, _, found = known
    again, kept = found.expected(found.xy)
    assert np.abs(again - found.seen)[kept].mean() < 0.01


def covariance_of(found):
    """(N, N) of the samples, errors included, as the model has it."""
    rows, reach, radius = found.rows, REACH * RADIUS_PX, RADIUS_PX
    slope, spread = rows.slope.toarray(), found.model.spread
    scaled = cdist(found.xy, found.xy)[rows.cell][:, rows.cell] * np.sqrt(3) / reach
    texture, own, gain, jitter = found.strengths
    value, near = np.minimum(rows.value, 1), np.minimum(rows.near, 1)
    zones = rows.zone[:, None] == rows.zone
    apart = texture**2 * np.outer(value, value) + own**2 * np.sqrt(np.outer(near, near)) * zones
    true = slope @ np.diag(spread**2) @ slope.T + (1 + scaled) * np.exp(-scaled) * apart
    shared = gain**2 * np.outer(value, value) + (jitter * radius) ** 2 * rows.tilt @ rows.tilt.T
    alone = (RELATIVE * np.maximum(rows.value, found.seen[rows.zone, rows.cell])) ** 2 + FLOOR**2
    return true + shared * (rows.cell[:, None] == rows.cell) + np.diag(alone)


def test_candour_is_that_of_leaving_samples_out(known):
    found = known[3]
    rows = found.rows
    covariance = covariance_of(found)
    y = found.seen[rows.zone, rows.cell] - rows.value + rows.slope @ (found.unknown - found.prior)
    error, stated = np.empty(len(y)), np.empty(len(y))
    for cell in np.unique(rows.cell):
        out = rows.cell == cell
        gain = np.linalg.solve(covariance[np.ix_(~out, ~out)], covariance[np.ix_(~out, out)]).T
        error[out] = (y[out] - gain @ y[~out]) ** 2
        stated[out] = np.diag(covariance[np.ix_(out, out)] - gain @ covariance[np.ix_(~out, out)])
    belief = BELIEF * stated.mean()
    overall = (error.sum() + belief) / (stated.sum() + belief)
    for p in range(9):
        mine = rows.zone == p
        expected = (error[mine].sum() + belief * overall) / (stated[mine].sum() + belief)
        assert found.candour[p] == pytest.approx(max(expected, LEAST_CANDOUR), rel=1e-3)


def test_what_is_overlooked_lies_where_no_sample_is_near(known):
    model, _, _, found = known
    rows = model.rows(found.unknown, *found.xy[:3].T, np.ones((9, 3), bool))
    assert np.abs(found.overlooked(rows, found.xy[:3])).max() < 1e-12
    covariance = found.overlooked(rows, found.xy[:3] + np.array([1000, 0]))
    assert np.linalg.eigvalsh(covariance).min() > -1e-12
    assert not covariance[rows.zone[:, None] != rows.zone].any()
    bright = np.clip(np.maximum(rows.value, rows.near), 0, 1)
    assert np.diag(covariance) == pytest.approx(OVERLOOKED**2 * bright)


@pytest.mark.slow
def test_errors_that_zones_share_are_found(known):
    model, truth, field, _ = known
    rng = np.random.default_rng(6)
    xy = field[(np.abs(field - [424, 240]) < [200, 200]).all(axis=1)][::2]
    moved = xy + rng.normal(0, 0.1 * RADIUS_PX, xy.shape)
    still, shaken = (model.maps(truth, *points.T)[0] for points in (xy, moved))
    dimmed = still * rng.normal(1, 0.06, len(xy))
    strengths = []
    for seen in (still, shaken, dimmed):
        found = fit(model, truth, truth, None, xy, seen, np.zeros_like(seen), 0)
        for _ in range(6):
            found = fit(model, truth, truth, found.strengths, xy, seen, np.zeros_like(seen), 0)
        strengths.append(found.strengths[2:])
    assert max(strengths[0]) < 0.02
    assert strengths[1][1] == pytest.approx(0.1, rel=0.3)
    assert strengths[2][0] == pytest.approx(0.06, rel=0.3)


def test_the_texture_does_not_take_the_place_of_the_optics(known):
    model, truth, field, _ = known
    rng = np.random.default_rng(7)
    xy = field[(np.abs(field - [424, 240]) < [200, 200]).all(axis=1)][::4]
    seen = model.maps(truth, *xy.T)[0] * np.exp(rng.normal(0, 0.5, len(xy)))
    found = fit(model, truth, truth, None, xy, seen, np.zeros_like(seen), 0)
    for _ in range(4):
        found = fit(model, truth, truth, found.strengths, xy, seen, np.zeros_like(seen), 0)
    assert found.strengths[0] == pytest.approx(MOST[0])
    assert (found.strengths <= np.array(MOST) + 1e-12).all()


def test_tilts_are_differences_of_maps(known):
    model, truth, field, _ = known
    xy = field[::17]
    tilt = model.rows(truth, *xy.T, np.ones((9, len(xy)), bool)).tilt
    for i, step in enumerate(([0.5, 0], [0, 0.5])):
        change = model.maps(truth, *(xy + step).T)[0] - model.maps(truth, *(xy - step).T)[0]
        assert tilt[:, i] == pytest.approx(change.ravel(), abs=0.05 * np.abs(change).max())
