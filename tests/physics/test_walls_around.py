"""Walls around, found by how late light is while the target recedes."""

from types import SimpleNamespace

import numpy as np
import pytest

from physics.clock import Clock
from physics.light import Return
from physics.pulse import tailed_pulse
from physics.rendering import Rendering
from physics.walls_around import by_walls_around, likely_distances

C = 299_792_458.0


@pytest.mark.parametrize("distance", [0.3, 0.8, 2.0])
@pytest.mark.parametrize("pedestal", [0.0, 20.0])
def test_their_distance_is_seen_as_the_target_recedes(distance, pedestal):
    clock = Clock(0.3e-9, 128, np.array([3e-9, 3.1e-9]), tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.1, 2e-11))
    ranges = np.linspace(0.4, 2.0, 20)[:, None] * np.array([1.0, 1.05])

    def pulses(path_m, counts):
        shares = clock.pulse.in_bins(clock.time_zero_s + path_m / C, clock.bins, clock.bin_width_s)
        return counts[..., None] * shares

    direct = pulses(2 * ranges, 3e4 / ranges**2)
    far = np.hypot(ranges, 2 * distance)
    excess = pulses(ranges + far, 30 / far**2)
    start = Rendering(SimpleNamespace(frames=20), None, clock, 1.0, background=np.full((2, 1), pedestal))
    found = likely_distances(excess, direct + pedestal, start)
    assert min(abs(np.log(d / distance)) for d in found) < 0.15


def test_light_by_way_of_them_is_that_of_a_source_farther_off():
    direct = Return(np.array([[[0.0, 0.5, 2.0]]], np.float32), np.array([[[0.0, 4.0, 0.25]]], np.float32))
    found = by_walls_around(direct, 0.6)
    far = np.sqrt(np.array([0.25, 4.0]) + 1.44)
    np.testing.assert_allclose(found.strength[0, 0], [0, *(1 / far**2)], rtol=1e-6)
    np.testing.assert_allclose(2 * found.range_m[0, 0, 1:], np.array([0.5, 2.0]) + far, rtol=1e-6)
