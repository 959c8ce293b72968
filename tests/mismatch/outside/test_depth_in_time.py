"""A depth camera whose scale changes with time, against surfaces that are moved one frame at a time."""

from dataclasses import replace

import numpy as np
import pytest

from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.rendering import Rendering

from ..conftest import BACKGROUND, INTRINSICS, depths
from .conftest import CAUSES, changed

BREATHING = CAUSES["depth_breathing"]


def moved(light, clock, maps, factor):
    """A model of the same surfaces, seen at the same angles, so many times (F,) as far."""
    depth = np.stack([times * one for times, one in zip(factor, light.range_m, strict=True)])
    depth /= np.linalg.norm(light.rays, axis=-1)
    there = direct_light(depth, INTRINSICS, cosine=light.cosine, time_s=light.time_s)
    return ForwardModel(there, footprints(maps, depth.shape[1:]), clock, BACKGROUND)


def test_surfaces_come_and_go(scene, maps):
    model, light, clock = scene
    found = changed(model, "depth_breathing", rising=0.1, sine=0.02, cosine=-0.01, rate=3.0)
    factor = [1 + 0.1 * t + 0.02 * np.sin(6 * np.pi * t) - 0.01 * np.cos(6 * np.pi * t) for t in light.time_s]
    there = moved(light, clock, maps, factor).expected(1000.0)
    # Edges of single precision.
    np.testing.assert_allclose(found, there, rtol=1e-3, atol=1e-4 * there.max())


def test_nothing_comes_nearer_than_a_tenth(scene, maps):
    model, *_ = scene
    found = changed(model, "depth_breathing", cosine=-0.2, sine=0.2, rising=-0.5, rate=1e3)
    assert np.isfinite(found).all()
    assert (found >= 0).all()


@pytest.mark.parametrize("rate", [1.1, 3.3])
def test_the_rate_is_the_one_that_counts_show(scene, maps, rate):
    _, _, clock = scene
    times = np.arange(32) / 10
    light = direct_light(depths(32), INTRINSICS, time_s=times)
    where = footprints(maps, light.range_m.shape[1:])
    model, rendering = ForwardModel(light, where, clock, BACKGROUND), Rendering(light, where, clock, 1000.0)
    there = moved(light, clock, maps, 1 + 0.003 * np.sin(2 * np.pi * rate * times + 1))
    plain = model.expected(1000.0)
    (start,) = BREATHING.starts(there.expected(1000.0) - plain, plain, rendering)
    assert start["rate"] == pytest.approx(rate, abs=0.1)
    still = replace(rendering, light=replace(light, time_s=np.zeros(32)))
    assert BREATHING.starts(plain, plain, still) == []
