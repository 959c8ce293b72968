"""What every zone registers of one surface at each of many distances, and in between."""

from dataclasses import dataclass

import numpy as np

from calibrate.impulse.estimate import ImpulseEstimate
from calibrate.impulse.sweep import Sweep
from physics.arrivals import arrivals
from physics.clock import Clock
from physics.light import direct_light
from recordings.refusal import Refusal

# So many distances are rendered at once: memory, not speed.
AT_ONCE = 32
UNEVEN = 1e-6


@dataclass(frozen=True, eq=False)
class Templates:
    """Histograms of one scene at K distances: a surface of unknown brightness, moved along the axis.

    distance_m: (K,) evenly spaced, rising, by no more than a part of a bin. expected: (K, P, T) share of the light of
    each zone that falls into each bin; each row sums to 1, or less where light falls outside the window.
    """

    distance_m: np.ndarray
    expected: np.ndarray

    def __post_init__(self) -> None:
        distance, expected = np.asarray(self.distance_m, float), np.asarray(self.expected, float)
        if expected.ndim != 3 or distance.shape != expected.shape[:1]:
            found = f"shapes {distance.shape} and {expected.shape}"
            raise Refusal(f"templates: distance_m and expected have {found}, expected (K,) and (K, P, T)")
        step = np.diff(distance)
        if len(distance) < 4 or not (step > 0).all() or np.ptp(step) > UNEVEN * distance[-1]:
            raise Refusal("templates: distance_m is not 4 or more rising, evenly spaced metres")
        if not (np.isfinite(expected).all() and (expected >= 0).all()):
            raise Refusal("templates: expected holds NaN, infinity or values below 0, expected shares of light")
        object.__setattr__(self, "distance_m", distance)
        object.__setattr__(self, "expected", expected)

    def at(self, zone: np.ndarray, distance_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(N, T) shares at distances (N,) in zones (N,), and their derivatives by distance, 1/m.

        Cubic between four neighbours (Catmull & Rom 1974), so that the derivative is continuous.
        """
        step = self.distance_m[1] - self.distance_m[0]
        place = np.clip((distance_m - self.distance_m[0]) / step, 1, len(self.distance_m) - 2 - 1e-9)
        knot = place.astype(int)
        u = (place - knot)[:, None]
        before, low, high, after = (self.expected[knot + i, zone] for i in (-1, 0, 1, 2))
        rise, fall = (high - before) / 2, (after - low) / 2
        square, cube = 3 * (high - low) - 2 * rise - fall, 2 * (low - high) + rise + fall
        value = low + u * (rise + u * (square + u * cube))
        return np.maximum(value, 0), (rise + u * (2 * square + 3 * u * cube)) / step


def plane_templates(sweep: Sweep, estimate: ImpulseEstimate, distance_m: np.ndarray) -> Templates:
    """Templates of a plane square to the optical axis at distances (K,) from the camera, for the zones of a sweep.

    The estimate says what responses and delays the zones have; the sweep, where they look and when time is zero.
    """
    height, width = sweep.light.range_m.shape[1:]
    distance_m = np.asarray(distance_m, float)
    zero = sweep.time_zero_s / sweep.bin_width_s * estimate.bin_width_s + estimate.delay_s
    zones, bins = sweep.counts.shape[1:]
    single = estimate.probability.ndim == 1
    responses = [estimate.response(zone) for zone in ([None] if single else range(zones))]
    clocks = [Clock(estimate.bin_width_s, bins, zero, response) for response in responses]
    expected = np.empty((len(distance_m), zones, bins))
    for first in range(0, len(distance_m), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        depth = np.broadcast_to(distance_m[part, None, None], (len(distance_m[part]), height, width))
        light = direct_light(depth, sweep.light.intrinsics)
        if single:
            expected[part] = arrivals(light, sweep.footprints, clocks[0]).binned()
            continue
        for zone, clock in enumerate(clocks):
            expected[part, zone] = arrivals(light, sweep.footprints, clock).binned()[:, zone]
    level = np.maximum(expected.sum(axis=2).max(axis=0), np.finfo(float).tiny)
    total = expected.sum(axis=2, keepdims=True)
    return Templates(distance_m, np.where(total > 0, expected / np.maximum(total, 1e-12 * level[:, None]), 0))
