"""A recording beside its simulation: the same frames, under any effects."""

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from mismatch.remembered import Remembered
from mismatch.work import Work, size_of
from physics.clock import Clock
from physics.footprint import Footprints
from physics.light import Light
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from physics.setting import Setting, in_order
from physics.workers import in_parallel

Item = TypeVar("Item")
Result = TypeVar("Result")

# Expected counts are kept at so many settings, or fewer that hold so many numbers: fits and tests come back to them.
RECENT = 12
NUMBERS = 1 << 24


@dataclass(frozen=True, eq=False)
class Simulation:
    """F frames that were recorded, and the model of them.

    counts: (F, P, T), each as far as it is trusted. light, footprints, clock, background: as `ForwardModel` takes them.
    given: effects that are known to be there. frames: (F,) which of the whole recording's frames these are. whole: the
    recording they are of, None where they are all. dead: (P,) zones that count nothing and are not judged, None where
    all are alive. trust: (F, P, T) above 0 to 1, None where all counts are trusted: one that scatters φ times as much
    as photons do, and what is expected of it, are taken 1/φ times, so that both are as if they were photons'
    (Wedderburn 1974, Biometrika 61, 439). tolerance: (F, P, T) how far they are trusted at most, where the model is off
    by a part of what is expected. guessed: whether its response was estimated from the frames that choose, so that what
    it is off by is as large as the noise of as many frames. timed: whether time zeros of zones hold all the same, but
    for what all share. work: what was asked of it and of its parts.
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
    trust: np.ndarray | None = None
    tolerance: np.ndarray | None = None
    guessed: bool = False
    timed: bool = False
    loose: np.ndarray | None = None
    work: Work = field(default_factory=Work)

    @cached_property
    def model(self) -> ForwardModel:
        """The forward model of these frames."""
        return ForwardModel(self.light, self.footprints, self.clock, self.background, self.recorded)

    @property
    def recorded(self) -> np.ndarray:
        """(F, P, T) counts as they were recorded."""
        return self.counts if self.trust is None else self.counts / self.trust

    @property
    def numbers(self) -> int:
        """How many pixels and cells there are."""
        return self.light.range_m.size + self.counts.size

    @property
    def dark(self) -> np.ndarray:
        """What of expected counts no laser sent, (P, 1) or (F, P, T)."""
        return self.background[:, None] * (1.0 if self.trust is None else self.trust)

    @cached_property
    def loose_rows(self) -> np.ndarray | None:
        """(K, F·P·T) changes with numbers of the clock, as far as counts are trusted; None where it is known."""
        if self.loose is None:
            return None
        return (self.loose if self.trust is None else self.loose * self.trust).reshape(len(self.loose), -1)

    def trusting(self, trust: np.ndarray | None) -> "Simulation":
        """The same with its counts trusted as far as (F, P, T) `trust` and its tolerance say, not as before."""
        if self.tolerance is not None:
            trust = self.tolerance if trust is None else trust * self.tolerance
        if trust is self.trust:
            return self
        counts = self.recorded if trust is None else self.recorded * trust
        return replace(self, counts=counts, trust=trust)

    def as_recorded(self) -> "Simulation":
        """The same with all its counts trusted."""
        return replace(self, tolerance=None).trusting(None)

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
        """(F, P, T) expected counts with these effects and those that are given, as far as trusted; to read only."""
        found = self._before_trust(gain, effects)
        return found if self.trust is None else found * self.trust

    def _before_trust(self, gain: float, effects: tuple[Setting, ...]) -> np.ndarray:
        """(F, P, T) expected counts, to read only."""
        self._count(effects)
        key = (gain, *(setting.key for setting in effects))
        recent: dict[tuple, np.ndarray] = self._recent.__dict__
        found = recent.pop(key) if key in recent else self._expected(gain, effects)
        found.setflags(write=False)
        while recent and len(recent) >= min(RECENT, NUMBERS / self.counts.size):
            del recent[next(iter(recent))]
        recent[key] = found
        return found

    def _count(self, effects: tuple[Setting, ...]) -> None:
        """What that takes."""
        looks = any(setting.effect.looks(setting.values) for setting in effects)
        pulse = float(np.ptp(self.clock.pulse.time_s)) / self.clock.bin_width_s
        size = self._sizes[any(setting.effect.moves_light(setting.values) for setting in (*self.given, *effects))]
        self.work.add(size, self._read_anew(effects), self.counts.size * pulse * looks)
        for setting in effects:
            if setting.effect.redraws_maps(setting.values):
                self.work.draw(setting.key, self.footprints.field.pixels)
            if setting.effect.carries(setting.values):
                self.work.carry(setting.key, size)

    @cached_property
    def _sizes(self) -> tuple[float, float]:
        """Of renderings whose light stays where it was added up, and of those that move it on a finer lattice."""
        rows, clocks = self.counts.shape[0] * self.counts.shape[1], (self.clock, self.clock.finer())
        still, moved = (size_of(self.light.range_m.size, rows * clock.lattice.size) for clock in clocks)
        return still, moved

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
            return self.whole._before_trust(gain, effects)[self.frames]
        expected = self.model.expected(gain, together)
        if self.dead is not None and self.dead.any():
            expected = np.where(self.dead[:, None], 0.0, expected)
        return expected

    def without(self, gain: float, effects: tuple[Setting, ...], setting: Setting) -> Rendering:
        """What an effect that looks at the recording is shown: counts expected without it, and those recorded."""
        expected = self._before_trust(gain, tuple(other for other in effects if other is not setting))
        return replace(self.rendering(gain), expected=expected, recorded=self.recorded)

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
        tolerance = None if self.tolerance is None else self.tolerance[chosen]
        return replace(
            self,
            counts=self.counts[chosen],
            trust=tolerance if self.trust is self.tolerance else self.trust[chosen],
            tolerance=tolerance,
            loose=None if self.loose is None else self.loose[:, chosen],
            light=self.light.of(chosen),
            clock=clock,
            footprints=where,
            frames=self.frames[chosen],
            whole=whole,
        )
