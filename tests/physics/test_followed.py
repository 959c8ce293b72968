"""Light between frames is carried where things were followed, and blended where they were not."""

import numpy as np
import pytest

from physics import followed as module
from physics.bodies import Body
from physics.carried import carried, carriers
from physics.followed import followed
from physics.light_between import blended
from physics.motion import Motion

from .test_carried import TIMES, pose, seen, wall

AT = np.full(3, 0.04)


def between(light):
    """All frames as they are 40 ms after the first."""
    return np.zeros(3, int), np.ones(3, int), np.full(3, 0.4), AT


def total(light):
    return sum(way.strength * way.range_m**2 for way in light.returns)


def test_what_is_followed_is_carried():
    light = seen(wall)
    found, expected = followed(light, *between(light)), carried(light, carriers(light), *between(light))
    np.testing.assert_array_equal(found.range_m, expected.range_m)
    np.testing.assert_array_equal(total(found), total(expected))


@pytest.mark.parametrize("chosen", [slice(None), slice(1, None)])
def test_where_a_step_is_not_followed_frames_are_blended(monkeypatch, chosen):
    """Frames of which one becomes the next otherwise than things are said to move, of a session and of part of it."""
    every = seen(wall)
    light = every if chosen == slice(None) else every.of(np.arange(3)[chosen])
    monkeypatch.setattr(module, "_followed_steps", lambda _: np.array([True, False]))
    lower = np.arange(light.frames - 1)
    pairs = lower, lower + 1, np.full(len(lower), 0.4), TIMES[chosen][:-1] + 0.04
    whole = tuple(np.append(of, of[-1]) for of in pairs)
    found, along, mixed = followed(light, *whole), carried(light, carriers(light), *whole), blended(light, *whole[:3])
    for i in range(len(lower)):
        here = along if i == 0 and light is every else mixed
        np.testing.assert_array_equal(found.range_m[i], here.range_m[i])
        np.testing.assert_allclose(total(found)[i], total(here)[i], rtol=1e-6)


def test_steps_that_things_do_not_take_are_not_followed(monkeypatch):
    """Things that are said to move as they do, and otherwise in the second step."""
    assert module._followed_steps(seen(wall)).all()
    poses = np.stack([pose(t) for t in TIMES])
    poses[2, :3, 3] += (0.0, 0.0, 0.3)
    body = Body(Motion.of(TIMES, poses), np.ones((3, 30, 40), bool))
    monkeypatch.setattr(module, "carriers", lambda _: (body,))
    np.testing.assert_array_equal(module._followed_steps(seen(wall)), [True, False])
