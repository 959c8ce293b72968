"""`zone_gain`: zones are more or less sensitive than their response maps say."""

from dataclasses import replace

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class ZoneGain(Effect):
    """All laser light that a zone receives is counted with one factor, whatever way it came: `factor` of each, and
    exp(one) in zone number `zone` alone. Over the grid of zones a chip that is warmer at one end, and a lens that
    shades, make it exp(across · c + down · r + bow · d²), with c and r from -1 in the first column and row to 1 in the
    last, and d the distance from the middle in a grid of squares, 1 in the corners;
    converters that take turns make it exp(alternate) in every other zone and the inverse in those between. What became
    less sensitive since the background was recorded counts that with the same factor, to the power of `ambient`.
    """

    id = "zone_gain"
    acts_on = "optics"
    order = 1  # Sensitivity concerns stray light and crosstalk too: they come before.
    sentence = "A zone counts its laser light with a factor of its own, the same at all ranges and times."
    look_alikes = (
        LookAlike(
            "reflectance_map",
            "Turn the sensor about its axis: a gain stays with the zone, reflectance with the surface.",
        ),
        LookAlike(
            "stray_light", "Cover half of the target: a gain still multiplies, stray light adds what others see."
        ),
        LookAlike("gain_drift", "Repeat the first capture at the end: a gain is as it was, a drift is not."),
    )
    forms = (
        ("factor",),
        ("factor", "ambient"),
        ("one",),
        ("across", "down"),
        ("across", "down", "bow"),
        ("alternate",),
    )
    # A factor that all zones have is the gain, or the recorded background's.
    uneven = forms[:2]
    parameters = (
        Parameter(
            "factor",
            unit="1",
            low=0.0,
            high=10.0,
            start=1.1,
            vanishes_at=1.0,
            axis="zone",
            sentence="Counts of the zone over those that its response map gives.",
        ),
        Parameter("one", "1", -10.0, 3.0, 0.1, "Logarithm of the factor of zone `zone`.", vanishes_at=0.0),
        Parameter("zone", "1", 0.0, 1e4, 0.0, "Number of that zone, from 0."),
        Parameter("across", "1", -3.0, 3.0, 0.1, "Logarithm by which the last column is above the middle.", 0.0),
        Parameter("down", "1", -3.0, 3.0, 0.1, "Logarithm by which the last row is above the middle.", 0.0),
        Parameter("bow", "1", -3.0, 3.0, -0.1, "Logarithm by which the corners are above the middle.", 0.0),
        Parameter("alternate", "1", -3.0, 3.0, 0.1, "Logarithm of the factor of every other zone.", 0.0),
        Parameter("ambient", "1", 0.0, 1.0, 0.0, "1 where all light counts so, 0 where the laser's.", tries=(1.0,)),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Each zone's light, multiplied."""
        light = rendering.arrivals.light * _factors(values, rendering)[:, None]
        return replace(rendering.arrivals, light=light)

    def background(self, values: Values, rendering: Rendering) -> np.ndarray | float:
        """What no laser sent, likewise."""
        if not values["ambient"]:
            return rendering.background
        return rendering.background * (_factors(values, rendering) ** values["ambient"])[:, None]

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The zone whose light is off by most, in standard deviations."""
        light = np.maximum(expected - rendering.background, 0)
        told = light / np.maximum(expected, 1e-9)
        sigmas = (told * excess).sum(axis=(0, 2)) / np.sqrt(np.maximum((told * light).sum(axis=(0, 2)), 1e-9))
        return [{"one": self.parameter("one").start, "zone": float(np.argmax(np.abs(sigmas)))}]


def _factors(values: Values, rendering: Rendering) -> np.ndarray:
    """(P,) of each zone."""
    row, column = np.indices(rendering.footprints.zone_grid).reshape(2, -1)
    factors = np.broadcast_to(values["factor"], row.shape).astype(float)
    factors[np.arange(len(row)) == round(values["zone"])] *= np.exp(values["one"])
    rows, columns = (max(n - 1, 1) for n in rendering.footprints.zone_grid)
    c, r = 2 * column / columns - 1, 2 * row / rows - 1
    square = (column - column.max() / 2) ** 2 + (row - row.max() / 2) ** 2
    square = square / max(float(square.max()), 1e-9)
    sloped = values["across"] * c + values["down"] * r + values["bow"] * square
    return factors * np.exp(sloped + values["alternate"] * (1 - 2 * ((row + column) % 2)))


effect = ZoneGain()
