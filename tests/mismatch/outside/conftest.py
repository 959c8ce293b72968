"""A scene for causes outside the library, and what they make of it."""

import numpy as np
import pytest

from mismatch.outside.causes import all_outside
from physics.clock import Clock
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import tailed_pulse

from ..conftest import BACKGROUND, BINS, INTRINSICS, WIDTH_S, depths

CAUSES = all_outside()
FRAMES = 6


@pytest.fixture(scope="module")
def scene(maps):
    """A model without effects, and what it starts from."""
    light = direct_light(depths(FRAMES), INTRINSICS, time_s=np.arange(FRAMES) / 15)
    pulse = tailed_pulse(0.2e-9, 0.3e-9, 0.4e-9, 0.1, step_s=WIDTH_S / 16)
    clock = Clock(WIDTH_S, BINS, np.full(4, 2e-9), pulse)
    model = ForwardModel(light, footprints(maps, light.range_m.shape[1:]), clock, BACKGROUND)
    return model, light, clock


def changed(model, name, **values):
    """Counts at a gain of 1000 with a cause."""
    return model.expected(1000.0, (CAUSES[name].at(**values),))
