"""A second surface against a scene that has two returns."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from physics.effects import second_surface as module
from physics.effects.second_surface import effect
from physics.footprint import footprints
from physics.light import Return, direct_light
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse
from physics.rendering import Rendering
from physics.replicas import Replica


@pytest.mark.parametrize("coarse", [False, True])
def test_it_is_a_scene_of_two_returns(small, coarse):
    """Of a response in fine steps or in coarse ones, on which light would be shared by two a whole step apart."""
    passed, spacing = 0.3, 0.25
    if coarse:
        pulse = ImpulseResponse(small.clock.bin_width_s / 2 * np.arange(4), np.array([0.2, 0.5, 0.2, 0.1]))
        small.clock = replace(small.clock, pulse=pulse)
    direct = small.light.returns[0]
    behind = direct.range_m + np.float32(spacing)
    second = passed * direct.strength * (direct.range_m / behind) ** 2
    returns = (Return(direct.range_m, (1 - passed) * direct.strength), Return(behind, second))
    found = ForwardModel(small.light, small.footprints, small.clock).expected(
        1e3, [effect.at(passed=passed, spacing=spacing)]
    )
    closed = ForwardModel(replace(small.light, returns=returns), small.footprints, small.clock).expected(1e3)
    np.testing.assert_allclose(found, closed, atol=1e-2 * closed.max())
    np.testing.assert_allclose(found.sum(axis=-1), closed.sum(axis=-1), rtol=1e-4)


def test_a_sheet_in_front_is_a_nearer_return(small):
    passed, spacing = 0.05, -0.2
    direct = small.light.returns[0]
    before = direct.range_m + np.float32(spacing)
    # Nearest pixels are at 0.3 m and its sheet at 0.1 m, where it begins to fade.
    assert np.nanmin(before) > 0.1
    first = Return(before, passed * direct.strength * (direct.range_m / before) ** 2)
    returns = (Return(direct.range_m, (1 - passed) * direct.strength), first)
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [effect.at(passed=passed, spacing=spacing)])
    closed = ForwardModel(replace(small.light, returns=returns), small.footprints, small.clock).expected(1e3)
    np.testing.assert_allclose(found, closed, atol=1e-2 * closed.max())
    np.testing.assert_allclose(found.sum(axis=-1), closed.sum(axis=-1), rtol=1e-3)
    # It comes before all else.
    early = model.expected(1e3)[1] < 1e-6
    assert found[1][early].sum() > 1


def test_a_sheet_behind_the_sensor_is_dark_and_counts_are_continuous_on_the_way_there(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    beyond = model.expected(1e3, [effect.at(passed=0.3, spacing=-3)])
    np.testing.assert_allclose(beyond, 0.7 * model.expected(1e3), rtol=1e-9)
    before = None
    for spacing in np.arange(-1.5, 0.02, 0.002):
        found = model.expected(1e3, [effect.at(passed=0.01, spacing=spacing)])
        if before is not None:
            assert np.abs(found - before).max() < 0.05 * beyond.max()
        before = found


def test_surfaces_that_touch_keep_all_photons_and_their_times(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    np.testing.assert_allclose(model.expected(1e3, [effect.at(passed=0.7, spacing=0)]), model.expected(1e3), rtol=1e-9)


def test_behind_a_clear_pane_only_the_second_is_seen(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    spacing = 3 * small.clock.bin_width_s * 299_792_458 / 2
    found, nominal = model.expected(1e3, [effect.at(passed=1, spacing=spacing)]), model.expected(1e3)
    seen = nominal[..., :-3] > 1e-3 * nominal.max()
    ratio = found[..., 3:][seen] / nominal[..., :-3][seen]
    assert (ratio > (0.3 / (0.3 + spacing)) ** 2 - 1e-3).all()
    assert (ratio < (1.7 / (1.7 + spacing)) ** 2 + 1e-3).all()


@pytest.mark.parametrize(("ratio", "falloff"), [(0.4, 0.0), (3.0, 1.0)])
def test_it_may_reflect_otherwise_and_fall_off_otherwise(small, ratio, falloff):
    passed, spacing = 0.2, 0.3
    direct = small.light.returns[0]
    behind = direct.range_m + np.float32(spacing)
    second = ratio * passed * direct.strength * (direct.range_m / behind) ** falloff
    returns = (Return(direct.range_m, (1 - passed) * direct.strength), Return(behind, second))
    closed = ForwardModel(replace(small.light, returns=returns), small.footprints, small.clock).expected(1e3)
    setting = effect.at(passed=passed, spacing=spacing, reflectance=ratio, falloff=falloff)
    found = ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [setting])
    np.testing.assert_allclose(found, closed, atol=1e-2 * closed.max())


@pytest.mark.parametrize("spacing", [0.2, -0.02])
def test_a_surface_parallel_to_the_first_is_farther_along_slanted_rays(small, spacing):
    direct, part = small.light.returns[0], 0.3
    behind = direct.range_m + np.float32(spacing) / np.maximum(small.light.cosine, 0.1)
    behind = np.where(direct.strength > 0, behind, 1).astype(np.float32)
    second = part * direct.strength * (direct.range_m / behind) ** 2
    returns = (Return(direct.range_m, (1 - part) * direct.strength), Return(behind, second.astype(np.float32)))
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [effect.at(parallel=part, spacing=spacing)])
    closed = ForwardModel(replace(small.light, returns=returns), small.footprints, small.clock).expected(1e3)
    np.testing.assert_allclose(found, closed, atol=1e-3 * closed.max())
    excess = found - (plain := model.expected(1e3))
    rendering = Rendering(small.light, small.footprints, small.clock, 1e3, background=np.ones((4, 1)))
    starts = [start for start in effect.starts(excess, plain, rendering) if "parallel" in start]
    assert min(abs(start["spacing"] - spacing) for start in starts) < 0.1


def test_panes_may_come_in_pairs(small):
    passed, spacing, beyond, again = 0.2, 0.15, 0.3, 0.5
    direct = small.light.returns[0]
    behind = [direct.range_m + np.float32(far) for far in (spacing, spacing + beyond)]
    parts = passed, passed * again
    later = [Return(r, p * direct.strength * (direct.range_m / r) ** 2) for r, p in zip(behind, parts, strict=True)]
    returns = (Return(direct.range_m, (1 - passed) * direct.strength), *later)
    closed = ForwardModel(replace(small.light, returns=returns), small.footprints, small.clock).expected(1e3)
    setting = effect.at(passed=passed, spacing=spacing, beyond=beyond, again=again)
    found = ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [setting])
    np.testing.assert_allclose(found, closed, atol=1e-2 * closed.max())


def test_it_suggests_a_third_surface_where_there_is_one(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 2.0)
    nominal = model.expected(3e5)
    rendering = Rendering(small.light, small.footprints, small.clock, 3e5, background=2.0)
    suggested = {}
    for again in (0.0, 0.5):
        truth = effect.at(passed=0.3, spacing=0.15, again=again, beyond=0.3)
        excess = np.random.default_rng(3).poisson(model.expected(3e5, [truth])) - nominal
        suggested[again] = [s for s in effect.starts(excess, nominal, rendering) if s.get("again")]
    assert any(abs(s["spacing"] - 0.15) < 0.04 and abs(s["beyond"] - 0.3) < 0.05 for s in suggested[0.5])
    assert not suggested[0.0]


def test_only_surfaces_between_two_ranges_are_covered(small):
    direct = small.light.returns[0]
    # No pixel stands where the ends are soft.
    ranges = direct.range_m
    nearest, farthest = (
        float(max(np.linspace(*ends, 200), key=lambda end: np.nanmin(np.abs(np.log(ranges / end)))))
        for ends in ((0.5, 0.7), (0.9, 1.1))
    )
    inside = (ranges > nearest) & (ranges < farthest)
    behind = ranges + np.float32(0.2)
    first = Return(ranges, np.where(inside, 0.7, 1).astype(np.float32) * direct.strength)
    second = Return(behind, np.where(inside, 0.3 * direct.strength * (ranges / behind) ** 2, 0).astype(np.float32))
    closed = ForwardModel(replace(small.light, returns=(first, second)), small.footprints, small.clock).expected(1e3)
    setting = effect.at(covered=0.3, spacing=0.2, nearest=nearest, farthest=farthest)
    found = ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [setting])
    np.testing.assert_allclose(found, closed, atol=0.03 * closed.max())


def test_it_suggests_the_spacing_and_what_is_covered(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 2.0)
    truth = effect.at(passed=[0.2, 0, 0.4, 0.1], spacing=0.35)
    nominal = model.expected(3e5)
    excess = np.random.default_rng(3).poisson(model.expected(3e5, [truth])) - nominal
    starts = effect.starts(excess, nominal, Rendering(small.light, small.footprints, small.clock, 3e5, background=2.0))
    assert abs(starts[0]["spacing"] - 0.35) < 0.03
    assert {start["falloff"] for start in starts if "passed" in start} == {0.0, 2.0}
    for start in starts:
        effect.at(**start)


def test_a_spacing_that_one_way_to_go_with_range_hides_is_begun_by_either(small, monkeypatch):
    """A sheet far in front would be so bright that a few stray counts there promise more than all that is behind."""
    told = {2.0: Replica(-1.4, 900.0, 0.3, 1.2, 900.0), 0.0: Replica(0.14, 100.0, 0.3, 1.2, 100.0)}
    monkeypatch.setattr(module, "replicas", lambda excess, expected, rendering, falloff: [told[falloff]])
    nominal = ForwardModel(small.light, small.footprints, small.clock, 2.0).expected(1e3)
    starts = effect.starts(
        0 * nominal, nominal, Rendering(small.light, small.footprints, small.clock, 1e3, background=2.0)
    )
    begun = {(one["spacing"], one["falloff"]) for one in starts if "passed" in one}
    assert begun == {(-1.4, 2.0), (-1.4, 0.0), (0.14, 2.0), (0.14, 0.0)}


BINS_OF_4_CM = SimpleNamespace(clock=SimpleNamespace(bin_width_s=0.267e-9))


@pytest.mark.parametrize("some", ["one", "covered"])
@pytest.mark.parametrize(("part", "denied"), [(0.99, True), (0.6, False), (0.0, False)])
def test_things_all_of_whose_light_comes_from_elsewhere_are_elsewhere(some, part, denied):
    values = effect.at(**{some: part}, spacing=0.1).values
    assert (effect.contradiction(values, BINS_OF_4_CM) is not None) == denied


@pytest.mark.parametrize(
    ("passed", "stretched"), [([0.95, 0, 0.02, 0], True), ([0.4, 0, 0.1, 0], False), (0.95, False)]
)
def test_a_sheet_before_one_zone_that_lets_all_pass_is_rather_a_delay(passed, stretched):
    assert effect.strained(effect.at(passed=passed, spacing=0.01).values, BINS_OF_4_CM) == stretched


@pytest.mark.parametrize(("spacing", "stretched"), [(0.003, True), (-0.003, True), (0.005, False), (-0.05, False)])
def test_a_sheet_where_the_first_surface_is_is_rather_its_brightness(spacing, stretched):
    assert effect.strained(effect.at(passed=0.1, spacing=spacing).values, BINS_OF_4_CM) == stretched


def boxed(small):
    """A wall with a box before it, which are told apart; and which pixels see the box."""
    depth = np.full((3, 24, 40), 1.2)
    depth[:, 6:18, 10:24] = 0.6
    light = direct_light(depth, np.array([[30.0, 0, 19.5], [0, 30, 11.5], [0, 0, 1]]), time_s=small.light.time_s)
    assert {int(light.surfaces[0, 0, 0]), int(light.surfaces[0, 12, 16])} == {1, 2}
    return light, light.surfaces == 2


def test_one_thing_alone_may_be_translucent(small, maps):
    light, box = boxed(small)
    where, (direct,) = footprints(maps, (24, 40)), light.returns
    behind = direct.range_m + np.float32(0.2)
    first = Return(direct.range_m, (direct.strength * np.where(box, 0.7, 1)).astype(np.float32))
    second = Return(behind, (box * 0.3 * 0.8 * direct.strength * (direct.range_m / behind) ** 2).astype(np.float32))
    closed = ForwardModel(replace(light, returns=(first, second)), where, small.clock).expected(1e3)
    setting = effect.at(one=0.3, spacing=0.2, reflectance=0.8, surface=2)
    found = ForwardModel(light, where, small.clock).expected(1e3, [setting])
    np.testing.assert_allclose(found, closed, rtol=1e-5, atol=1e-6 * closed.max())


@pytest.mark.parametrize("spacing", [0.25, -0.2])
def test_it_suggests_which_thing_and_how_far_behind(small, maps, spacing):
    light, _ = boxed(small)
    where = footprints(maps, (24, 40))
    model, truth = ForwardModel(light, where, small.clock, 2.0), effect.at(one=0.3, spacing=spacing, surface=2)
    nominal = model.expected(1e3)
    excess = np.random.default_rng(3).poisson(model.expected(1e3, [truth])) - nominal
    starts = effect.starts(excess, nominal, Rendering(light, where, small.clock, 1e3, background=2.0))
    best = next(start for start in starts if "one" in start)
    assert best["surface"] == 2
    assert abs(best["spacing"] - spacing) < 0.03
