"""Templates of a plane against a sum over pixels, one after the other."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.constants import speed_of_light

from calibrate.impulse.sweep import Sweep
from calibrate.ranging import plane_templates
from physics.footprint import footprints
from physics.light import direct_light
from physics.pulse import ImpulseResponse
from recordings.maps import ResponseMaps

SIDE, BINS, WIDTH_S, STEPS = 12, 40, 9e-11, 4
INTRINSICS = np.array([[9.0, 0, 5.5], [0, 9.0, 5.5], [0, 0, 1]])
ZERO_S, DELAY_S = 5e-10, np.array([0.4, -0.4]) * WIDTH_S
RESPONSES = np.array([[0.1, 0.4, 0.3, 0.2], [0.25, 0.25, 0.25, 0.25]])


@pytest.fixture(scope="module")
def sweep():
    ys, xs = np.mgrid[:SIDE, :SIDE].reshape(2, -1)
    left = (xs < SIDE // 2).astype(np.float32)
    names = np.arange(xs.size).astype(str)
    both = np.stack([left, 1 - left]).reshape(1, 2, -1)
    maps = ResponseMaps(both, xs.astype(float), ys.astype(float), names, json.dumps({"image_size": [SIDE, SIDE]}))
    light = direct_light(np.full((1, SIDE, SIDE), 0.2), INTRINSICS)
    return Sweep(light, footprints(maps, (SIDE, SIDE)), np.ones((1, 2, BINS)), WIDTH_S, ZERO_S)


def estimate(probability):
    """What `plane_templates` reads of an estimate: responses of four steps, that begin at the nominal arrival."""
    times = (np.arange(STEPS) + 0.5) * WIDTH_S / STEPS

    def response(zone):
        return ImpulseResponse(times, probability if probability.ndim == 1 else probability[zone])

    return SimpleNamespace(bin_width_s=WIDTH_S, delay_s=DELAY_S, probability=probability, response=response)


def summed(distance_m, zone, probability):
    """(T,) share by bin: each pixel's light, spread evenly over each step of the response."""
    edges, out = WIDTH_S * np.arange(BINS + 1), np.zeros(BINS)
    for v in range(SIDE):
        for u in range(SIDE):
            if (u < SIDE // 2) != (zone == 0):
                continue
            x, y = (u - 5.5) / 9, (v - 5.5) / 9
            slant = np.sqrt(1 + x * x + y * y)
            # cosine over the square of the range
            light = 1 / slant / (distance_m * slant) ** 2
            arrival = ZERO_S + DELAY_S[zone] + 2 * distance_m * slant / speed_of_light
            step = WIDTH_S / STEPS
            cumulative = np.interp(edges, arrival + step * np.arange(STEPS + 1), np.append(0, np.cumsum(probability)))
            out += light * np.diff(cumulative)
    return out / out.sum()


@pytest.mark.parametrize("probability", [RESPONSES, RESPONSES[0]], ids=["by zone", "one for all"])
def test_a_plane_is_a_sum_over_its_pixels(sweep, probability):
    distance = 0.1 + 0.002 * np.arange(40)
    made = plane_templates(sweep, estimate(probability), distance)
    for k in (0, 17, 39):
        for zone in range(2):
            own = probability if probability.ndim == 1 else probability[zone]
            np.testing.assert_allclose(made.expected[k, zone], summed(distance[k], zone, own), atol=1e-5)
    value, slope = made.at(np.array([0, 1]), np.array([0.1411, 0.1411]))
    own = probability if probability.ndim == 1 else probability[1]
    np.testing.assert_allclose(value[1], summed(0.1411, 1, own), atol=2e-3)
    difference = (summed(0.1421, 1, own) - summed(0.1401, 1, own)) / 0.002
    np.testing.assert_allclose(slope[1], difference, atol=0.06 * np.abs(difference).max())
