"""What zones see, as tables of light by range that tests make up."""

import numpy as np

from fusion.zone_view import GOOD, ZoneDepths

RANGE_M = np.arange(1, 151) * 0.04


def zone_view(light, level=1.0, state=None):
    """Light (P, B) as if it had been found, with one surface where there is any."""
    light = np.asarray(light, float)
    zones = len(light)
    one = np.where(light.any(axis=1), 1.0, np.nan)[:, None]
    state = np.full(zones, GOOD, np.uint8) if state is None else np.asarray(state, np.uint8)
    return ZoneDepths(RANGE_M, light, np.full(zones, level), one, one, one, one, np.zeros(zones), state)
