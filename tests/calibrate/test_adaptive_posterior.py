import numpy as np
import pytest
from scipy.spatial.distance import cdist

from calibrate.adaptive_fit import fit
from calibrate.adaptive_kernel import FLOOR, REACH, RELATIVE
from calibrate.adaptive_model import FLOOD_STEP, Model
from calibrate.adaptive_optics import SIZE, SpadOptics
from calibrate.adaptive_posterior import BELIEF
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
    slope = model.rows(truth, *xy.T, kept).slope.toarray()
    gains = model.start[0]
    for i in (8, 13, SIZE, SIZE + 20, SIZE + 100, gains, gains + 4, gains + 9, gains + 40, gains + 41):
        step = np.zeros(len(truth))
        step[i] = 1e-5
        ends = [model.maps(truth + sign * step, *xy.T)[0] for sign in (1, -1)]
        change = (ends[0] - ends[1]).ravel() / 2e-5
        # Stray light also depends on gains and weights, in the second order.
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


def test_candour_is_that_of_leaving_samples_out(known):
    model, _, _, found = known
    rows, reach = found.rows, REACH * RADIUS_PX
    slope, spread = rows.slope.toarray(), model.spread
    scaled = cdist(found.xy, found.xy)[rows.cell][:, rows.cell] * np.sqrt(3) / reach
    alike = (1 + scaled) * np.exp(-scaled)
    shared, own = found.strengths
    same = rows.zone[:, None] == rows.zone
    value, near = np.minimum(rows.value, 1), np.minimum(rows.near, 1)
    covariance = slope @ np.diag(spread**2) @ slope.T + alike * (
        shared**2 * np.outer(value, value) + own**2 * np.outer(near, near) * same
    )
    seen = found.seen[rows.zone, rows.cell]
    noise = (RELATIVE * np.maximum(rows.value, seen)) ** 2 + FLOOR**2
    y = seen - rows.value + slope @ (found.unknown - found.prior)
    errors, stated = [], []
    for i in range(len(y)):
        rest = np.arange(len(y)) != i
        gain = np.linalg.solve(covariance[np.ix_(rest, rest)] + np.diag(noise[rest]), covariance[rest, i])
        errors.append((y[i] - gain @ y[rest]) ** 2 - noise[i])
        stated.append(covariance[i, i] - gain @ covariance[rest, i])
    belief = BELIEF * np.mean(stated)
    assert found.candour == pytest.approx((sum(errors) + belief) / (sum(stated) + belief), rel=1e-3)
