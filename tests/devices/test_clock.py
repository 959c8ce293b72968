"""Clocks against simulated arrivals whose truth is known; the envelope against linear programming."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from devices.clock import BLOCKS, DeviceClock, Relation, between, unwrapped
from devices.envelope import MOST_POINTS, Block, lower_hull, posterior
from recordings.refusal import Refusal

START = 1.79e9  # seconds since the epoch, where a double resolves 0.24 us


def polled(interval_s):
    """Arrivals at the next poll of a host controller, after a jitter of the device."""

    def delay(sent, rng):
        ready = sent + rng.uniform(50e-6, 150e-6, sent.size)
        return np.ceil(ready / interval_s) * interval_s - sent - 50e-6

    return delay


def bursts(sent, rng):
    busy = np.repeat(rng.random(sent.size // 10 + 1) < 0.3, 10)[: sent.size]
    return rng.exponential(2e-4, sent.size) + busy * rng.uniform(2e-3, 2e-2, sent.size)


DELAYS = {
    "exponential": lambda sent, rng: rng.exponential(2e-3, sent.size),
    "gamma": lambda sent, rng: rng.gamma(2, 1e-3, sent.size),
    "lognormal": lambda sent, rng: rng.lognormal(np.log(1e-3), 1, sent.size),
    "pareto": lambda sent, rng: 1e-3 * rng.pareto(1.5, sent.size),
    "polled each 1 ms": polled(1e-3),
    "polled each 125 us": polled(125e-6),
    "bursts": bursts,
}


def simulated(delay, count, rate_hz, rng, window_s=120.0):
    """A clock that heard `count` messages, its truth (host's time of the device's 0, rate) and the last device time."""
    rate = 1 + rng.uniform(-0.03, 0.03)
    device = np.arange(count) / rate_hz * (1 + rng.uniform(-0.02, 0.02)) + rng.uniform(0, 1)
    sent = 1000 + rate * device
    clock = DeviceClock("LiDAR", window_s, latency_s=(0.0, 0.0))
    for stamp, arrival in zip(device, sent + delay(sent, rng), strict=True):
        clock.heard(stamp, START + arrival)
    return clock, START + 1000, rate, device[-1]


@pytest.mark.parametrize("kind", DELAYS)
def test_errors_are_as_large_as_said(kind):
    rng = np.random.default_rng(11)
    errors, sigmas = [], []
    for _ in range(20):
        clock, zero, rate, last = simulated(DELAYS[kind], 200, 5, rng)
        relation = clock.relation()
        for at in (last - 20, last):
            host, sigma = relation.host(at)
            errors.append(host - zero - rate * at)
            sigmas.append(sigma)
    errors, sigmas = np.array(errors), np.array(sigmas)
    assert np.mean(np.abs(errors) < 2 * sigmas) >= 0.84
    # And no larger: not a bound, but a deviation.
    assert np.median(sigmas) < 2.5 * np.sqrt(np.mean(errors**2))
    assert np.mean(np.abs(errors) < 0.2 * sigmas) < 0.5


def test_more_messages_are_more_certain():
    rng = np.random.default_rng(3)
    few, many = (simulated(DELAYS["exponential"], n, 10, rng)[0].relation() for n in (30, 1000))
    assert many.host(3.0)[1] < few.host(3.0)[1] / 5


def test_the_line_is_that_of_linear_programming_where_delays_vanish():
    # Moon, Skelly and Towsley's program: the highest line under all points, by its mean.
    rng = np.random.default_rng(8)
    x = np.sort(rng.uniform(0, 100, 400))
    y = 0.5 + 2e-4 * x + rng.exponential(1e-3, x.size)
    block = [Block(i) for i in range(20)]
    for px, py in zip(x, y, strict=True):
        block[int(px // 5)].add(px, py)
    middle, (value, slope), covariance = posterior(block)
    program = linprog([-x.size, -x.sum()], A_ub=np.stack([np.ones_like(x), x], 1), b_ub=y, bounds=[(None, None)] * 2)
    top, rise = program.x
    sigma = math.sqrt(covariance[0, 0])
    assert abs(value - (top + rise * middle)) < 4 * sigma < 1e-4
    assert abs(slope - rise) < 6 * math.sqrt(covariance[1, 1])
    assert value < top + rise * middle  # the true line is below all points


def test_memory_does_not_grow():
    rng = np.random.default_rng(1)
    clock = DeviceClock("camera", window_s=10.0)
    for k in range(6000):
        # A rate that wanders, so that the points lie on an arc and many are corners.
        clock.heard(k / 30, START + k / 30 + 1e-9 * k**2 + rng.exponential(1e-6))
    assert len(clock._blocks) <= 2 * BLOCKS
    assert max(len(block.hull) for block in clock._blocks) <= MOST_POINTS
    assert clock._blocks[0].index * clock._block_s >= 6000 / 30 - 11


def test_a_wandering_clock_is_followed():
    rng = np.random.default_rng(2)
    device = np.arange(0, 600, 0.1)
    # An RC oscillator that warms up: 1 % in time constants of ten minutes.
    host = device + 6.0 * (1 - np.exp(-device / 600))
    clock = DeviceClock("LiDAR", window_s=2.0, latency_s=(0.0, 0.0))
    for d, h in zip(device, host + rng.exponential(2e-4, device.size), strict=True):
        clock.heard(d, h)
    estimate, _ = clock.relation().host(device[-1])
    assert abs(estimate - host[-1]) < 1e-4


def test_what_arrivals_cannot_tell_is_told_apart():
    rng = np.random.default_rng(4)
    device = np.arange(0, 60, 0.1)
    for latency_s, expected in (((0.0, math.inf), math.inf), ((2e-3, 6e-3), 2e-3), ((5e-3, 5e-3), 0.0)):
        clock = DeviceClock("LiDAR", latency_s=latency_s)
        for d, late in zip(device, 5e-3 + rng.exponential(1e-3, device.size), strict=True):
            clock.heard(d, START + d + late)
        relation = clock.relation()
        assert relation.systematic_s == pytest.approx(expected)
        host, sigma = relation.host(30.0)
        assert abs(host - (START + 30.0)) <= min(expected, 5e-3) + 4 * sigma


@pytest.mark.parametrize("skew", [0.0, 2e-6, 2e-5])
def test_a_polling_interval_in_step_with_the_messages_is_within_what_is_said(skew):
    rng = np.random.default_rng(13)
    device = np.arange(0, 60, 0.1) + 0.3e-3
    sent = 1000 + (1 + skew) * device
    clock = DeviceClock("LiDAR", latency_s=(-1e-3, 1e-3))
    for d, late in zip(device, polled(1e-3)(sent, rng), strict=True):
        clock.heard(d, START + d * (1 + skew) + 1000 + late)
    relation = clock.relation()
    for at in (10.0, 30.0, 59.0):
        host, sigma = relation.host(at)
        assert abs(host - (START + 1000 + at * (1 + skew))) < relation.systematic_s + 4 * sigma + 1e-6


def test_asking_for_the_time_bounds_the_latency():
    rng = np.random.default_rng(6)
    clock = DeviceClock("camera")
    for d in np.arange(0, 60, 0.1):
        clock.heard(d, START + d + 20e-3 + rng.exponential(1e-3))
        if int(d * 10) % 10 == 0:
            there, back = rng.uniform(0.2e-3, 2e-3, 2)
            clock.asked(START + d - there, d, START + d + back)
    relation = clock.relation()
    host, sigma = relation.host(30.0)
    assert relation.systematic_s < 1e-3
    assert abs(host - (START + 30.0)) < relation.systematic_s + 4 * sigma


def test_offsets_between_two_devices():
    rng = np.random.default_rng(9)
    camera, lidar = DeviceClock("camera", latency_s=(0, 1e-3)), DeviceClock("LiDAR", latency_s=(0, 4e-3))
    for k in range(600):
        camera.heard(7 + k / 30, START + k / 30 * 1.00002 + 0.5e-3 + rng.exponential(5e-4))
        lidar.heard(100 + k / 5 * 1.02, START + k / 5 + 2e-3 + rng.exponential(5e-4))
    apart = between(camera.relation(), lidar.relation(), START + 18.0)
    truth = (7 + 18 / 1.00002) - (100 + 18 * 1.02)
    assert abs(apart.offset_s - truth) < 5 * apart.sigma_s < 1e-3
    assert apart.systematic_s == pytest.approx(0.5e-3 + 2e-3 * 1.0)


def test_there_and_back_again():
    relation = Relation(5.0, START, 0.02, ((1e-10, 0.0), (0.0, 1e-14)), 0.0)
    device, sigma = relation.device(relation.host(17.5)[0])
    assert device == pytest.approx(17.5)
    assert sigma == pytest.approx(math.sqrt(1e-10 + 12.5**2 * 1e-14) / 1.02)


def test_too_little_is_refused_and_messages_without_a_stamp_are_passed_over():
    clock = DeviceClock("LiDAR")
    for k in range(50):
        clock.heard(math.nan, START + k)
    with pytest.raises(Refusal, match="clock of the LiDAR was heard 0 times, expected at least"):
        clock.relation()


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.floats(-20, 20))
def test_a_counter_is_unwrapped_to_the_nearest_turn(ticks, off):
    period = 100.0
    truth = ticks * 0.37
    assert unwrapped(truth % period, period, truth + off) == pytest.approx(truth, abs=1e-6)


@settings(max_examples=30)
@given(st.lists(st.tuples(st.integers(0, 12), st.integers(-9, 9)), min_size=1, max_size=14))
def test_the_hull_is_below_all_points(points):
    points = [(float(x), float(y)) for x, y in points]
    hull = lower_hull(points)
    assert {hull[0][0], hull[-1][0]} == {min(points)[0], max(points)[0]}
    assert set(hull) <= set(points)
    for (x0, y0), (x1, y1) in itertools.pairwise(hull):
        for x, y in points:
            if x0 <= x <= x1:
                assert (y - y0) * (x1 - x0) >= (y1 - y0) * (x - x0)
