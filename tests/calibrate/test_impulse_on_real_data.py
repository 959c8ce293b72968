"""The response of a TMF8820 from a published sweep of a plane, held against what is usually assumed."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import exponnorm, norm

from calibrate.impulse import fit_impulse
from calibrate.impulse.held_out import deviance_per_cell
from calibrate.impulse.sweep import Sweep
from recordings.files import load, maps_of

# 4000 k shots is the longest setting of the sensor; the pedestal after the pulse says the same (below).
SHOTS = 4.096e6
ZONE = 4


@pytest.fixture(scope="module")
def sweep(shared_data):
    path = shared_data / "tmf8820_plane_sweep" / "distance_data.json"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    return Sweep.of(load(path), maps_of(path), shots=SHOTS, nearest_m=0.08)


@pytest.fixture(scope="module")
def estimate(sweep):
    return fit_impulse(sweep.part(slice(0, None, 10)), fit_bin_width=True)


def test_frames_held_out_are_described_far_better_than_by_usual_shapes(sweep, estimate):
    odd = sweep.part(slice(1, None, 10))
    own = deviance_per_cell(odd, estimate, zones=[ZONE])[0]
    few = sweep.part(slice(0, None, 24))
    step = estimate.time_s[1] - estimate.time_s[0]
    edges = np.append(estimate.time_s, estimate.time_s[-1] + step) - step / 2

    def gaussian(x):
        return np.diff(norm.cdf(edges, x[0] * 1e-10, np.exp(x[1]) * 1e-10))

    def tailed(x):
        return np.diff(exponnorm.cdf(edges, np.exp(x[2] - x[1]), x[0] * 1e-10, np.exp(x[1]) * 1e-10))

    for shape, start in ((gaussian, [0.5, 0.0]), (tailed, [-0.6, -0.5, 0.0])):

        def curve(x, shape=shape):
            return (shape(x) + 1e-12) / (shape(x) + 1e-12).sum()

        def cost(x, curve=curve):
            return deviance_per_cell(few, estimate, curve(x), [ZONE])[0]

        best = minimize(cost, start, method="Nelder-Mead", options={"maxfev": 40})
        assert deviance_per_cell(odd, estimate, curve(best.x), [ZONE])[0] > 20 * own


def test_what_the_sweep_says_of_the_sensor(estimate):
    peak = estimate.time_s[np.argmax(estimate.probability)]
    above = estimate.time_s[estimate.probability > estimate.probability.max() / 2]
    assert estimate.settled
    assert 150e-12 < above[-1] - above[0] < 350e-12
    assert abs(peak) < 150e-12
    # The published fit has 73.5 bins a metre; these frames say fewer.
    assert 69 < 2 / (299_792_458 * estimate.bin_width_s) < 73
    assert np.ptp(estimate.delay_s / estimate.bin_width_s) == pytest.approx(1.6, abs=0.3)


def test_the_pedestal_after_the_pulse_tells_the_shots(sweep):
    """Where photons of the pulse use up shots, fewer are left for the room's light: how much fewer, says how many."""
    near = sweep.counts[:12, [4, 5]]
    before = near[:, :, :12].mean()
    after = near[:, :, 112:].mean()
    assert near.sum(axis=2).mean() / (1 - after / before) == pytest.approx(SHOTS, rel=0.1)
