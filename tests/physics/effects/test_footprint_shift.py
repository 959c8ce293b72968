"""A shift against a scan whose points are shifted, and against a camera that looks aside."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from physics.effects.footprint_shift import effect
from physics.footprint import footprints
from physics.nominal import ForwardModel


@pytest.fixture
def faint(maps):
    """Maps that have fallen to nothing before the scan ends: what is beyond it does not matter."""
    off = np.maximum(np.abs(maps.xs - 420) / 380, np.abs(maps.ys - 240) / 210)
    return replace(maps, responses=maps.responses * (off < 0.7))


@settings(deadline=None, max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(x=st.floats(-100, 100), y=st.floats(-100, 100))
def test_counts_are_those_of_a_shifted_scan(small, faint, x, y):
    here = footprints(faint, (6, 10))
    scan = replace(faint, xs=faint.xs + x, ys=faint.ys + y)
    there = footprints(scan, (6, 10))
    found = ForwardModel(small.light, here, small.clock).expected(1e3, [effect.at(x=x, y=y)])
    wanted = ForwardModel(small.light, there, small.clock).expected(1e3) * there.scale / here.scale
    np.testing.assert_allclose(found, wanted, atol=1e-5 * wanted.max())


def test_a_whole_pixel_rolls_the_scene_the_other_way(small, faint):
    """Zones that look a pixel further right see what they would, had the scene moved a pixel to the left."""
    where = footprints(faint, (6, 10))
    direct = small.light.returns[0]
    rolled = replace(direct, **{n: np.roll(getattr(direct, n), -1, axis=2) for n in ("range_m", "strength")})
    aside = ForwardModel(replace(small.light, returns=(rolled,)), where, small.clock).expected(1e3)
    found = ForwardModel(small.light, where, small.clock).expected(1e3, [effect.at(x=84.8, y=0)])
    np.testing.assert_allclose(found, aside, atol=1e-5 * aside.max())


@settings(deadline=None, max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(x=st.floats(-40, 40), y=st.floats(-40, 40), turn=st.floats(-0.3, 0.3), zoom=st.floats(-0.2, 0.2))
def test_counts_are_those_of_a_scan_that_was_turned_and_enlarged(small, faint, x, y, turn, zoom):
    about = (848 - 1) / 2 + 1j * (480 - 1) / 2
    scan = about + (faint.xs + 1j * faint.ys - about) * (1 + zoom) * np.exp(1j * turn) + x + 1j * y
    here, there = footprints(faint, (6, 10)), footprints(replace(faint, xs=scan.real, ys=scan.imag), (6, 10))
    found = ForwardModel(small.light, here, small.clock).expected(1e3, [effect.at(x=x, y=y, turn=turn, zoom=zoom)])
    wanted = ForwardModel(small.light, there, small.clock).expected(1e3) * there.scale / here.scale
    np.testing.assert_allclose(found, wanted, atol=1e-5 * wanted.max())


def test_a_mount_that_slips_has_moved_by_as_much_in_each_frame(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [effect.at(x=9.0, y=-4.0, slip_x=-80.0, slip_y=60.0)])
    for i, time in enumerate((0.0, 0.1, 0.2)):
        by_now = model.expected(1e3, [effect.at(x=9.0 - 80 * time, y=-4.0 + 60 * time)])
        np.testing.assert_allclose(found[i], by_now[i], rtol=1e-9, atol=1e-9 * by_now.max())


def test_each_zone_may_be_displaced_by_its_own_amount(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    x, y = np.array([40.0, 0, -20, 9]), np.array([0.0, 30, -9, 50])
    found = model.expected(1e3, [effect.at(x=x, y=y)])
    for zone in range(4):
        alone = model.expected(1e3, [effect.at(x=x[zone], y=y[zone])])
        np.testing.assert_allclose(found[:, zone], alone[:, zone], rtol=1e-6, atol=1e-9 * alone.max())
