"""A recording beside its simulation: the same frames, under any effects."""

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from mismatch.remembered import Remembered
from mismatch.work import Work
from physics.clock import Clock
from physics.effect import Setting, in_order
from physics.footprint import Footprints
from physics.light import Light
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from physics.workers import in_parallel

Item = TypeVar("Item")
Result = TypeVar("Result")

# Expected counts are kept at so many settings, or fewer that hold so many numbers: fits and tests come back to them.
RECENT = 12
NUMBERS = 1 << 24


@dataclass(frozen=True, eq=False)
class Simulation:
    """F frames that were recorded, and the model of them.

    counts: (F, P, T). light, footprints, clock, background: as `ForwardModel` takes them. given: effects that are known
    to be there. frames: (F,) which of the whole recording's frames these are. whole: the recording they are of, None
    where they are all. dead: (P,) zones that count nothing and are not judged, None where all are alive. work: what was
    asked of it and of its parts, together.
    """

    counts: np.ndarray
    light: Light
    footprints: Footprints
    clock: Clock
    background: np.ndarray
    frames: np.ndarray
    given: tuple[Setting, ...] = ()
    whole: "Simulation | None" = None
    dead: np.ndarray | None = None
    work: Work = field(default_factory=Work)

    @cached_property
    def model(self) -> ForwardModel:
        """The forward model of these frames."""
        return ForwardModel(self.light, self.footprints, self.clock, self.background, self.counts)

    def each(self, work: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
        """What `work` on this simulation gives for each item: at once where little enough is kept for each thread."""
        lattices = self.counts.shape[0] * self.counts.shape[1] * self.clock.lattice.size
        few = self.light.range_m.size + lattices < NUMBERS
        return in_parallel(work, items, singly=True) if few else [work(item) for item in items]

    @cached_property
    def _recent(self) -> threading.local:
        """Expected counts of each thread, by gain and effects, those last that were asked for last."""
        return threading.local()

    def expected(self, gain: float, effects: tuple[Setting, ...] = ()) -> np.ndarray:
        """(F, P, T) expected counts with these effects and those that are given; to read only."""
        self.work.add(self.light.range_m.size + self.counts.size, self._read_anew(effects))
        key = (gain, *(setting.key for setting in effects))
        recent: dict[tuple, np.ndarray] = self._recent.__dict__
        found = recent.pop(key) if key in recent else self._expected(gain, effects)
        found.setflags(write=False)
        while recent and len(recent) >= min(RECENT, NUMBERS / self.counts.size):
            del recent[next(iter(recent))]
        recent[key] = found
        return found

    def _read_anew(self, effects: tuple[Setting, ...]) -> int:
        """Pixels of maps that are read for each zone in each frame, where effects move those of zones and frames."""
        moves = [setting.effect.moves_maps(setting.values) for setting in effects]
        both = any(zones for zones, _ in moves) and any(frames for _, frames in moves)
        return self.light.range_m.size * self.counts.shape[1] if both else 0

    @cached_property
    def remembered(self) -> Remembered:
        """What forms changed beside an earlier fit."""
        return Remembered()

    def _expected(self, gain: float, effects: tuple[Setting, ...]) -> np.ndarray:
        """See `expected`."""
        own = {setting.effect.id for setting in effects}
        together = (*(setting for setting in self.given if setting.effect.id not in own), *effects)
        if self.whole is not None and any(s.effect.mixes(s.values) for s in together):
            return self.whole.expected(gain, effects)[self.frames]
        expected = self.model.expected(gain, together)
        if self.dead is not None and self.dead.any():
            expected = np.where(self.dead[:, None], 0.0, expected)
        return expected

    def without(self, gain: float, effects: tuple[Setting, ...], setting: Setting) -> Rendering:
        """What an effect that looks at the recording is shown: counts expected without it, and those recorded."""
        expected = self.expected(gain, tuple(other for other in effects if other is not setting))
        return replace(self.rendering(gain), expected=expected, recorded=self.counts)

    def rendering(self, gain: float, effects: tuple[Setting, ...] = ()) -> Rendering:
        """Scene and sensor as effects are given them, the background as it is with those that are there."""
        now = Rendering(self.light, self.footprints, self.clock, gain, background=self.background[:, None])
        for setting in in_order((*self.given, *effects)):
            if "background" in setting.effect.changes:
                now = replace(now, background=setting.effect.apply("background", setting.values, now))
        return now

    def of(self, chosen: np.ndarray) -> "Simulation":
        """Some of the frames, by index (N,)."""
        clock, where = self.clock, self.footprints
        if np.ndim(clock.time_zero_s) == 2:
            clock = replace(clock, time_zero_s=clock.time_zero_s[chosen])
        whole = self if self.whole is None else self.whole
        return replace(
            self,
            counts=self.counts[chosen],
            light=self.light.of(chosen),
            clock=clock,
            footprints=where,
            frames=self.frames[chosen],
            whole=whole,
        )
