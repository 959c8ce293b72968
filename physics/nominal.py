"""The nominal model, and effects on top of it: expected counts of a scene.

signal[f,p,t] = gain · Σ_u w_p(u) · ρ·cosθ/r² · ∫_bin t IRF(τ − time_zero_p − 2r/c) dτ
expected[f,p,t] = signal[f,p,t] + background_p
"""

import math
import threading
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from physics.arrivals import Arrivals, arrivals
from physics.clock import Clock
from physics.footprint import Footprints
from physics.growing import between
from physics.kept import same_knots
from physics.light import Light
from physics.rendering import NOUNS, Rendering
from physics.setting import Setting, in_order
from recordings.refusal import Refusal

# What was made is kept under so many keys, as fits come back to where they were; only under the last one where
# numbers for one key are more than this.
KEPT = 4
MANY = 1 << 22


class ForwardModel:
    """Expected counts of F frames as a function of gain and effects.

    light, footprints, clock: the scene and the sensor without effects. background: (P,) or one number, counts per bin.
    recorded: (F, P, T) counts of these frames, for effects that only a frame itself can place.
    What nothing has changed since the last calls is not made again, so that a fit which varies a parameter of the
    detector renders once; each thread has its own. It holds arrivals of F × P zones: give many frames in batches.
    """

    def __init__(
        self,
        light: Light,
        footprints: Footprints,
        clock: Clock,
        background: np.ndarray | float | None = None,
        recorded: np.ndarray | None = None,
    ) -> None:
        level = np.atleast_1d(np.asarray(0.0 if background is None else background, float))[:, None]
        self._start = Rendering(light, footprints, clock, gain=1.0, background=level, recorded=recorded)
        self._kept = threading.local()

    def expected(self, gain: float = 1.0, effects: Iterable[Setting] = ()) -> np.ndarray:
        """(F, P, T) expected counts; raises `Refusal` where an effect makes counts that cannot be.

        Frames that were taken before an effect set in are as they are without it. One that grows is as strong in each
        as it is then.
        """
        settings = in_order(tuple(effects))
        growing = next((setting for setting in settings if setting.grows), None)
        if growing is None:
            return self._from_when_on(gain, settings)
        others = tuple(setting for setting in settings if setting is not growing)
        light = self._start.light
        every = light if light.part_of is None else light.part_of[0]  # In some frames as in all.
        return between(
            growing.degree(light.time_s),
            float(growing.degree(every.time_s).max(initial=0.0)),
            lambda degree: self.expected(gain, (*others, growing.times(degree)) if degree else others),
        )

    def _from_when_on(self, gain: float, settings: tuple[Setting, ...]) -> np.ndarray:
        """(F, P, T) expected counts with effects that are there from some frame on."""
        time_s = np.asarray(self._start.light.time_s)
        found, first = None, float(time_s.min(initial=np.inf))
        for onset in sorted({first, *(s.since_s for s in settings if s.since_s > first)}):
            there = tuple(s.with_value("since", 0.0) if s.since_s else s for s in settings if s.since_s <= onset)
            made = self._always(gain, there)
            found = made if found is None else np.where(time_s[:, None, None] >= onset, made, found)
        return found

    def _always(self, gain: float, settings: tuple[Setting, ...]) -> np.ndarray:
        """(F, P, T) expected counts with effects that are there in all frames."""
        now, key = replace(self._start, gain=float(gain)), ()
        for noun in NOUNS:
            if noun == "arrivals":
                if any(setting.effect.moves_light(setting.values) for setting in settings):
                    now, key = replace(now, clock=now.clock.finer()), (*key, "finer")
                now = replace(now, arrivals=self._once("bare arrivals", key, partial(self._bare, now)))
            if noun == "expected":
                signal = self._once("signal", key, now.arrivals.binned)
                if not math.isfinite(float(gain) * float(signal.max(initial=0))):
                    raise Refusal(f"expected counts are not finite at a gain of {gain:g}, expected numbers")
                counts = gain * signal
                counts += now.background  # In place: no third array.
                now = replace(now, expected=counts)
            acting = [setting for setting in settings if noun in setting.effect.changes]
            # Where zones look goes by where things are, not by how bright they are.
            still = noun == "footprints" and now.light.range_m is self._start.light.range_m
            made_by = () if still else key
            for i, setting in enumerate(acting):
                # How bright it is may matter to when light is registered.
                if noun != "background":  # The signal does not depend on it.
                    this = (noun, gain if noun == "arrivals" else None, setting.key)
                    key, made_by = (*key, *this), (*made_by, *this)
                made = self._once(f"{noun} {i}", made_by, partial(_through, now, setting, noun))
                now = replace(now, **{noun: made})
        return now.expected

    def _once(self, name: str, key: tuple, make: Callable[[], Any]) -> Any:
        """What `make` makes, or made before under this key; expected counts depend on more than keys say."""
        if name.startswith(("background ", "expected ")):
            return make()
        kept = self._kept.__dict__.setdefault(name, {})
        made = kept.pop(key) if key in kept else make()
        while len(kept) >= self._room:
            del kept[next(iter(kept))]  # The one that was not asked for longest.
        kept[key] = made
        return made

    @cached_property
    def _room(self) -> int:
        """Under how many keys things are kept."""
        frames, height, width = self._start.light.range_m.shape
        knots = self._start.footprints.seen[0][1].shape[1] * self._start.clock.lattice.size
        return KEPT if frames * (height * width + knots) < MANY else 1

    def _bare(self, now: Rendering) -> Arrivals:
        """Arrivals before effects on them; a pulse that changes on the steps it had leaves them as they are."""
        kept = self._kept.__dict__.get("latest")
        if kept is not None:
            light, footprints, clock, made = kept
            if light is now.light and footprints is now.footprints and same_knots(now.clock, clock):
                # What arrives later than a shorter pulse is seen for is left out.
                lattice = now.clock.lattice
                return Arrivals(np.ascontiguousarray(made.light[..., : lattice.size]), lattice, now.clock.bins)
        made = arrivals(now.light, now.footprints, now.clock)
        self._kept.__dict__["latest"] = now.light, now.footprints, now.clock, made
        return made


def _through(now: Rendering, setting: Setting, noun: str) -> Any:
    """The field `noun` after an effect that acts on it."""
    made = setting.effect.apply(noun, setting.values, now)
    if noun == "expected" and not (made >= 0).all():
        index = tuple(int(i) for i in np.argwhere(~(made >= 0))[0])
        raise Refusal(f"expected counts{list(index)} are {made[index]} after {setting.effect.id}, expected 0 or more")
    return made
