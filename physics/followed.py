"""Light between frames: carried along where things were followed from frame to frame, pixel by pixel elsewhere."""

from dataclasses import replace
from itertools import zip_longest

import numpy as np

from physics.carried import carried, carriers, off_by
from physics.kept import kept_of_session
from physics.light import Light, Return
from physics.light_between import blended

# Between frames things are followed that are off by less than this part of what they are if all stands still.
CLEARLY = 0.5


def followed(light: Light, lower: np.ndarray, upper: np.ndarray, part: np.ndarray, time_s: np.ndarray) -> Light:
    """Light at times (F,), seconds, of frames `lower` and `upper` (F,), with `part` (F,) of the second, 0 to 1.

    As `carried` has it. But between frames of which one does not become the other as things are carried, something was
    taken for a thing that it is not, or to move as it does not: there it is as `blended` has it.
    """
    along, steps = carried(light, carriers(light), lower, upper, part, time_s), _followed_steps(light)
    of = np.arange(light.frames) if light.part_of is None else light.part_of[1]
    there = np.array([steps[i:j].all() for i, j in zip(of[lower], of[upper], strict=True)])
    return along if there.all() else _either(there, along, blended(light, lower, upper, np.clip(part, 0, 1)))


@kept_of_session
def _followed_steps(light: Light) -> np.ndarray:
    """(F - 1,) whether each frame becomes the next, and this it, as things are carried."""
    times, frames, seen = np.asarray(light.time_s, float), np.arange(light.frames), light.range_m
    begun, things = np.zeros(light.frames), carriers(light)
    after, before = np.minimum(frames + 1, frames[-1]), np.maximum(frames - 1, 0)
    onward, back = (carried(light, things, frames, frames, begun, times[to]).range_m for to in (after, before))
    moved = off_by(onward[:-1], seen[1:]) + off_by(back[1:], seen[:-1])
    return moved <= CLEARLY * (off_by(seen[:-1], seen[1:]) + off_by(seen[1:], seen[:-1]))


def _either(there: np.ndarray, one: Light, other: Light) -> Light:
    """The first in frames that are `there` (F,), the second in others."""

    def mixed(mine: np.ndarray, its: np.ndarray) -> np.ndarray:
        return np.where(there.reshape(-1, *(1,) * (mine.ndim - 1)), mine, its)

    none = Return(np.ones_like(one.range_m), np.zeros_like(one.range_m))
    ways = zip_longest(one.returns, other.returns, fillvalue=none)
    returns = tuple(Return(mixed(a.range_m, b.range_m), mixed(a.strength, b.strength)) for a, b in ways)
    names = "range_m", "reflectance", "cosine", "missing"
    return replace(one, returns=returns, **{name: mixed(getattr(one, name), getattr(other, name)) for name in names})
