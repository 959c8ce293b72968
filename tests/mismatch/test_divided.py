"""Values that each zone, bin or edge has for itself: fast derivatives and scores against one value moved at a time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import issparse

from mismatch.derivatives import derivatives, expected_at
from mismatch.fit import fit, fit_nominal
from mismatch.form import all_forms
from mismatch.leftover import what_is_left
from mismatch.projection import Projection
from mismatch.score import change_to, score, score_by, start_of
from mismatch.simulation import Simulation
from physics.clock import Clock
from physics.effects import find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.pulse import tailed_pulse
from recordings.maps import ResponseMaps

ZONES, BINS = 4, 24
GAIN = 3e4
OWN = [
    ("zone_gain", "factor"),
    ("bin_nonlinearity", "edge"),
    ("time_zero_offset", "delay"),
    ("bin_nonlinearity", "zone_width"),
    ("bin_nonlinearity", "zone_edge"),
]


def recorded(effects=(), noise=True):
    """12 frames of 6 × 10 pixels that come and go, 4 zones of 24 bins."""
    rng = np.random.default_rng(1)
    x, y = (rng.uniform(*ends, 120) for ends in ((0, 847), (0, 479)))
    centres = [(250, 150), (600, 160), (260, 330), (580, 340)]
    blobs = np.stack([np.exp(-(((x - cx) / 120) ** 2) - ((y - cy) / 90) ** 2) for cx, cy in centres])
    maps = ResponseMaps(1e5 * blobs.reshape(2, 2, -1), x, y, np.arange(120).astype(str))
    depth = rng.uniform(0.3, 0.6, (1, 6, 10)) + 0.4 * rng.uniform(size=(12, 1, 1))
    light = direct_light(depth, np.array([[7.5, 0, 4.5], [0, 7.5, 2.5], [0, 0, 1]]), None, np.ones_like(depth))
    width = 0.5e-9
    clock = Clock(width, BINS, 2e-9 + np.zeros(ZONES), tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.2, width / 16))
    model = Simulation(np.zeros((12, ZONES, BINS)), light, footprints(maps, (6, 10)), clock, np.full(ZONES, 5.0),
                       np.arange(12))  # fmt: skip
    mean = model.expected(GAIN, effects)
    return replace(model, counts=rng.poisson(mean).astype(float) if noise else mean)


def the_form(name, parameter):
    forms = all_forms({"zone": ZONES, "bin": BINS})
    return next(form for form in forms if form.effect.id == name and parameter in form.own)


@pytest.mark.parametrize(("name", "parameter"), OWN)
def test_derivatives_are_those_of_each_value_by_itself(name, parameter):
    simulation, form = recorded(), the_form(name, parameter)
    x = np.concatenate([[np.log(GAIN)], np.random.default_rng(2).uniform(0.2, 1.5, form.sizes[parameter])])
    here = expected_at(simulation, (form,), x)
    found, slopes = derivatives(simulation, (form,), x, here)
    assert slopes is None
    found = found.toarray() if issparse(found) else found
    for i in range(1, len(x)):
        moved = x.copy()
        moved[i] += 1e-3
        alone = (expected_at(simulation, (form,), moved) - here).ravel() / 1e-3
        np.testing.assert_allclose(found[:, i], alone, atol=1e-6 * max(np.abs(alone).max(), 1))


@pytest.mark.parametrize("sigma", [0.0, 0.02])
@pytest.mark.parametrize(("name", "parameter"), OWN)
def test_a_score_is_that_of_all_columns_written_out(name, parameter, sigma):
    simulation, form = recorded(), the_form(name, parameter)
    fitted = fit_nominal(simulation, sigma)
    projection = Projection(simulation, fitted)
    columns = []
    for i in range(form.sizes[parameter]):
        start = np.where(np.arange(form.sizes[parameter]) == i, form.start[parameter],
                         form.effect.parameter(parameter).vanishes_at)  # fmt: skip
        alone = replace(form, start=form.start | {parameter: start})
        columns.append(change_to(simulation, fitted, alone, form.strengths).ravel())
    white = projection.whitened(np.stack(columns, axis=-1))
    kept = (white**2).sum(axis=0) > 1e-8
    best = np.linalg.lstsq(white[:, kept], projection.residual, rcond=None)[0]
    promised = score(simulation, fitted, projection, form)
    # Where a column's projection is all but nothing the two may keep different ones: none here.
    assert promised.dof == kept.sum()
    # What tells zones or bins from each other: nothing does from the gain of all where none fluctuates.
    made = white[:, kept] @ best
    np.testing.assert_allclose(white[:, kept] @ promised.amplitude[kept], made, atol=1e-5 * np.abs(made).max())
    np.testing.assert_allclose(promised.gain, ((white[:, kept] @ best) ** 2).sum(), rtol=1e-6)


def test_edges_that_are_there_are_found():
    late = 0.1 * np.random.default_rng(3).normal(size=BINS)
    simulation = recorded([find_effect("bin_nonlinearity").at(edge=late)])
    nominal, form = fit_nominal(simulation), the_form("bin_nonlinearity", "edge")
    promised = score(simulation, nominal, Projection(simulation, nominal), form)
    x = np.concatenate([nominal.x, start_of(form, promised.amplitude)])
    best = fit(simulation, (form,), x)
    error = np.sqrt(np.diag(best.covariance))[1:] * form.effect.parameter("edge").start
    away = best.settings[0].values["edge"] - late
    told = (error > 1e-6) & (error < 0.03)
    assert told.sum() > BINS / 2
    assert ((away[told] / error[told]) ** 2).sum() < told.sum() + 4 * np.sqrt(2 * told.sum())
    assert promised.gain == pytest.approx(nominal.deviance - best.deviance, rel=0.2)


def test_edges_of_each_zone_are_found_and_what_is_left_is_noise():
    """Four converters, and a fit that begins with none of them: sparse columns, a pattern, errors and what is left."""
    late = 0.15 * np.random.default_rng(3).normal(size=ZONES * BINS)
    simulation = recorded([find_effect("bin_nonlinearity").at(zone_edge=late)])
    nominal, form = fit_nominal(simulation), the_form("bin_nonlinearity", "zone_edge")
    best = fit(simulation, (form,), np.concatenate([nominal.x, form.at_start() * 0]))
    error = np.sqrt(np.diag(best.covariance))[1:] * form.effect.parameter("zone_edge").start
    away = best.settings[0].values["zone_edge"] - late
    told = (error > 1e-6) & (error < 0.03)
    assert told.sum() > ZONES * BINS / 3
    assert ((away[told] / error[told]) ** 2).sum() < told.sum() + 4 * np.sqrt(2 * told.sum())
    assert what_is_left(simulation, nominal)
    assert not what_is_left(simulation, best)
    half, written = best.of(np.arange(0, 12, 2)).columns.toarray(), best.columns.toarray()
    np.testing.assert_array_equal(half, written.reshape(12, -1, len(best.x))[::2].reshape(half.shape))


class Given:
    """A projection that has left this of every number."""

    def __init__(self, information, promised, before):
        self.divided = lambda changes, axis: (information, promised, before)


@pytest.mark.filterwarnings("error")
def test_bright_bins_beside_dark_ones_are_promised_what_each_is_due():
    form = the_form("bin_nonlinearity", "zone_edge")
    rng, count = np.random.default_rng(0), ZONES * BINS
    # Of two numbers beside each other some is common; and counts from a millionth to a million make units of each.
    common, unit = 0.4 * np.eye(count, k=1), 10 ** rng.uniform(-3, 9, count)
    information = (np.eye(count) + common + common.T) * np.outer(unit, unit)
    due = 0.01 * rng.normal(size=count) / unit.max()
    found = score_by(Given(information, information @ due, unit**2), form, np.zeros((1, 1, 1, 1)))
    np.testing.assert_allclose(found.amplitude * unit, due * unit, rtol=0, atol=1e-6 * (due * unit).std())
