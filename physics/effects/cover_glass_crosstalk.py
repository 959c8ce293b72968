"""`cover_glass_crosstalk`: laser light that never leaves the package."""

from dataclasses import replace
from itertools import product

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from recordings.refusal import Refusal

# A normal density by nine points, of mean 0 and variance 1 (Gauss and Hermite).
NODES, _weights = np.polynomial.hermite_e.hermegauss(9)
WEIGHTS = _weights / _weights.sum()
# An exponential one of time constant 1: by parts of so long, each at its mean.
PART, LAST = 0.2, 8.0
_ends = np.arange(0, LAST, PART)
_left, _late = np.append(np.exp(-_ends), 0.0), np.append((_ends + 1) * np.exp(-_ends), 0.0)
SHARES = -np.diff(_left)
LATER = -np.diff(_late) / SHARES
# Delays that a fit may begin with are looked through in steps of this part of a bin.
PER_BIN = 4
NOTHING = 1e-9


class CoverGlassCrosstalk(Effect):
    """Light reflected inside the package and by the cover glass: a pulse next to time zero, whatever is in view.

    After t seconds there is 1 + growth·t times as much as at the start, never less than none. Ways that the light takes
    differ by a normal distribution, or, where it is thrown to and fro in the glass, are longer by an exponential one;
    or there are two of them, as from both faces of a glass, or from package and glass: a part comes `again`.
    """

    id = "cover_glass_crosstalk"
    acts_on = "optics"
    sentence = "Laser light reaches the detector inside the package, as a pulse near time zero that no target moves."
    look_alikes = (
        LookAlike(
            "scattering_medium", "Clear the air, or look from zero range on: crosstalk is one pulse, fog a ramp."
        ),
        LookAlike("stray_light", "Point the sensor at the open sky: crosstalk stays, stray light goes."),
        LookAlike("second_surface", "Step the target in range: crosstalk stays where it is, a second surface moves."),
    )
    forms = (
        ("share", "delay"),
        ("counts", "delay"),
        ("share", "delay", "growth"),
        ("counts", "delay", "growth"),
        ("share", "delay", "longer", "together"),
        ("counts", "delay", "longer", "together"),
        ("share", "delay", "trail"),
        ("counts", "delay", "trail"),
        ("share", "delay", "again", "again_later"),
        ("counts", "delay", "again", "again_later"),
    )
    richer = forms[-2:]
    parameters = (
        Parameter(
            "share",
            unit="1",
            low=0.0,
            high=1.0,
            start=1e-3,
            vanishes_at=0.0,
            axis="zone",
            sentence="Counts per laser shot; 0.0002 to 0.003 is common.",
        ),
        Parameter(
            "counts",
            unit="counts",
            low=0.0,
            high=1e7,
            start=10.0,
            vanishes_at=0.0,
            axis="zone",
            sentence="Counts per frame, where nobody knows how many laser shots there are in one.",
        ),
        # Millimetres of way inside the package; time zero itself is known to about a bin.
        Parameter("delay", "s", -1e-9, 1e-9, 2e-10, "Arrival after that of a target at range 0."),
        Parameter("together", "1", 0.0, 1.0, 0.0, "1 where it arrives at one time, whatever each zone's time zero."),
        Parameter("longer", "s", 0.0, 1e-9, 0.0, "Standard deviation of the time that its ways take.", tries=(1e-10,)),
        Parameter("trail", "s", 0.0, 2e-9, 0.0, "Time constant of what comes later, exponentially.", tries=(2e-10,)),
        Parameter("again", "1", 0.0, 10.0, 0.0, "A second pulse, over the first.", tries=(0.3,)),
        Parameter("again_later", "s", 0.0, 2e-9, 0.0, "How much later that comes.", tries=(3e-10, 8e-10)),
        Parameter("growth", "1/s", -1.0, 1e3, 0.0, "Part by which it is more after a second, as the glass gets dirty."),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """As much light more as gives these counts, at one time."""
        cycles, per_shot = rendering.light.laser_cycles, np.atleast_1d(values["share"])
        if cycles is None and per_shot.any():
            raise Refusal(
                "effect cover_glass_crosstalk: laser_cycles is missing, expected the number of laser shots in a frame"
            )
        if not rendering.gain > 0:
            raise Refusal(f"effect cover_glass_crosstalk: gain is {rendering.gain:g}, expected above 0")
        counts = np.atleast_1d(values["counts"]) + (0.0 if cycles is None else per_shot * cycles[:, None])
        counts = counts * np.maximum(1 + values["growth"] * rendering.light.time_s, 0)[:, None]
        found, zero = rendering.arrivals, np.asarray(rendering.clock.time_zero_s)
        at = np.atleast_2d(zero + values["together"] * (zero.mean(axis=-1, keepdims=True) - zero) + values["delay"])
        # One count by zone, of one frame where zeros stay.
        one = replace(found, light=np.zeros((len(at), *found.light.shape[1:])))
        spread = zip(NODES, WEIGHTS, strict=True) if values["longer"] else ((0.0, 1.0),)
        trail = zip(LATER, SHARES, strict=True) if values["trail"] else ((0.0, 1.0),)
        twice = ((0.0, 1.0), (values["again_later"], values["again"])) if values["again"] else ((0.0, 1.0),)
        for (node, weight), (late, share), (later, part) in product(spread, trail, twice):
            one = one.added(weight * share * part, at + node * values["longer"] + late * values["trail"] + later)
        return replace(found, light=found.light + (counts / rendering.gain)[..., None] * one.light)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The delay at which most is in excess, in each zone what it is: a filter matched to the pulse (Turin 1960)."""
        delay, clock = self.parameter("delay"), rendering.clock
        summed, noise = excess.sum(axis=0), np.maximum(expected.sum(axis=0), 1)
        zero = np.atleast_2d(clock.time_zero_s).mean(axis=0)
        best = 0.0, delay.start
        for at in np.arange(delay.low, delay.high, clock.bin_width_s / PER_BIN):
            pulse = clock.pulse.in_bins(zero + at, clock.bins, clock.bin_width_s)
            found, information = ((pulse * of / noise).sum(axis=-1) for of in (summed, pulse))
            best = max(best, (float((np.maximum(found, 0) ** 2 / np.maximum(information, NOTHING)).sum()), float(at)))
        return [{"delay": best[1]}]


effect = CoverGlassCrosstalk()
