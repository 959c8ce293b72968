"""Surfaces that are farther, or nearer, than the camera has them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from physics.light import Light, Return

# Nothing comes nearer than this part of the camera's range.
LEAST = 0.1


def farther(light: Light, times: Callable[[np.ndarray], np.ndarray]) -> Light:
    """Light of surfaces so many times as far, dimmer by the inverse square. times: of ranges (F, H, W), metres."""
    ways = []
    for way in light.returns:
        far = np.maximum(times(way.range_m), LEAST).astype(np.float32)
        ways.append(Return(way.range_m * far, way.strength / far**2))
    return replace(light, returns=tuple(ways))
