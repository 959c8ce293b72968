"""The nominal model, and effects on top of it: expected counts of a scene.

signal[f,p,t] = gain · Σ_u w_p(u) · ρ·cosθ/r² · ∫_bin t IRF(τ − time_zero_p − 2r/c) dτ
expected[f,p,t] = signal[f,p,t] + background_p
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from physics.arrivals import arrivals
from physics.clock import Clock
from physics.effect import Setting, in_order
from physics.footprint import Footprints
from physics.light import Light
from physics.rendering import NOUNS, Rendering
from recordings.refusal import Refusal


class ForwardModel:
    """Expected counts of F frames as a function of gain and effects.

    light, footprints, clock: the scene and the sensor without effects. background: (P,) or one number, counts per bin.
    What nothing has changed since the last call is not made again, so that a fit which varies a parameter of the
    detector renders once. It holds arrivals of F × P zones: give many frames in batches.
    """

    def __init__(
        self, light: Light, footprints: Footprints, clock: Clock, background: np.ndarray | float | None = None
    ) -> None:
        level = np.atleast_1d(np.asarray(0.0 if background is None else background, float))[:, None]
        self._start = Rendering(light, footprints, clock, gain=1.0, background=level)
        self._kept: dict[str, tuple[tuple, Any]] = {}

    def expected(self, gain: float = 1.0, effects: Iterable[Setting] = ()) -> np.ndarray:
        """(F, P, T) expected counts; raises `Refusal` where an effect makes counts that cannot be."""
        settings = in_order(tuple(effects))
        now, key = replace(self._start, gain=float(gain)), ()
        for noun in NOUNS:
            if noun == "arrivals":
                bare = self._once("bare arrivals", key, partial(arrivals, now.light, now.footprints, now.clock))
                now = replace(now, arrivals=bare)
            if noun == "expected":
                signal = self._once("signal", key, now.arrivals.binned)
                counts = gain * signal
                counts += now.background  # In place: no third array.
                now = replace(now, expected=counts)
            acting = [setting for setting in settings if noun in setting.effect.changes]
            if acting:
                # How bright it is may matter to when light is registered.
                if noun != "background":  # The signal does not depend on it.
                    key = (*key, noun, gain if noun == "arrivals" else None, *(setting.key for setting in acting))
                now = replace(now, **{noun: self._once(noun, key, partial(_through, now, acting, noun))})
        return now.expected

    def _once(self, name: str, key: tuple, make: Callable[[], Any]) -> Any:
        """What `make` makes, or made the last time under this key; expected counts depend on more than keys say."""
        if name in ("background", "expected"):
            return make()
        if name not in self._kept or self._kept[name][0] != key:
            self._kept[name] = key, make()
        return self._kept[name][1]


def _through(now: Rendering, acting: list[Setting], noun: str) -> Any:
    """The field `noun` after all effects that act on it."""
    for setting in acting:
        now = replace(now, **{noun: setting.effect.apply(noun, setting.values, now)})
    if noun == "expected" and not (now.expected >= 0).all():
        index = tuple(int(i) for i in np.argwhere(~(now.expected >= 0))[0])
        names = ", ".join(setting.effect.id for setting in acting)
        raise Refusal(f"expected counts{list(index)} are {now.expected[index]} after {names}, expected 0 or more")
    return getattr(now, noun)
