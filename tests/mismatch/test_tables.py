"""Goodness of fit: honest where nothing is wrong, and awake where something is."""

import numpy as np
import pytest
from scipy.stats import kstest

from mismatch.directions import Directions
from mismatch.fit import fit_nominal
from mismatch.tables import Division, divisions, table, tables


def misfit_p_value(found):
    """Of the worst table, corrected for how many there are."""
    return min(1.0, len(found) * min(one.p_value for one in found))


def looked(simulation):
    return tables(simulation, fit_nominal(simulation))


def test_every_division_puts_every_cell_into_one_group(drawn, rig):
    simulation = drawn(1)
    found = divisions(simulation, rig.expected())
    assert len({division.axes for division in found}) == len(found)
    for division in found:
        assert division.group.shape == simulation.counts.shape
        assert division.group.min() >= 0


def test_groups_of_zone_and_bin_are_zones_and_bins(drawn, rig):
    simulation = drawn(1)
    found = {d.axes: d.group for d in divisions(simulation, rig.expected())}
    group = found["zone", "bin"]
    assert (group == group[0]).all()
    assert len(np.unique(group)) == 4 * 48


def test_excess_and_noise_are_sums_of_the_cells_of_a_group(drawn):
    simulation = drawn(2)
    fitted = fit_nominal(simulation)
    table = next(t for t in tables(simulation, fitted) if t.division.axes == ("zone", "bin"))
    # One gain is fitted to all cells: what its projection moves in one group is little.
    np.testing.assert_allclose(table.noise**2, fitted.expected.sum(axis=0).ravel(), rtol=1e-9)
    excess = (simulation.counts - fitted.expected).sum(axis=0).ravel()
    np.testing.assert_allclose(table.excess, excess, atol=0.05 * table.noise.max())


def test_noise_alone_is_not_a_misfit(drawn):
    found = [misfit_p_value(looked(drawn([3, seed]))) for seed in range(15)]
    assert min(found) > 1e-3
    assert np.median(found) > 0.1


@pytest.mark.parametrize("axes", [("zone", "bin"), ("frame", "zone"), ("signal", "aligned")])
def test_a_hidden_bin_that_is_half_deaf_is_seen(rig, simulated, axes):
    mean = rig.expected().copy()
    zone, bin_ = 1, int(mean[:, 1].sum(axis=0).argmax())
    mean[:, zone, bin_] *= 0.5
    found = looked(simulated(np.random.default_rng(4).poisson(mean)))
    assert misfit_p_value(found) < 1e-9
    table = next(t for t in found if t.division.axes == ("zone", "bin"))
    worst = int((table.excess / np.maximum(table.noise, 1)).argmin())
    assert worst == table.division.group[0, zone, bin_]
    assert next(t for t in found if t.division.axes == axes).p_value < 1e-3


def test_one_frame_that_one_zone_missed_is_seen(rig, simulated):
    mean = rig.expected().copy()
    mean[11, 2] *= 0.7
    found = looked(simulated(np.random.default_rng(5).poisson(mean)))
    assert next(t for t in found if t.division.axes == ("frame", "zone")).p_value < 1e-6


@pytest.mark.slow
def test_p_values_are_uniform_or_larger_where_nothing_is_wrong(drawn):
    draws = [looked(drawn([6, seed])) for seed in range(100)]
    for i, first in enumerate(draws[0]):
        # "greater": whether small p-values are more frequent than they say. They may be rarer: each is the better of
        # two looks at twice its price.
        p_values = np.array([found[i].p_value for found in draws])
        assert kstest(p_values, "uniform", alternative="greater").pvalue > 1e-4, first.division.axes
        excess = np.array([found[i].chi2 - found[i].expected for found in draws])
        spread = excess.std() / np.sqrt(len(excess))
        assert abs(excess.mean()) < 4 * spread + 1.0, first.division.axes
    overall = np.array([misfit_p_value(found) for found in draws])
    assert (overall < 0.05).sum() <= 12


def test_a_group_that_counted_nothing_is_as_likely_as_poissons_law_has_it():
    division = Division(("bin",), np.zeros((1, 1, 4), int))
    # What a projection leaves of four empty cells, less than nothing by its rounding.
    found = table(division, np.full(4, -2.0 - 1e-7), np.full(4, 2.0), Directions(np.zeros((1, 4)), None), np.ones(4))
    assert found.p_value == pytest.approx(min(1.0, 2 * 2 * np.exp(-8)), rel=0.05)


def test_what_a_fit_of_many_parameters_takes_up_is_told_from_what_it_could_not():
    """Forty directions, of which sums over twenty groups hold a part: oracle are draws of normal noise."""
    rng = np.random.default_rng(6)
    mean = rng.uniform(20, 60, 2000)
    group = rng.integers(0, 20, 2000)
    smooth = np.eye(20)[group][:, :10] + rng.normal(0, 0.2, (2000, 10))
    own, _ = np.linalg.qr(np.hstack([smooth, rng.normal(size=(2000, 30))]))
    division = Division(("bin",), group.reshape(1, 1, -1))
    found = []
    for _ in range(400):
        white = rng.normal(size=2000)
        residual = (white - own @ (own.T @ white)) * np.sqrt(mean)
        found.append(table(division, residual, mean, Directions(own.T, None), 1 / np.sqrt(mean)))
    chi2 = np.array([one.chi2 for one in found])
    assert found[0].expected == pytest.approx(chi2.mean(), abs=4 * chi2.std() / 20)
    assert found[0].expected < 19
    assert np.quantile([one.p_value for one in found], 0.01) > 0.002
