"""`bin_phase`: how well a pulse is registered depends on where in its bin it falls."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.about_highest import centroid
from physics.arrivals import Arrivals
from physics.clock import Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.highest_pulse import highest_turns
from physics.largest_share import PHASES, largest_part, largest_share
from physics.phase_wave import wave
from physics.rendering import Rendering

# Between two knots the modulation is taken to be linear: off by (π / knots)² / 2 of the depth at most, 0.5 %.
LEAST_PER_BIN = 32

# Harmonics of the phase that a shape other than a cosine has.
HIGHER = ("cos_2", "sin_2", "cos_3", "sin_3")


class BinPhase(Effect):
    """Light whose nominal arrival is t after the start of bin 0 counts 1 + depth · cos(2π(t/bin_width − phase)) times.

    The first harmonic of what a later step makes of a sampled pulse: the largest of the bins, for one, is lower where
    the pulse is shared by two. Ambient light and what else has no time arrives at all phases alike and stays.

    Where that step looks at the pulse of a zone and frame as a whole, all of its light counts
    1 + whole · cos(2π(t̄/bin_width − phase)) times, t̄ the mean nominal arrival of light that the window can see; or,
    where it looks at the highest pulse alone, of what of that light is in it (`highest` 1), or in the part `within` of
    it about its peak. Firmware takes the centroid of the signal in the highest bin and `about` bins to either side of
    it for t̄; below one bin it does so in part.

    A peak of bins or a sawtooth has higher harmonics: with `cos_2` ... `sin_3` of cosine and sine at twice and three
    times the phase on top of each cosine above.

    So where the bins of each zone begin elsewhere and each has a phase of its own: all light of a zone and frame counts
    1 + along · cos(2πt̄/bin_width) + across · sin(2πt̄/bin_width) times.

    Where the largest bin of a histogram tells, all light of a zone and frame counts by the part of it that is in there,
    over the mean such part of a pulse alone, to the power of `peaked`: less, too, where depths differ.

    Maps that were read off the largest bin in a scan hold it as well: over the plane of the scan the pulse's place in
    its bin goes round with distance, in rings, by which zones do not see better or worse. They are maps over the
    largest bin's share there, of its mean, to the power of `ringed`.
    """

    id = "bin_phase"
    acts_on = "estimator"
    sentence = "What is made of a pulse is more or less, depending on where in its bin the pulse falls."
    look_alikes = (
        LookAlike("bin_nonlinearity", "Cover the emitter and look at the ambient pedestal: only unequal bins show."),
        LookAlike(
            "range_falloff",
            "Step a target finely through one bin of range: this comes back with each bin, falloff does not.",
        ),
        LookAlike("reflectance_map", "Step one target by half a bin of range: its reflectance is what it was."),
    )
    forms = (
        ("depth", "phase"),
        ("whole", "phase"),
        ("whole", "phase", "highest"),
        ("whole", "phase", "highest", "within"),
        ("whole", "phase", "about"),
        ("along", "across"),
        ("ringed",),
        ("peaked",),
        ("depth", "phase", *HIGHER),
        ("whole", "phase", *HIGHER),
        ("whole", "phase", "highest", "within", *HIGHER),
        ("whole", "phase", "about", *HIGHER),
    )
    richer = forms[-4:]
    # With one value for all it is `whole` and a phase, which may have harmonics.
    uneven = (("along", "across"),)
    parameters = (
        Parameter(
            "depth",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.05,
            vanishes_at=0.0,
            axis="zone",
            sentence="By what part counts at the best phase exceed their mean.",
        ),
        Parameter(
            "whole",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.05,
            vanishes_at=0.0,
            axis="zone",
            sentence="The same where all light of a zone and frame goes by the phase of its mean arrival.",
        ),
        Parameter(
            "phase",
            unit="bins",
            low=0.0,
            high=1.0,
            start=0.25,
            tries=(0.0, 0.25, 0.5, 0.75),  # One of them is at most an eighth of a turn away.
            sentence="Where in its bin the pulse counts most: 0 at either edge, 0.5 in the middle.",
        ),
        Parameter(
            "highest", "1", 0.0, 1.0, 0.0, "1 where the highest pulse alone tells, 0 where all do.", tries=(1.0,)
        ),
        Parameter("within", "1", 0.05, 1.0, 1.0, "Part of that pulse about its peak that tells.", tries=(0.25,)),
        Parameter("about", "bins", 0.0, 20.0, 0.0, "Bins beside the highest that tell; 0 where all do.", tries=(3.0,)),
        Parameter(
            "along", "1", -1.0, 1.0, 0.05, "By what part a pulse at either edge of a bin counts more.", 0.0, axis="zone"
        ),
        Parameter(
            "across",
            unit="1",
            low=-1.0,
            high=1.0,
            start=0.05,
            vanishes_at=0.0,
            tries=(0.05, -0.05),  # One of them, or its opposite, is at most an eighth of a turn away.
            axis="zone",
            sentence="By what part one counts more that is a quarter of a bin after its start.",
        ),
        Parameter("peaked", "1", 0.0, 3.0, 0.3, "Power of the largest bin's share by which light counts.", 0.0),
        Parameter(
            "ringed", "1", 0.0, 20.0, 1.0, "Power of the largest bin's share that maps hold; 1 where they are its.", 0.0
        ),
        Parameter("taken_at", "m", 0.0, 100.0, 0.0, "Depth of the plane they were taken in; 0 where maps say it."),
        *(
            Parameter(
                name, "1", -2.0, 2.0, 0.0, f"How much of the {name[:3]}ine at {name[-1]} times the phase comes on top."
            )
            for name in HIGHER
        ),
    )

    def in_scene(self, values: Values) -> bool:
        """Where maps hold it."""
        return bool(values["ringed"])

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints freed of rings, which a scan of unknown depth does not tell."""
        depth, clock = values["taken_at"] or rendering.footprints.calibration_range_m, rendering.clock
        if not values["ringed"] or not np.isfinite(depth):
            return rendering.footprints
        zero = np.atleast_2d(clock.time_zero_s).mean(axis=0)[:, None, None]
        arrival_s = zero + 2 / speed_of_light * depth * np.linalg.norm(rendering.light.rays, axis=-1)
        shares = largest_share(clock.pulse, clock.bin_width_s)
        turns, steps = arrival_s / clock.bin_width_s, np.arange(PHASES) / PHASES
        held = np.interp(turns % 1, steps, shares, period=1) / shares.mean()
        return rendering.footprints.changed(lambda weights: (weights / held ** values["ringed"]).astype(weights.dtype))

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """The same clock, on a lattice fine enough to tell phases apart."""
        if not np.any(values["depth"]):
            return rendering.clock
        return rendering.clock.finer(LEAST_PER_BIN)

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light times what its phase makes of it."""
        arrivals, lattice = rendering.arrivals, rendering.arrivals.lattice
        knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
        turns = knots_s / rendering.clock.bin_width_s
        depth, whole, along, across = (
            np.atleast_1d(values[name])[:, None] for name in ("depth", "whole", "along", "across")
        )
        # Light between two knots meets the wave's chord, which is flatter than the wave by sinc².
        times = 1 + depth * wave(values, turns - values["phase"], lattice.per_bin)
        if whole.any() or along.any() or across.any():
            received = arrivals.light.sum(axis=-1, keepdims=True)
            # Light given to two knots in proportion keeps its mean time.
            mean = (arrivals.light @ turns)[..., None] / np.where(received > 0, received, 1)
            if values["highest"]:
                mean = mean + values["highest"] * (highest_turns(arrivals, rendering.clock, values["within"]) - mean)
            whole = whole * (1 - min(values["about"], 1))
            own = along * np.cos(2 * np.pi * mean) + across * np.sin(2 * np.pi * mean)
            times = times * np.maximum(1 + whole * wave(values, mean - values["phase"]) + own, 0)
        if values["peaked"]:
            alone = largest_share(rendering.clock.pulse, rendering.clock.bin_width_s).mean()
            times = times * ((largest_part(arrivals) / alone) ** values["peaked"])[..., None]
        return replace(arrivals, light=arrivals.light * np.maximum(times, 0))

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Signal times what the phase of its centroid makes of it."""
        share = min(values["about"], 1)
        if not share:
            return rendering.expected
        signal = rendering.expected - np.minimum(rendering.background, rendering.expected)
        turns = centroid(signal, values["about"]) - values["phase"]
        return rendering.expected + share * np.atleast_1d(values["whole"])[:, None] * wave(values, turns) * signal


effect = BinPhase()
