"""A wave of reflectance in space: its shape, and that it is found where one is."""

import numpy as np
import pytest

from physics.effects import find_effect
from physics.light import direct_light
from physics.rendering import Rendering
from physics.space_waves import NAMES, likely_waves, wave

EFFECT = find_effect("reflectance_map")


def test_along_one_axis_it_is_a_sine(small):
    """Of the first frame, whose places are where the camera has them: rays times depth."""
    light = small.light
    values = EFFECT.at(wave_sin=0.7, wave_cos=-0.2, wave_x=11.0, wave_y=0, wave_z=0).values
    depth = light.range_m[0] / np.linalg.norm(light.rays, axis=-1)
    x = np.where(light.range_m[0] > 0, depth, 0) * light.rays[..., 0]
    found = wave(values, light)[0]
    np.testing.assert_allclose(found, 0.7 * np.sin(11 * x) - 0.2 * np.cos(11 * x), atol=1e-5)


@pytest.mark.parametrize("vector", [(8.0, 0.0, 0.0), (6.0, -7.0, 0.0)])
def test_it_is_looked_for_where_it_is(approached, vector):
    model, rendering = approached
    truth = dict(zip(NAMES, vector, strict=True))
    nominal = model.expected(1e4)
    excess = model.expected(1e4, [EFFECT.at(wave_sin=0.2, wave_cos=-0.1, **truth)]) - nominal
    found = likely_waves(excess, nominal, rendering)[0]
    # Across the wall, on which all of it stands; ahead of it a wave is alike everywhere.
    across = [[one[name] for name in NAMES[:2]] for one in (found, truth)]
    apart = min(np.linalg.norm(np.subtract(across[0], side * np.array(across[1]))) for side in (1, -1))
    assert apart < 0.6 * np.linalg.norm(vector)
    EFFECT.at(wave_sin=0.1, **found)


def test_nothing_seen_nothing_found(approached):
    model, rendering = approached
    nominal = model.expected(1e4)
    with np.errstate(all="raise"):
        assert len(likely_waves(0 * nominal, nominal, rendering)) == 2
    dark = direct_light(np.full(rendering.light.range_m.shape, np.nan), rendering.light.intrinsics)
    assert likely_waves(nominal, nominal, Rendering(dark, rendering.footprints, rendering.clock, 1.0)) == []
