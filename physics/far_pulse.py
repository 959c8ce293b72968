"""The pulse of a far target that depth images do not hold: how many counts, and when."""

import numpy as np
from scipy.constants import speed_of_light

from physics.curved_track import own_way
from physics.effect import Values
from physics.odometry import moved_m
from physics.pulse import longer
from physics.rendering import Rendering
from physics.walk import BETWEEN, LEVELS

# A steadier laser than this is as good as steady, and what is divided by must not vanish.
LEAST_JITTER_S = 1e-14
# What a target that stands still comes nearer by as the camera moves right, down and ahead: the cosines of where it is.
ASIDE, TOWARD = ("right", "down"), ("still_right", "still_down", "still")


def far_pulse(values: Values, rendering: Rendering) -> np.ndarray:
    """(F or 1, P, T) expected counts of it.

    values: `counts` and `apparent_range`, () or (P,), and what the effect `range_aliasing` says of them.
    """
    counts = np.atleast_1d(values["counts"])[:, None]
    if values["as_seen"]:
        seen = rendering.footprints.weights.sum(axis=(-2, -1))[..., None]
        part = seen / max(float(seen.mean()), 1e-12)
        counts = counts * (1 + values["as_seen"] * (part - 1))
    return counts * _shares(values, rendering)


def _shares(values: Values, rendering: Rendering) -> np.ndarray:
    """(F or 1, P or 1, T) shares of the pulse by bin, over the jitter: exact for a cumulative linear in steps."""
    clock, jitter = rendering.clock, max(values["jitter"], LEAST_JITTER_S)
    way_m = _way(values, rendering)[:, None]  # Frames alike are worked out once.
    ranges = np.atleast_1d(values["apparent_range"]) + (way_m if way_m.any() else way_m[:1])
    arrival_s = np.asarray(clock.time_zero_s) + 2 * ranges / speed_of_light
    after_s = np.arange(clock.bins + 1) * clock.bin_width_s - arrival_s[..., None]
    pulse = longer(clock.pulse, values["spread"])
    cumulative = (pulse.integral(after_s + jitter) - pulse.integral(after_s - jitter)) / (2 * jitter)
    # Rounding makes an empty bin's share a little less than nothing.
    return np.maximum(np.diff(np.clip(cumulative, 0, 1), axis=-1), 0)


def _way(values: Values, rendering: Rendering) -> np.ndarray:
    """(F,) metres by which it is farther than at the start."""
    toward = np.array([values[name] for name in TOWARD])
    nearer = moved_m(rendering.light) @ toward if toward.any() else 0.0  # To ask takes long.
    found = values["speed"] * rendering.light.time_s - nearer
    curved = any(values[name] for name in (*LEVELS, *BETWEEN))
    return found + own_way(values, rendering.light.time_s) if curved else found
