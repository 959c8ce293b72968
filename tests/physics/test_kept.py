"""What is kept with light against making it again."""

from dataclasses import replace

import numpy as np
import pytest

from physics.arrivals import arrivals
from physics.effects.reflectance_map import effect as reflectance_map
from physics.kept import KEPT, kept_by_frame, kept_lately, kept_with_light, kept_with_scene, same_knots
from physics.nominal import ForwardModel
from physics.rendering import Rendering


@pytest.fixture
def counted():
    """A sum that counts how often it is made, and its count."""
    made = []

    @kept_with_light
    def add_up(light, footprints, clock):
        made.append(clock)
        return arrivals(light, footprints, clock).light

    return add_up, made


def tailed(clock, tau=4e-10, share=0.1):
    return replace(clock, pulse=clock.pulse.with_tail(tau, share))


def test_the_same_is_made_once_and_is_to_be_read_only(small, counted):
    add_up, made = counted
    first = add_up(small.light, small.footprints, small.clock)
    again = add_up(small.light, small.footprints, replace(small.clock))
    assert len(made) == 1
    np.testing.assert_array_equal(first, again)
    with pytest.raises(ValueError, match="read-only"):
        first += 1


def test_what_goes_by_the_scene_alone_is_made_once_for_all_light_that_it_sends_back(small):
    made = []

    @kept_with_scene
    def add_up(light, footprints, clock):
        made.append(light)
        return arrivals(light, footprints, clock).light

    dimmer = reflectance_map.light(reflectance_map.at(contrast=0.5).values, rendering(small))
    assert (dimmer.reflectance != small.light.reflectance).any()
    for light in (small.light, dimmer, replace(dimmer, motion=None)):
        add_up(light, small.footprints, small.clock)
    assert len(made) == 1
    # Other frames, or other ranges, are another scene.
    add_up(small.light.of(np.arange(1)), small.footprints, small.clock)
    add_up(replace(small.light, range_m=small.light.range_m * np.float32(1.1)), small.footprints, small.clock)
    assert len(made) == 3


def rendering(small):
    return Rendering(small.light, small.footprints, small.clock, 1.0)


@pytest.mark.parametrize("longer_first", [False, True])
def test_another_pulse_on_the_same_steps_gets_what_it_would_have_got(small, counted, longer_first):
    add_up, _ = counted
    clocks = [small.clock, tailed(small.clock), tailed(small.clock, 2e-10)]
    for clock in reversed(clocks) if longer_first else clocks:
        got = add_up(small.light, small.footprints, clock)
        assert got.shape[-1] == clock.lattice.size
        np.testing.assert_allclose(got, arrivals(small.light, small.footprints, clock).light, atol=1e-9 * got.max())


def test_other_knots_are_told_apart(small):
    clock = small.clock
    assert same_knots(clock, replace(clock))
    later = np.asarray(clock.time_zero_s) + 1e-12
    for other in (
        replace(clock, time_zero_s=later),
        replace(clock, bin_width_s=clock.bin_width_s * 1.001),
        replace(clock, least_per_bin=2 * clock.lattice.per_bin),
    ):
        assert not same_knots(clock, other)
        assert not same_knots(other, clock)


def test_other_light_and_footprints_are_made_anew_and_the_oldest_is_let_go(small, counted):
    add_up, made = counted
    add_up(small.light, small.footprints, small.clock)
    add_up(replace(small.light), small.footprints, small.clock)
    assert len(made) == 2
    for _ in range(KEPT):
        add_up(small.light, replace(small.footprints), small.clock)
    add_up(small.light, small.footprints, small.clock)
    assert len(made) == 2 + KEPT + 1


def test_a_model_that_comes_back_to_where_it_was_gives_what_a_fresh_one_does(small):
    from physics.effects import find_effect

    tail, drift = find_effect("impulse_tail"), find_effect("time_zero_offset")
    model = ForwardModel(small.light, small.footprints, small.clock)
    asked = [(), (tail.at(share=0.1),), (tail.at(share=0.2), drift.at(delay=1e-10)), (tail.at(share=0.1),), ()]
    for effects in asked:
        fresh = ForwardModel(small.light, small.footprints, small.clock)
        got, expected = model.expected(2.0, effects), fresh.expected(2.0, effects)
        np.testing.assert_allclose(got, expected, atol=1e-9 * expected.max())


def test_parts_of_a_session_find_frames_that_others_made_but_not_of_another_scene(small):
    made = []

    @kept_by_frame
    def add_up(light, frame, footprints, clock, twice):
        made.append(frame)
        return (1 + twice) * arrivals(light, footprints, clock).light[frame]

    def asked(light, frame, twice=False):
        before = len(made)
        found = add_up(light, frame, small.footprints, small.clock, twice)
        wanted = (1 + twice) * arrivals(light, small.footprints, small.clock).light[frame]
        np.testing.assert_array_equal(found, wanted)
        return len(made) - before

    last, two = small.light.of(np.array([2])), small.light.of(np.array([0, 2]))
    assert asked(last, 0) == 1
    assert asked(two, 1) == asked(small.light, 2) == 0
    assert asked(two, 0) == 1
    assert asked(two, 1, twice=True) == 1
    nearer = replace(two, range_m=two.range_m * np.float32(0.9))
    assert asked(nearer, 1) == 1
    assert asked(two, 1) == 1


def test_the_last_two_of_the_same_light_are_not_made_again(small):
    asked = []

    @kept_lately
    def made(light, lag, carried):
        asked.append((lag, carried))
        return replace(light, time_s=light.time_s + lag)

    first = made(small.light, 0.1, 0.0)
    assert made(small.light, 0.2, 0.0) is not first
    assert made(small.light, 0.1, 0.0) is first
    made(small.light, 0.1, 1.0)
    assert made(small.light, 0.2, 0.0) is made(small.light, 0.2, 0.0)
    other = replace(small.light, reflectance=small.light.reflectance / 2)
    assert made(other, 0.1, 1.0).reflectance is other.reflectance
    assert asked == [(0.1, 0.0), (0.2, 0.0), (0.1, 1.0), (0.1, 1.0)]
