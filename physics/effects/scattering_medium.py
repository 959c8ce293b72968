"""`scattering_medium`: fog, smoke, dust."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.intervals import best_interval
from physics.open_air import layers, open_air, ranges_of, through, way_in
from physics.rendering import Rendering
from physics.walk import SHORTEST_S, curve

# Extinctions of swathes, at so many even times and halfway between them.
HAZE = tuple(f"haze_{k}" for k in range(1, 7))
HALFWAY = tuple(f"halfway_{k}" for k in range(1, 6))
# Air half of whose light comes from nearer than this, metres, is the sensor's own window for all anybody can tell.
WINDOW_M = 0.1
# All zones look into the same air: where one sees this many times what most do it is rather a pulse of each.
UNEVEN = 1.5


class ScatteringMedium(Effect):
    """A medium of extinction α: light from range R is less by exp(-2αL), and air before it sends light back.

    L is how much of the way to R lies in the medium: all of it, or what is between `begin` and `begin` + `thickness`,
    whose edges are soft as if normally distributed by `soft`: a layer much softer than thick is a Gaussian of range.
    Scattering once, to all directions alike, a layer dr returns what a matt surface of ρ·cosθ = ω·α·dr/4 would; near
    the sensor emitter and receiver overlap in part, so that 1/r² becomes 1/(r² + overlap²), and 0 before `blind`. Each
    zone's medium reaches as far as its surfaces; pixels whose range is unknown have none. Zones may look into denser or
    thinner air. After t seconds the extinction is 1 + growth·t times that at the start, never less than none. Swathes
    that drift by add what a natural cubic spline through `haze_1`, ... at even times has, never less than none.
    """

    id = "scattering_medium"
    acts_on = "scene"
    order = 1  # All that comes from surfaces, by whatever way, is dimmed.
    sentence = "Fog, smoke or dust dims far surfaces and sends light back from the air before them."
    look_alikes = (
        LookAlike("ambient_pedestal", "Cover the emitter: backscatter goes, a pedestal stays."),
        LookAlike("cover_glass_crosstalk", "Clear the air: crosstalk stays, backscatter goes."),
        LookAlike("range_falloff", "Clear the air: falloff stays, extinction goes."),
        LookAlike("range_aliasing", "Clear the air: an aliased pulse stays, the light of a layer goes."),
    )
    forms = (
        ("extinction", "albedo", "overlap", "blind"),
        ("extinction", "albedo", "begin", "thickness"),
        ("extinction", "albedo", "begin", "thickness", "soft"),
        ("extinction", "albedo", "overlap", "blind", "growth"),
        ("extinction", "albedo", "begin", "thickness", "growth"),
        (*HAZE, "albedo", "overlap", "blind"),
        (*HAZE, *HALFWAY, "albedo", "overlap", "blind"),
        (*HAZE, "albedo", "begin", "thickness"),
    )
    richer = (forms[6],)
    parameters = (
        Parameter(
            "extinction",
            unit="1/m",
            low=0.0,
            high=10.0,
            start=0.03,
            vanishes_at=0.0,
            axis="zone",
            sentence="Part of the light lost by metre; one sees 3 / extinction far, 100 m at 0.03.",
        ),
        Parameter(
            "albedo",
            unit="1",
            low=0.0,
            high=30.0,
            start=1.0,
            sentence="Backscatter over that of a medium that scatters to all sides alike and absorbs nothing.",
        ),
        Parameter(
            "overlap",
            unit="m",
            low=1e-3,
            high=1.0,
            start=0.05,
            tries=(0.05, 0.3),
            sentence="Range at which emitter and receiver overlap by half.",
        ),
        Parameter(
            "blind",
            unit="m",
            low=0.0,
            high=1.0,
            start=0.0,
            sentence="Range before which they do not overlap at all.",
        ),
        Parameter(
            "begin",
            unit="m",
            low=0.0,
            high=20.0,
            start=0.0,
            sentence="Range at which the medium begins.",
        ),
        Parameter(
            "thickness",
            unit="m",
            low=0.01,
            high=100.0,
            start=100.0,
            sentence="How far it reaches from there.",
        ),
        Parameter(
            "soft", "m", 0.0, 5.0, 0.0, "Standard deviation by which its edges lie nearer or farther.", tries=(0.1,)
        ),
        Parameter("growth", "1/s", -1.0, 20.0, 0.0, "Part by which it is denser after a second, or thinner."),
        *(Parameter(name, "1/m", 0.0, 10.0, 0.03, "Extinction at this time.", vanishes_at=0.0) for name in HAZE),
        *(
            Parameter(name, "1/m", -10.0, 10.0, 0.01, "The same halfway to the next, above their mean.", 0.0)
            for name in HALFWAY
        ),
        Parameter("every", "s", SHORTEST_S, 1e5, SHORTEST_S, "From one of these times to the next."),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Extinction of what is there, and the backscatter of each zone's open air."""
        surfaces, ranges = rendering.arrivals, ranges_of(rendering.clock)
        alpha, way = _extinction(values, rendering.light.time_s), way_in(values, ranges)
        back = values["albedo"] / 4 * layers(values, rendering.clock, ranges)
        air = open_air(rendering.light, rendering.footprints, rendering.clock)
        return replace(surfaces, light=through(surfaces.light, air, alpha, way, back))

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """Air that shines at the sensor's own glass is that glass; nor does air differ much from zone to zone."""
        extinction = np.atleast_1d(values["extinction"]) + sum(values[name] for name in HAZE)
        if not extinction.any():
            return False
        ranges = ranges_of(rendering.clock)[:1, :1]
        until = np.cumsum(layers(values, rendering.clock, ranges).ravel())
        middle = ranges.ravel()[np.searchsorted(until, until[-1] / 2)]
        glass = until[-1] > 0 and middle < WINDOW_M  # What begins beyond the window shines nowhere.
        return bool(extinction.max() > UNEVEN * np.median(extinction) or glass)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The layer whose backscatter explains most of an excess; and swathes, in as many parts of the session."""
        clock, session_s = rendering.clock, float(np.ptp(rendering.light.time_s))
        swathes = [{name: self.parameter(name).start for name in HAZE} | {"every": session_s / (len(HAZE) - 1)}]
        swathes = swathes if swathes[0]["every"] > SHORTEST_S else []
        ranges = ranges_of(clock)
        everywhere = {p.name: p.start for p in self.parameters}
        air = layers(everywhere, clock, ranges) * open_air(rendering.light, rendering.footprints, clock)
        back = rendering.gain * Arrivals(air, clock.lattice, clock.bins).binned()
        light, noise = np.maximum(expected - rendering.background, 0), 1 / np.maximum(expected, 1)
        first, last, evidence = best_interval(
            (back * excess * noise).sum(axis=(0, 1)),
            (back**2 * noise).sum(axis=(0, 1)),
            (back * light * noise).sum(axis=(0, 1)),
            float((light**2 * noise).sum()),
        )
        if not evidence:
            return swathes
        late_s = float((clock.pulse.time_s * clock.pulse.probability).sum() + np.mean(clock.time_zero_s))
        begin, end = (speed_of_light / 2 * max(at * clock.bin_width_s - late_s, 0.0) for at in (first, last))
        low, high = self.parameter("begin").low, self.parameter("begin").high
        thickness = max(end - begin, speed_of_light / 2 * clock.bin_width_s)
        layer = {"begin": float(np.clip(begin, low, high)), "thickness": thickness}
        return [layer, *swathes, *(swathe | layer for swathe in swathes)]


def _extinction(values: Values, time_s: np.ndarray) -> np.ndarray:
    """(F, P or 1) 1/m at the times of frames."""
    found = np.atleast_1d(values["extinction"]) * np.maximum(1 + values["growth"] * time_s, 0)[:, None]
    at_times = np.array([values[name] for name in HAZE])
    heights = np.zeros(2 * len(HAZE) - 1)
    heights[::2] = at_times
    heights[1::2] = (at_times[1:] + at_times[:-1]) / 2 + [values[name] for name in HALFWAY]
    if values["every"] <= SHORTEST_S or not heights.any():
        return found
    return found + np.maximum(curve(heights, values["every"] / 2, time_s), 0)[:, None]


effect = ScatteringMedium()
