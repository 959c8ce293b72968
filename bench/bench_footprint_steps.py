"""What a step of a fit costs that blurs or moves maps, or lets the image lag: beside scipy, and rendering without."""

import time

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator
from scipy.ndimage import gaussian_filter

from physics.blurring import Blur
from physics.effects import find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel

from .bench_render import SMALL, clock, scene, zones

FRAMES, ROUNDS, VARIANCE_PX2 = 40, 7, 36.0


def medians(*works):
    """Processor time of each, in turn, all cores together: what else is at work delays it, and does not add to it."""
    took = []
    for turn in range(ROUNDS):
        row = []
        for work in works:
            start = time.process_time()
            work(turn)
            row.append(time.process_time() - start)
        took.append(row)
    return np.median(took[1:], axis=0)


@pytest.mark.parametrize("shape", [(480, 640), (480, 848), (482, 852)])
def test_blurred_maps(shape):
    """Nine zones, another variance in each turn, as a fit asks for them."""
    table = np.random.default_rng(0).uniform(0, 1, (9, *shape)).astype(np.float32)
    double = table.astype(float)

    def theirs(turn):
        return [gaussian_filter(zone, np.sqrt(VARIANCE_PX2 + turn), mode="reflect") for zone in double]

    mine, its = medians(lambda turn: Blur(VARIANCE_PX2 + turn)(table), theirs)
    # Away from edges, by the discrete kernel's kurtosis.
    np.testing.assert_allclose(Blur(VARIANCE_PX2)(table), theirs(0), atol=5e-3)
    print(
        f"\n9 zones of {shape[0]} x {shape[1]}: {mine * 1e3:.0f} ms, {its / mine:.1f} times as fast as scipy's filter"
    )


@pytest.mark.parametrize("zones_each", [False, True])
def test_moved_maps(zones_each):
    """Nine zones read where they have moved to, together or each elsewhere, another way in each turn."""
    maps = zones(3, 3)
    where = footprints(maps, SMALL)
    theirs_on = LinearNDInterpolator(np.stack([maps.xs, maps.ys], axis=1), maps.by_zone.T, fill_value=0)

    def way(turn):
        return np.linspace(-1, 1, 9) * (3 + turn)

    def mine(turn):
        moved = where.zones_moved(way(turn), way(turn)) if zones_each else where.moved(3.0 + turn, 2.0)
        return moved.weights

    def theirs(turn):
        if not zones_each:
            return theirs_on(where.x_px - 3 - turn, where.y_px - 2)
        return [theirs_on(where.x_px - x, where.y_px - x)[..., p] for p, x in enumerate(way(turn))]

    ours, its = medians(mine, theirs)
    what = "each elsewhere" if zones_each else "together"
    print(f"\n9 zones moved {what}: {ours * 1e3:.2f} ms; scipy's interpolation alone {its / ours:.1f} times as long")


@pytest.mark.parametrize("carried", [0.0, 1.0])
def test_a_lag(carried):
    """Frames as they are seen a moment later, a wall that comes nearer; another lag in each turn."""
    depth, intrinsics, reflectance, cosine = scene(FRAMES, SMALL)
    light = direct_light(depth, intrinsics, reflectance, cosine, time_s=np.arange(FRAMES) / 15)
    where, lag = footprints(zones(3, 3), SMALL), find_effect("time_lag")

    def work(*effects):
        # A model of its own, which has nothing kept.
        ForwardModel(light, where, clock(9), 10.0).expected(30.0, effects)

    with_lag, without = medians(lambda turn: work(lag.at(lag=0.01 + 1e-4 * turn, carried=carried)), lambda turn: work())
    how = "carried" if carried else "between frames"
    print(f"\n{FRAMES} frames with a lag, {how}: {with_lag * 1e3:.0f} ms, {with_lag / without:.0f} times that without")
