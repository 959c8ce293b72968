"""`cover_glass_crosstalk`: laser light that never leaves the package."""

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from recordings.refusal import Refusal

# A normal density by nine points, of mean 0 and variance 1 (Gauss and Hermite).
NODES, _weights = np.polynomial.hermite_e.hermegauss(9)
WEIGHTS = _weights / _weights.sum()


class CoverGlassCrosstalk(Effect):
    """Light reflected inside the package and by the cover glass: a pulse next to time zero, in every frame alike."""

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
        ("share", "delay", "longer", "together"),
        ("counts", "delay", "longer", "together"),
    )
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
        # Millimetres of way inside the package; time zero itself is known to a part of a bin.
        Parameter(
            "delay",
            unit="s",
            low=-2e-10,
            high=1e-9,
            start=2e-10,
            sentence="Arrival after that of a target at range 0.",
        ),
        Parameter(
            "together",
            "1",
            0.0,
            1.0,
            0.0,
            "1 where it arrives at one time by the clock, whatever each zone's time zero.",
        ),
        Parameter("longer", "s", 0.0, 5e-10, 0.0, "Standard deviation of the time that its ways take.", tries=(1e-10,)),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """As much light more as gives these counts, at one time."""
        cycles, share = rendering.light.laser_cycles, np.atleast_1d(values["share"])
        if cycles is None and share.any():
            raise Refusal(
                "effect cover_glass_crosstalk: laser_cycles is missing, expected the number of laser shots in a frame"
            )
        if not rendering.gain > 0:
            raise Refusal(f"effect cover_glass_crosstalk: gain is {rendering.gain:g}, expected above 0")
        counts = np.atleast_1d(values["counts"]) + (0.0 if cycles is None else share * cycles[:, None])
        found, zero = rendering.arrivals, np.asarray(rendering.clock.time_zero_s)
        at = zero + values["together"] * (zero.mean(axis=-1, keepdims=True) - zero) + values["delay"]
        for node, weight in zip(NODES, WEIGHTS, strict=True) if values["longer"] else ((0.0, 1.0),):
            found = found.added(weight * counts / rendering.gain, at + node * values["longer"])
        return found


effect = CoverGlassCrosstalk()
