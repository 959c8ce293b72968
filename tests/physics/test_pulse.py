"""Bin integrals against quadrature of the density, and against an independent nominal model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.interpolate import griddata

from physics.pulse import ImpulseResponse, arrival, tailed_pulse
from recordings.refusal import Refusal

RISE, FALL, TAIL, SHARE = 50e-12, 130e-12, 330e-12, 0.15
PULSE = tailed_pulse(RISE, FALL, TAIL, SHARE, step_s=1e-12)
WIDTH = 92.5e-12


def density(time_s: float) -> float:
    """Two half Gaussians of one height, and the same again after an exponential delay, integrated over delays."""

    def core(t):
        return np.exp(-0.5 * (t / (RISE if t < 0 else FALL)) ** 2) / ((RISE + FALL) * np.sqrt(np.pi / 2))

    delayed = (
        quad(
            lambda delay: core(time_s - delay) * np.exp(-delay / TAIL) / TAIL,
            0,
            time_s + 6 * RISE + 1e-15,
            points=[max(time_s, 0)],
            epsabs=1e3,
        )[0]
        if time_s > -6 * RISE
        else 0.0
    )
    return (1 - SHARE) * core(time_s) + SHARE * delayed


@pytest.mark.parametrize("arrival_bins", [20.0, 20.37, 20.81])
def test_bins_hold_the_integral_of_the_pulse(arrival_bins):
    got = PULSE.in_bins(arrival_bins * WIDTH, 128, WIDTH)
    for bin_ in (17, 19, 20, 21, 24, 40):
        edges = (np.array([bin_, bin_ + 1]) - arrival_bins) * WIDTH
        expected = quad(density, *edges, points=[np.clip(0, *edges)], epsabs=1e-6)[0]
        assert got[bin_] == pytest.approx(expected, abs=5e-4 * got.max())


@given(st.floats(5, 60), st.integers(1, 20))
def test_photons_are_kept_and_move_with_the_arrival(arrival_bins, later):
    here, there = PULSE.in_bins(np.array([arrival_bins, arrival_bins + later]) * WIDTH, 200, WIDTH)
    assert here.sum() == pytest.approx(1, abs=1e-9)
    assert (here >= 0).all()
    assert there[later:] == pytest.approx(here[:-later], abs=1e-9)


def test_pulse_outside_the_bins_is_lost():
    assert PULSE.in_bins(np.array(-100 * WIDTH), 128, WIDTH).sum() == pytest.approx(0, abs=1e-9)
    assert PULSE.in_bins(np.array(200 * WIDTH), 128, WIDTH).sum() == 0


def test_steps_are_centred_at_their_times():
    """One step of probability 1 at time 0, as wide as a bin, arriving at a bin's centre fills that bin."""
    pulse = ImpulseResponse(np.array([-1.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]))
    assert pulse.in_bins(np.array(2.5), 5, 1.0).tolist() == [0, 0, 1, 0, 0]
    assert pulse.in_bins(np.array(2.75), 5, 1.0).tolist() == [0, 0, 0.75, 0.25, 0]


def test_shape_follows_arrivals():
    assert PULSE.in_bins(np.zeros((2, 3)), 7, WIDTH).shape == (2, 3, 7)


def test_arrival_is_there_and_back():
    assert arrival(np.array([0.0, 1.0]), 2e-9) == pytest.approx([2e-9, 2e-9 + 6.671282e-9])


@pytest.mark.parametrize("wrong", [{"rise_s": 0.0}, {"tail_share": 1.5}, {"step_s": -1e-12}])
def test_impossible_pulses_are_refused(wrong):
    numbers = {"rise_s": RISE, "fall_s": FALL, "tail_s": TAIL, "tail_share": SHARE, "step_s": 1e-12} | wrong
    with pytest.raises(Refusal, match="expected positive times"):
        tailed_pulse(**numbers)


def test_nominal_model_of_an_independent_implementation(shared_data, published_maps):
    """One frame of the conformance recording, cell by cell, with these bin integrals."""
    seen = np.load(shared_data / "conformance" / "recording.npz")
    expected = np.load(shared_data / "conformance" / "expected.npz")
    published = published_maps / "spad_calib_3x3_longrange_bins15_35.npz"
    maps = np.load(published)
    width, height = seen["image_size"]
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    points = np.column_stack([maps["xs"], maps["ys"]])
    full = ((u + 0.5) * 848 / width - 0.5, (v + 0.5) * 480 / height - 0.5)
    weight = griddata(points, maps["responses"].reshape(9, -1).T.astype(float), full, fill_value=0)
    frame = 3
    ray = np.linalg.inv(seen["intrinsics"]) @ np.stack([u, v, np.ones_like(u)]).reshape(3, -1)
    range_m = np.linalg.norm(ray, axis=0) * seen["depth_m"][frame].ravel()
    light = (seen["reflectance"][frame] * seen["incidence_cosine"][frame]).ravel() / range_m**2
    pulse = ImpulseResponse(seen["irf_time_s"], seen["irf"])
    bins = pulse.in_bins(arrival(range_m, seen["time_zero_s"]), 128, float(seen["bin_width_s"]))
    signal = float(expected["gain"]) * (weight.reshape(-1, 9) / weight.max()).T * light @ bins
    got = signal + seen["background_counts"][:, None]
    assert got == pytest.approx(expected["expected"][frame], rel=1e-5)


@pytest.mark.parametrize("most", [1e-3, 1e-6])
def test_ends_that_hold_next_to_nothing_are_cut_off_and_no_more(most):
    pulse = tailed_pulse(RISE, FALL, TAIL, SHARE, 2e-12)
    short = pulse.without_ends(most)
    assert short.probability.sum() == pytest.approx(pulse.probability.sum(), rel=1e-12)
    inner = (pulse.edges >= short.edges[0] - 1e-15) & (pulse.edges <= short.edges[-1] + 1e-15)
    kept = pulse.edge_cumulative[inner]
    assert kept[0] <= most < kept[1]
    assert pulse.edge_cumulative[-1] - kept[-1] <= most < pulse.edge_cumulative[-1] - kept[-2]
    np.testing.assert_allclose(short.cumulative(pulse.edges), pulse.edge_cumulative, atol=2 * most)


@pytest.mark.parametrize("step_s", [3.7e-12, 8e-12, 41e-12])
def test_in_wider_steps_as_much_has_come_by_each_edge_and_on_average_at_the_same_time(step_s):
    pulse = tailed_pulse(RISE, FALL, TAIL, SHARE, 2e-12)
    wider = pulse.in_steps(step_s)
    assert wider.step_s == pytest.approx(step_s)
    assert wider.edges[0] == pytest.approx(pulse.edges[0])
    assert wider.edges[-1] > pulse.edges[-1] - step_s * 1e-6
    for edge, until in zip(wider.edges, wider.edge_cumulative, strict=True):
        assert until == pytest.approx(pulse.probability[pulse.time_s < edge].sum(), abs=1.1 * pulse.probability.max())
    means = [(of.time_s * of.probability).sum() for of in (pulse, wider)]
    assert means[1] == pytest.approx(means[0], abs=step_s**2 / TAIL)
