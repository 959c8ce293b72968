"""The camera takes the rows of its image one after another."""

from dataclasses import replace
from itertools import zip_longest
from typing import Any

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.followed import followed
from physics.light import Light, Return
from physics.light_between import around, light_at
from physics.rendering import Rendering
from physics.told_between import carries

# Rows are taken together in so many bands.
BANDS = 6
# Of the step between frames a fit begins with this part.
PART = 0.2


class RollingShutter(Effect):
    """The last row of an image is taken `readout` seconds after the first; the one at `stamped` when the LiDAR looks.

    What the LiDAR sees of a row is what that row shows in a frame so much earlier, or later: between frames pixel by
    pixel as `light_at` has it, or where more than half is `carried` along as `followed` has.
    """

    id = "rolling_shutter"
    acts_on = "scene"
    order = -9  # It is the camera's image that is amiss, before all that light does.
    sentence = "the camera takes the rows of its image one after another while things move"
    look_alikes = tuple(
        LookAlike(name, "Mount the camera upside down: the first rows become the last, a delay stays as it was.")
        for name in ("time_lag", "time_zero_drift")
    )
    forms = (("readout",), ("readout", "stamped"))
    parameters = (
        Parameter("readout", "s", -1.0, 1.0, 0.02, "How much later the last row is than the first.", 0.0),
        Parameter("stamped", "1", 0.0, 1.0, 0.5, "Where in the image that is, 0 at its first row, 1 at its last."),
        Parameter("carried", "1", 0.0, 1.0, 0.0, "1 where things are carried along between frames."),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """Seconds before and after a frame from which its light comes."""
        most = abs(values["readout"])
        return most, most

    def carries(self, values: Values) -> bool:
        """See `Effect`."""
        return bool(values["readout"]) and values["carried"] > 0.5

    def light(self, values: Values, rendering: Rendering) -> Light:
        """Each band of rows as it is when the LiDAR looks."""
        light, readout = rendering.light, values["readout"]
        if not readout:
            return light
        times, along = np.asarray(light.time_s, float), self.carries(values)

        def at(then: np.ndarray) -> Light:
            return followed(light, *around(times, then, 0.0), then) if along else light_at(light, then)

        parts = (np.arange(BANDS) + 0.5) / BANDS - values["stamped"]
        bands = [at(times - readout * part) for part in parts]
        return _by_rows(light, bands)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """Either way by part of a step between frames; carried along where frames say that things are."""
        light = rendering.light
        step_s = float(np.median(np.diff(light.time_s))) if light.frames > 1 else 0.0
        if not step_s > 0:
            return []
        ways = [{}, {"carried": 1.0}] if carries(rendering) else [{}]
        readout = min(PART * step_s, self.parameter("readout").high)
        return [{"readout": sign * readout} | way for way in ways for sign in (1.0, -1.0)]


def _by_rows(light: Light, bands: list[Light]) -> Light:
    """Light of which each band of rows is that of another."""
    height = light.range_m.shape[1]
    which = np.arange(height) * len(bands) // height

    def chosen(each: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([one[:, which == i] for i, one in enumerate(each)], axis=1)

    none = Return(np.ones_like(light.range_m), np.zeros_like(light.range_m))
    ways = zip_longest(*(band.returns for band in bands), fillvalue=none)
    returns = tuple(Return(chosen([w.range_m for w in way]), chosen([w.strength for w in way])) for way in ways)
    fields = {name: chosen([getattr(band, name) for band in bands]) for name in ("range_m", "reflectance", "cosine")}
    return replace(light, returns=returns, **fields)


effect = RollingShutter()
