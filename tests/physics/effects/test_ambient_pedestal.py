"""A pedestal in closed form: as many counts in every bin, and more of them with time."""

import numpy as np
import pytest

from physics.effects.ambient_pedestal import effect
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.rendering import Rendering

INTRINSICS = np.array([[7.5, 0, 4.5], [0, 7.5, 2.5], [0, 0, 1]])


def test_every_bin_has_as_many_more(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 3.0)
    more = model.expected(50.0, [effect.at(level=[1, 2, 3, 4.5])]) - model.expected(50.0)
    np.testing.assert_allclose(more, np.broadcast_to(np.array([1, 2, 3, 4.5])[:, None], more.shape))


def test_under_even_light_a_zone_is_as_bright_as_what_it_sees(small):
    """However far: counts by Lambert's law, pixel by pixel; nothing where no surface is known."""
    rng = np.random.default_rng(4)
    shape = small.light.range_m.shape
    white, depth = rng.uniform(0.1, 0.9, shape), rng.uniform(0.5, 2.0, shape)
    depth[1, :2], white[2, :, 3] = np.nan, np.nan
    light = direct_light(depth, INTRINSICS, white, np.ones(shape), time_s=np.arange(float(shape[0])))
    model = ForwardModel(light, small.footprints, small.clock, 3.0)
    more = model.expected(50.0, [effect.at(lit=20.0)]) - model.expected(50.0)
    maps = small.footprints.weights
    for frame in range(shape[0]):
        seen = np.where(np.isnan(depth[frame] + white[frame]), 0, white[frame])
        for zone, response in enumerate(maps):
            wanted = 20 * (response * seen).sum() / maps.sum(axis=(1, 2)).mean()
            np.testing.assert_allclose(more[frame, zone], wanted, rtol=1e-5)


def test_it_grows_with_time_in_all_zones_alike(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 3.0)
    more = model.expected(50.0, [effect.at(level=[1, 2, 3, 4.5], growth=30)]) - model.expected(50.0)
    for i, grown in enumerate((0, 3, 6)):
        np.testing.assert_allclose(more[i], np.broadcast_to(np.array([1, 2, 3, 4.5])[:, None] + grown, more[i].shape))


def test_it_shrinks_to_none_but_not_below(small):
    model = ForwardModel(small.light, small.footprints, small.clock, [3.0, 0, 1, 9])
    signal = ForwardModel(small.light, small.footprints, small.clock).expected(50.0)
    rest = model.expected(50.0, [effect.at(level=1, growth=-30)]) - signal
    np.testing.assert_allclose(rest[..., 0], [[4, 1, 2, 10], [1, 0, 0, 7], [0, 0, 0, 4]], atol=1e-9)


@pytest.mark.parametrize("frequency", [2.3, 100.0, 119.8])
def test_a_lamp_beats_with_the_frames(small, frequency):
    """Level times 1 + a·cos(2πf·t - φ), in sine and cosine; and the data tell which, where frames come unevenly."""
    frames, amount, turned = 40, 0.7, 1.1
    time_s = 0.06 * np.arange(frames) + 3e-3 * np.random.default_rng(1).uniform(-1, 1, frames)
    walls = np.ones((frames, 6, 10))
    light = direct_light(walls, INTRINSICS, None, walls, time_s=time_s)
    model = ForwardModel(light, small.footprints, small.clock, 3.0)
    parts = {"swing_sin": 5 * amount * np.sin(turned), "swing_cos": 5 * amount * np.cos(turned)}
    lamp = effect.at(level=5.0, frequency=frequency, **parts)
    more = model.expected(50.0, [lamp]) - model.expected(50.0)
    wanted = 5 * (1 + amount * np.cos(2 * np.pi * frequency * time_s - turned))
    np.testing.assert_allclose(more, np.broadcast_to(wanted[:, None, None], more.shape), atol=1e-9)
    rendering = Rendering(light, small.footprints, small.clock, 50.0)
    *_, start = effect.starts(more, model.expected(50.0), rendering)
    assert start["frequency"] == pytest.approx(frequency, abs=0.1 / time_s[-1])
    assert start["level"] == pytest.approx(5.0, rel=0.05)
    found = complex(start["swing_cos"], start["swing_sin"])
    assert abs(found) == pytest.approx(5 * amount, rel=0.1)
    assert np.angle(found) == pytest.approx(turned, abs=0.4)


def test_a_beat_is_found_from_frames_that_are_not_neighbours(small):
    """Half of 24 frames, most of them two apart, tell what is faster than every fourth frame."""
    time_s = 0.1 * np.array([0, 3, 5, 6, 9, 10, 12, 15, 17, 18, 20, 23])
    walls = np.ones((len(time_s), 6, 10))
    light = direct_light(walls, INTRINSICS, None, walls, time_s=time_s)
    expected = ForwardModel(light, small.footprints, small.clock, 3.0).expected(50.0)
    more = np.broadcast_to(5 + 4 * np.sin(2 * np.pi * 3.4 * time_s)[:, None, None], expected.shape)
    *_, start = effect.starts(more, expected, Rendering(light, small.footprints, small.clock, 50.0))
    assert start["frequency"] == pytest.approx(3.4, abs=0.05)


@pytest.mark.parametrize("uneven", [0.0, 1e-9, 1e-6])
def test_a_beat_of_every_other_frame_is_of_the_size_that_is_seen(small, uneven):
    """At that frequency frames show the wave at one phase and nothing of the other."""
    frames = 40
    time_s = 0.06 * np.arange(frames) + uneven * np.arange(frames) % 3
    walls = np.ones((frames, 6, 10))
    light = direct_light(walls, INTRINSICS, None, walls, time_s=time_s)
    expected = ForwardModel(light, small.footprints, small.clock, 3.0).expected(50.0)
    more = np.broadcast_to(5.0 + 2 * (-1.0) ** np.arange(frames)[:, None, None], expected.shape)
    *_, start = effect.starts(more, expected, Rendering(light, small.footprints, small.clock, 50.0))
    assert start["level"] == pytest.approx(5.0, abs=0.5)
    assert np.hypot(start["swing_cos"], start["swing_sin"]) < 8


def test_the_same_light_may_be_brighter_than_it_was(small):
    recorded = np.array([3.0, 0, 1, 9])
    model = ForwardModel(small.light, small.footprints, small.clock, recorded)
    more = model.expected(50.0, [effect.at(more=0.4)]) - model.expected(50.0)
    np.testing.assert_allclose(more, np.broadcast_to(0.4 * recorded[:, None], more.shape), atol=1e-9)


def test_clouds_pass_and_lamps_are_switched(small):
    """Each zone has its own share of a light that follows levels at even times, then is a third of what it was."""
    frames, every, heights = 41, 0.5, [0.0, 0.8, -0.4, 0.3, 0.1, -0.2]
    time_s = np.linspace(0, 5 * every, frames)
    walls = np.ones((frames, 6, 10))
    light = direct_light(walls, INTRINSICS, None, walls, time_s=time_s)
    model = ForwardModel(light, small.footprints, small.clock, 3.0)
    zones = np.array([1.0, 2.0, 3.0, 4.5])
    walk = {f"level_{k}": height for k, height in enumerate(heights) if k} | {"every": every}
    more = model.expected(50.0, [effect.at(level=zones, **walk)]) - model.expected(50.0)
    np.testing.assert_allclose(more[::8, :, 0], np.exp(heights)[:, None] * zones, rtol=1e-9)
    assert np.ptp(more, axis=-1).max() < 1e-9
    off = model.expected(50.0, [effect.at(level=zones, jump=-np.log(3), jump_at=1.03)]) - model.expected(50.0)
    part = np.where(time_s < 1.03, 1, 1 / 3)
    np.testing.assert_allclose(off[..., 0], part[:, None] * zones, rtol=1e-9)
    rendering = Rendering(light, small.footprints, small.clock, 50.0)
    first, second, *_ = effect.starts(off, model.expected(50.0), rendering)
    assert first["every"] == pytest.approx(every)
    assert second["jump_at"] == pytest.approx(1.03, abs=0.04)
    # As bright as the mean zone has it, each as much as photons tell.
    assert second["level"] == pytest.approx(zones.mean(), rel=0.3)
    assert second["jump"] == pytest.approx(-np.log(3), rel=1e-6)


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_lamp_that_goes_out_or_was_out_is_as_faint_as_may_be(small, sign):
    frames = 12
    time_s, walls = np.arange(frames) / 10, np.ones((frames, 6, 10))
    light = direct_light(walls, INTRINSICS, None, walls, time_s=time_s)
    rendering, even = Rendering(light, small.footprints, small.clock, 50.0), np.full((frames, 4, 40), 5.0)
    excess = np.where(sign * (time_s - 0.65) > 0, 2.0, 0.0)[:, None, None] * np.ones((4, 40))
    (start,) = (s for s in effect.starts(excess, even, rendering) if "jump" in s)
    assert start["jump_at"] == pytest.approx(0.65)
    assert start["jump"] == sign * effect.parameter("jump").high
    assert start["level"] * np.exp(max(start["jump"], 0)) == pytest.approx(2.0)
    # Where it is darker than recorded there is no lamp.
    (start,) = (s for s in effect.starts(-1 - excess, even, rendering) if "jump" in s)
    assert "level" not in start
