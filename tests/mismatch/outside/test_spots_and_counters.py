"""Causes outside the library that sit somewhere in the image or in the counter, against arithmetic of their own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from physics.footprint import footprints
from physics.light import Return
from physics.nominal import ForwardModel
from physics.rendering import Rendering

from ..conftest import BACKGROUND, BINS, WIDTH_S
from .conftest import CAUSES, changed


def test_pulses_that_broaden_with_the_light(scene):
    model, _, _clock = scene
    light = model.expected(1000.0) - BACKGROUND[:, None]
    signal, bins = light.sum(axis=-1), np.arange(BINS) + 0.5

    def variance(counts):
        mean = counts @ bins / counts.sum()
        return counts @ (bins - mean) ** 2 / counts.sum()

    for values, power in (({"width": 0.3e-9}, 1.0), ({"width": 0.3e-9, "power": 2.0}, 2.0)):
        found = changed(model, "level_broadening", level=float(signal.max()), **values) - BACKGROUND[:, None]
        for zone in (0, 2):  # Whose pulses end within the window.
            added = (0.3e-9 / WIDTH_S) ** 2 * (signal[1, zone] / signal.max()) ** power
            assert found[1, zone].sum() == pytest.approx(signal[1, zone], rel=1e-3)
            assert variance(found[1, zone]) - variance(light[1, zone]) == pytest.approx(added, rel=0.05)
    found = changed(model, "level_broadening", level=float(signal.max()), share=0.5, amiss=0.3e-9) - BACKGROUND[:, None]
    added = 0.5 * signal[1, 2] / signal.max() * (0.3e-9 / WIDTH_S) ** 2
    assert variance(found[1, 2]) - variance(light[1, 2]) == pytest.approx(added, rel=0.05)


THING = {
    "bright": 0.1,
    "across": 0.4,
    "down": 0.6,
    "wide": 0.2,
    "rightward": 0.5,
    "downward": -0.4,
    "distance": 0.6,
    "approach": -0.2,
    "bend": 0.3,
    "when": 0.15,
    "lasting": 0.2,
}


def thing(light, **of):
    """Light with a spot of its own range and strength, pixel by pixel; what it hides is not."""
    since = np.asarray(light.time_s) - of["when"]
    rows, columns = light.range_m.shape[1:]
    v, u = np.meshgrid((np.arange(rows) + 0.5) / rows, (np.arange(columns) + 0.5) / columns, indexing="ij")
    x = u - of["across"] - of["rightward"] * since[:, None, None]
    y = (v - of["down"] - of["downward"] * since[:, None, None]) * rows / columns
    filled = np.exp(-(x**2 + y**2) / (2 * of["wide"] ** 2) - since[:, None, None] ** 2 / (2 * of["lasting"] ** 2))
    range_m = of["distance"] + of["approach"] * since + of["bend"] * since**2
    there = Return(
        np.broadcast_to(range_m[:, None, None], filled.shape).astype(np.float32),
        (of["bright"] * filled / range_m[:, None, None] ** 2).astype(np.float32),
    )
    return replace(light, returns=(*light.returns, there)), filled


def test_a_thing_that_no_depth_image_shows(scene, maps):
    model, light, clock = scene
    seen, filled = thing(light, **THING)
    where = footprints(maps, light.range_m.shape[1:])
    oracle = ForwardModel(seen, where, clock, BACKGROUND).expected(1000.0)
    np.testing.assert_allclose(changed(model, "unseen_thing", **THING), oracle, rtol=2e-3, atol=1e-6 * oracle.max())
    # It hides, of what a zone sees, as much of all light as it fills of the zone.
    covered = changed(model, "unseen_thing", **THING, cover=0.5) - changed(model, "unseen_thing", **THING)
    part = np.einsum("phw,fhw->fp", where.weights, filled) / where.weights.sum(axis=(1, 2))
    plain = model.expected(1000.0) - BACKGROUND[:, None]
    np.testing.assert_allclose(covered, -0.5 * part[..., None] * plain, rtol=1e-6, atol=1e-9 * plain.max())


def test_an_unseen_thing_is_looked_for_where_it_is(scene, maps):
    model, light, clock = scene
    of = {"across": 0.3, "down": 0.3, "distance": 0.5, "approach": 0.4, "when": 0.2, "bright": 0.05, "wide": 0.1}
    plain, found = model.expected(1000.0), changed(model, "unseen_thing", **of, lasting=1.0)
    where = footprints(maps, light.range_m.shape[1:])
    rendering = SimpleNamespace(clock=clock, background=BACKGROUND[:, None], footprints=where, light=light)
    best = CAUSES["unseen_thing"].starts(found - plain, plain, rendering)[0]
    ranges = [one["distance"] + one["approach"] * (np.asarray(light.time_s) - one["when"]) for one in (best, of)]
    np.testing.assert_allclose(*ranges, atol=0.05)
    assert best["across"] < 0.5
    assert best["down"] < 0.5


def test_detectors_that_are_switched_off(scene, maps):
    model, light, clock = scene
    where, values = footprints(maps, light.range_m.shape[1:]), {"across": 0.7, "down": 0.3, "wide": 0.1, "zone": 1}
    cause = CAUSES["masked_spads"].at(depth=0.6, **values)
    found = cause.effect.footprints(cause.values, Rendering(light, where, clock, 1.0)).weights
    rows, columns = found.shape[1:]
    for v, u in ((2, 11), (5, 8)):
        square = ((u + 0.5) / columns - 0.7) ** 2 + (((v + 0.5) / rows - 0.3) * rows / columns) ** 2
        gone = 0.6 * np.exp(-square / 0.02)
        assert found[1, v, u] == pytest.approx((1 - gone) * where.weights[1, v, u], rel=1e-6)
    np.testing.assert_array_equal(np.delete(found, 1, axis=0), np.delete(where.weights, 1, axis=0))
    plain, holed = model.expected(1000.0), changed(model, "masked_spads", depth=0.6, **values)
    rendering = SimpleNamespace(footprints=where)
    starts = CAUSES["masked_spads"].starts(holed - plain, plain, rendering)
    assert len(starts) == 5
    assert {start["zone"] for start in starts} == {1}


@pytest.mark.parametrize("running", [0.0, 2.0])
def test_a_ripple_in_the_dark(scene, running):
    model, light, _clock = scene
    t, time_s = np.arange(BINS) / BINS, np.asarray(light.time_s)
    of = {"counts": 0.5, "cycles": 6.0, "phase": 0.3, "running": running}
    plain, found = model.expected(1000.0), changed(model, "dark_ripple", **of)
    wave = 1 + np.cos(2 * np.pi * (6 * t - 0.3 - running * time_s[4]))
    np.testing.assert_allclose((found - plain)[4, 2], 0.5 * wave, atol=1e-9 * plain.max())
    rendering = SimpleNamespace(background=BACKGROUND[:, None], light=light)
    best = CAUSES["dark_ripple"].starts(found - plain, plain, rendering)[1 if running else 0]
    assert best["cycles"] == pytest.approx(6, abs=1)
    assert best["running"] == pytest.approx(running, abs=0.5)
    # One that dies away about the level there was, which it may not take below nothing.
    away = changed(model, "dark_ripple", **of | {"counts": 0.4, "fading": 3.0, "lifted": 0.0})[4, 2]
    swing = 0.4 * (wave - 1) * np.exp(-3 * t)
    assert BACKGROUND[2] > 0.4
    np.testing.assert_allclose(away - plain[4, 2], swing, atol=1e-9 * plain.max())
    deep = changed(model, "dark_ripple", **of | {"counts": 1e3, "lifted": 0.0})[4, 2]
    np.testing.assert_allclose(deep.min(), (plain[4, 2] - BACKGROUND[2])[deep.argmin()], atol=1e-9 * plain.max())


def test_events_are_filed_in_other_bins(scene):
    """One by one: a digit inverted, or late in a turn and a turn late; those beyond the window are nowhere."""
    model, *_ = scene
    plain = model.expected(1000.0)
    for values, where in (
        ({"flipped": 0.2, "digit": 2.0}, {t: t ^ 4 for t in range(BINS)}),
        ({"flipped": 0.2, "digit": 3.0, "sticks": 1.0}, {t: t - 8 for t in range(BINS) if t // 8 % 2}),
        ({"flipped": 0.2, "digit": 3.0, "sticks": 2.0}, {t: t + 8 for t in range(BINS) if not t // 8 % 2}),
        ({"slipped": 0.2, "turn": 16.0, "at": 12.0, "wide": 4.0}, {t: t + 16 for t in range(BINS) if t % 16 >= 12}),
    ):
        oracle = plain.copy()
        for t, to in where.items():
            oracle[..., t] -= 0.2 * plain[..., t]
            if to < BINS:
                oracle[..., to] += 0.2 * plain[..., t]
        np.testing.assert_allclose(changed(model, "misfiled_bins", **values), oracle, rtol=1e-12)
    # All of one zone: its bins change places two by two.
    zones = plain.shape[1]
    swapped = changed(model, "misfiled_bins", flipped=np.eye(zones)[1], digit=0.0)
    np.testing.assert_allclose(swapped[:, 1], plain[:, 1].reshape(len(plain), -1, 2)[..., ::-1].reshape(len(plain), -1))
    np.testing.assert_allclose(np.delete(swapped, 1, axis=1), np.delete(plain, 1, axis=1))


def test_the_turn_of_a_coarse_counter_is_looked_for(scene):
    model, light, clock = scene
    where = {"turn": 11.0, "at": 9.0, "wide": 2.0}
    plain, slipped = model.expected(1000.0), changed(model, "misfiled_bins", slipped=0.2, **where)
    starts = CAUSES["misfiled_bins"].starts(slipped - plain, plain, Rendering(light, None, clock, 1000.0))
    assert {"slipped": 0.05, **where} in starts
    assert all(CAUSES["misfiled_bins"].at(**start) for start in starts)


def test_a_counter_of_two_slopes(scene):
    model, *_ = scene
    plain = model.expected(1000.0)
    half = float(plain.max()) / 2
    found = changed(model, "two_slopes", lost=0.3, above=half)
    np.testing.assert_array_equal(found[plain <= half], plain[plain <= half])
    np.testing.assert_allclose(found[plain > half], half + 0.7 * (plain[plain > half] - half), rtol=1e-12)


def test_a_driver_that_rings(scene, maps):
    """Against the pulse with what follows it, summed term by term."""
    _, light, clock = scene
    where, tau, period = footprints(maps, light.range_m.shape[1:]), 0.8e-9, 1.5e-9
    cause = CAUSES["ringing"].at(share=0.3, tau=tau, period=period)
    found = cause.effect.clock(cause.values, Rendering(light, where, clock, 1.0)).pulse
    pulse, step = clock.pulse.probability, clock.pulse.step_s
    wave = [np.exp(-k * step / tau) * np.sin(2 * np.pi * k * step / period) for k in range(int(8 * tau / step) + 2)]
    strength = 0.3 / np.abs(wave).sum()
    for i in (5, 40, 90):
        before = sum(pulse[j] * wave[i - j] for j in range(min(i + 1, len(pulse))) if i - j < len(wave))
        own = pulse[i] if i < len(pulse) else 0.0
        ratio = max(own + strength * before, 0) / max(pulse[3] + strength * pulse[:3] @ wave[3:0:-1], 1e-30)
        assert found.probability[i] / found.probability[3] == pytest.approx(ratio, rel=1e-6, abs=1e-9)
    assert found.probability.sum() == pytest.approx(pulse.sum())
    np.testing.assert_allclose(found.time_s[:5], clock.pulse.time_s[:5])


def test_dirt_on_the_lens(scene, maps):
    model, light, clock = scene
    where, values = footprints(maps, light.range_m.shape[1:]), {"across": 0.3, "down": 0.3, "wide": 0.1}
    cause = CAUSES["lens_dirt"].at(dark=0.6, **values)
    found = cause.effect.footprints(cause.values, Rendering(light, where, clock, 1.0)).weights
    rows, columns = found.shape[1:]
    for v, u in ((2, 4), (5, 8)):
        square = ((u + 0.5) / columns - 0.3) ** 2 + (((v + 0.5) / rows - 0.3) * rows / columns) ** 2
        there = 1 - 0.6 * np.exp(-square / 0.02)
        np.testing.assert_allclose(found[:, v, u], there * where.weights[:, v, u], rtol=1e-5)
    plain, darker = model.expected(1000.0), changed(model, "lens_dirt", dark=0.6, **values)
    rendering = SimpleNamespace(footprints=where, background=BACKGROUND[:, None])
    first = CAUSES["lens_dirt"].starts(darker - plain, plain, rendering)[0]
    assert first["across"] < 0.45
    assert first["down"] < 0.45


def test_a_base_line_that_dips(scene):
    """By the response of a high-pass filter, bin after bin."""
    model, _, clock = scene
    plain = model.expected(1000.0)
    light = plain - BACKGROUND[:, None]
    found = changed(model, "undershoot", lost=0.2, tau=3e-9)
    ago = np.arange(1, BINS) * clock.bin_width_s
    weights = np.exp(-ago / 3e-9)
    weights *= 1 / (np.exp(-clock.bin_width_s / 3e-9) / (1 - np.exp(-clock.bin_width_s / 3e-9)))
    dip = np.array([light[1, 2, t - 1 :: -1][:t] @ weights[:t] if t else 0.0 for t in range(BINS)])
    np.testing.assert_allclose(found[1, 2], np.maximum(plain[1, 2] - 0.2 * dip, 0), rtol=1e-9, atol=1e-9)
    assert (changed(model, "undershoot", lost=3.0, tau=1e-9) >= 0).all()


def test_light_that_enters_a_surface_comes_later(scene):
    """All of one surface: mean and variance grow by those of an exponential, and nothing is lost."""
    _model, light, clock = scene
    effect = CAUSES["translucent"]
    deep = 0.05
    values = effect.at(inside=0.4, deep=deep, surface=1.0).values
    made = effect.light(values, Rendering(light, None, clock, 1.0))
    there = light.surfaces == 1
    ranges = np.stack([way.range_m for way in made.returns], -1)[there].astype(float)
    strengths = np.stack([way.strength for way in made.returns], -1)[there].astype(float)
    before = light.returns[0].strength[there]
    np.testing.assert_allclose(strengths.sum(-1), before, rtol=1e-5)
    late = (ranges - ranges[:, :1])[:, 1:]
    assert (late @ np.ones(late.shape[1]) / late.shape[1]).mean() == pytest.approx(deep, rel=1e-3)
    # Parts of equal chance keep most of the variance of an exponential.
    assert late.var(axis=1).mean() == pytest.approx(deep**2, rel=0.2)
    np.testing.assert_allclose(strengths[:, 1:].sum(-1), 0.4 * before, rtol=1e-5)
    assert (made.returns[0].strength[~there] == light.returns[0].strength[~there]).all()


@pytest.mark.parametrize("lies", [0, 1])
def test_a_row_of_emitters_that_dies_takes_a_stripe_of_the_light(scene, maps, lies):
    """Against light that is dimmed pixel by pixel; and it is found where and when it is."""
    model, light, clock = scene
    shape = light.range_m.shape[1:]
    values = {"dark": 0.3, "at": 0.4, "wide": 0.15, "lies": float(lies), "begins": 0.55}
    dimmed = np.array(light.returns[0].strength, float) * np.ones(light.range_m.shape)
    for frame, row, column in np.ndindex(dimmed.shape):
        u = (row + 0.5) / shape[0] if lies else (column + 0.5) / shape[1]
        if light.time_s[frame] >= 0.55 * light.time_s[-1]:
            dimmed[frame, row, column] *= 1 - 0.3 * np.exp(-0.5 * ((u - 0.4) / 0.15) ** 2)
    dark = replace(light, returns=(replace(light.returns[0], strength=dimmed),))
    oracle = ForwardModel(dark, footprints(maps, shape), clock, BACKGROUND).expected(1000.0)
    found = changed(model, "dead_emitters", **values)
    np.testing.assert_allclose(found, oracle, rtol=1e-5)
    there = Rendering(light, footprints(maps, shape), clock, 1000.0, BACKGROUND[:, None])
    start = CAUSES["dead_emitters"].starts(found - model.expected(1000.0), model.expected(1000.0), there)[lies]
    assert start["lies"] == lies
    assert start["begins"] == pytest.approx(0.5)  # The fourth of six frames is the first.
    assert abs(start["at"] - 0.4) < 0.2
    assert CAUSES["dead_emitters"].starts(np.ones((1, 4, BINS)), np.ones((1, 4, BINS)), there) == []
