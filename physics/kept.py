"""What was added up on a lattice is kept with the light it is of, for every clock of the same knots."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

import numpy as np

from physics.clock import Clock
from physics.footprint import Footprints
from physics.light import Light

# As many are kept: fits come back to where they were, and mix what was made in different ways. Of more numbers than
# this, one.
KEPT = 4
MANY = 1 << 22
# Of single frames, for all parts of a session, so many numbers.
MOST = 1 << 24
# Lattices whose first knots differ by less than this part of a step are the same.
ROUNDING = 1e-9

# Light, footprints, clock, and how, to (F, P, J) light by knot of the clock's lattice.
Sum = Callable[..., np.ndarray]
Made = TypeVar("Made")


def same_knots(clock: Clock, other: Clock) -> bool:
    """Whether light arrives at the same knots under one clock as under another that follows it as long, or longer.

    A pulse that changes on the steps it had leaves them as they are.
    """
    mine, its = clock.lattice, other.lattice
    return bool(
        mine.per_bin == its.per_bin
        and mine.size <= its.size
        and abs(mine.step_s - its.step_s) < ROUNDING * mine.step_s / mine.size
        and abs(mine.first_s - its.first_s) < ROUNDING * mine.step_s
        and np.array_equal(clock.time_zero_s, other.time_zero_s)
    )


def kept_with_light(make: Sum) -> Sum:
    """The function `make`, which does not make again what was made of the same; what it gives is to be read only."""
    return _kept(make, lambda light: light.__dict__, lambda light: ())


def kept_with_scene(make: Sum) -> Sum:
    """The same of what goes by ranges and assumed reflectance alone: for all light that these send back."""
    return _kept(make, lambda light: light.kept, lambda light: (light.range_m, light.assumed_reflectance))


def kept_by_frame(make: Sum) -> Sum:
    """The same of (P, J) light of one frame, which comes second: parts of a session find what others have made.

    Of ranges and assumed reflectance alone; what it gives is to be read only.
    """
    name = f"_{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def kept(light: Light, frame: int, footprints: Footprints, clock: Clock, *how: bool) -> np.ndarray:
        session, number = light, frame
        if light.part_of is not None:
            session, number = light.part_of[0], int(light.part_of[1][frame])
        store, scene = session.kept.setdefault(name, {}), (light.range_m[frame], light.assumed_reflectance[frame])
        found = store.get((number, how))
        if found is not None:
            made_of, seen_by, timed_by, made = found
            same = all(np.array_equal(mine, its, equal_nan=True) for mine, its in zip(scene, made_of, strict=True))
            if same and footprints is seen_by and same_knots(clock, timed_by):
                return made[:, : clock.lattice.size]
        made = make(light, frame, footprints, clock, *how)
        made.setflags(write=False)
        if (len(store) + 1) * made.size <= MOST:
            store[number, how] = scene, footprints, clock, made
        return made

    return kept


def kept_of_session(make: Callable[..., Made]) -> Callable[..., Made]:
    """The function `make` of light, which is asked once for what the ranges of all frames of a session tell.

    Of some of the frames it tells what all of them do. What it gives is to be read only.
    """
    name = f"_{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def kept(light: Light, *more: Any) -> Made:
        if light.part_of is not None:
            return kept(light.part_of[0], *more)
        found = light.kept.get(name)
        if found is None or found[0] is not light.range_m:
            found = light.range_m, make(light, *more)
            light.kept[name] = found
        return found[1]

    return kept


def kept_lately(make: Callable[..., Made]) -> Callable[..., Made]:
    """The function `make` of light and numbers, which does not make again the last two that it made of the same light.

    What it gives is to be read only.
    """
    name = f"_{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def kept(light: Light, *how: float) -> Made:
        recent = light.__dict__.get(name, ())
        for made_so, made in recent:
            if made_so == how:
                return made
        made = make(light, *how)
        light.__dict__[name] = ((how, made), *recent)[:2]
        return made

    return kept


def _kept(make: Sum, store: Callable[[Light], dict], things: Callable[[Light], tuple]) -> Sum:
    """See above. store: where light keeps it. things: that it was made of, beside footprints and clock."""
    name = f"_{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def kept(light: Light, footprints: Footprints, clock: Clock, *how: bool) -> np.ndarray:
        recent, of = store(light).get(name, ()), (*things(light), footprints)
        for made_of, timed_by, made_so, made in recent:
            same = all(mine is its for mine, its in zip(of, made_of, strict=True))
            if same and made_so == how and same_knots(clock, timed_by):
                # What arrives later than a shorter pulse is seen for is left out.
                return np.ascontiguousarray(made[..., : clock.lattice.size])
        made = make(light, footprints, clock, *how)
        made.setflags(write=False)
        # Anew, not in place: other threads may be reading.
        store(light)[name] = ((of, clock, how, made), *recent)[: KEPT if made.size < MANY else 1]
        return made

    return kept
