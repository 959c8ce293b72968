"""What a misfit may go with, against sums written out."""

import pytest

from mismatch.covariates import covariates

from .conftest import BACKGROUND, COLUMNS, ROWS


@pytest.fixture(scope="module")
def found(drawn, rig):
    simulation = drawn(1)
    return simulation, covariates(simulation, rig.expected())


def test_signal_and_arrival_are_moments_of_the_expected_counts(found, rig):
    signal = rig.expected()[6, 2] - BACKGROUND[2]
    assert found[1].signal[6, 2] == pytest.approx(signal.sum())
    mean = sum(n * (t + 0.5) for t, n in enumerate(signal)) / signal.sum()
    assert found[1].arrival_bins[6, 2] == pytest.approx(mean)
    assert found[1].phase[6, 2] == pytest.approx(mean - int(mean))
    others = rig.expected()[6].sum() - BACKGROUND.sum() * 48 - signal.sum()
    assert found[1].neighbours[6, 2] == pytest.approx(others / signal.sum())


@pytest.mark.parametrize(("name", "image"), [("incidence", "cosine"), ("reflectance", "reflectance")])
def test_surfaces_count_by_the_light_they_return(found, name, image):
    simulation, covariate = found
    weights, light = simulation.footprints.weights, simulation.light
    total = below = 0.0
    for v in range(ROWS):
        for u in range(COLUMNS):
            share = float(weights[1, v, u]) * float(light.returns[0].strength[9, v, u])
            total += share * float(getattr(light, image)[9, v, u])
            below += share
    assert getattr(covariate, name)[9, 1] == pytest.approx(total / below, rel=1e-4)
