"""`pile_up`: one event per timing channel and laser shot."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from recordings.refusal import Refusal


class PileUp(Effect):
    """A channel registers the first photon after a shot and is dead for the rest of its cycle.

    Of N shots, with μ_t photons expected in bin t by shot and channel, the bin registers

        N · exp(-Σ_{s<t} μ_s) · (1 - exp(-μ_t))

    (Coates 1968, J. Phys. E 1, 878). A zone whose light is shared by n channels has μ = λ/n and n times N shots:
    `share` is 1/n. Where nobody says how many shots there were, `per_count` stands for share/N. Two zones may be timed
    by one converter, which what either sees keeps busy: of μ and ν in a bin, the zone that sees μ gets
    μ/(μ + ν)·(1 - exp(-μ - ν)), with `partner` of the neighbour's ν. Neighbours are zones 0 and 1, 2 and 3 and so on,
    or, with `next` 1, 1 and 2, 3 and 4, as in a TMF882x, whose reference shares a converter with its first zone.
    """

    id = "pile_up"
    acts_on = "detector"
    order = 1  # All light that arrives competes: pedestals and drifts come before.
    sentence = "A channel counts one photon per laser shot: the first one hides those that come later."
    look_alikes = (
        LookAlike(
            "range_walk", "Halve the laser power: range walk moves the pulse, pile-up also restores its late side."
        ),
        LookAlike(
            "counter_saturation", "Look at the flank of the pulse: clipping leaves it as it is, pile-up bends it."
        ),
        LookAlike(
            "gain_drift", "Compare dark and bright targets in one frame: drift scales both, pile-up only the bright."
        ),
    )
    forms = (("share",), ("per_count",), ("share", "partner"), ("per_count", "partner"))
    parameters = (
        Parameter(
            "share",
            unit="1",
            low=0.0,
            high=1.0,
            start=1.0,
            vanishes_at=0.0,
            axis="zone",
            sentence="Part of a zone's light that one timing channel receives: 1 where a zone has one channel.",
        ),
        Parameter(
            "per_count",
            unit="1",
            low=0.0,
            high=1.0,
            start=1e-5,
            vanishes_at=0.0,
            axis="zone",
            sentence="Photons in a shot and channel for each count expected: 1 over the shots where they are unknown.",
        ),
        Parameter(
            "partner", "1", 0.0, 1.0, 0.0, "Part of a neighbour's light that the same converter times.", tries=(1.0,)
        ),
        Parameter("next", "1", 0.0, 1.0, 0.0, "Whose neighbour that is: 0 of zones 0 and 1, 1 of 1 and 2."),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """First photons only."""
        cycles = rendering.light.laser_cycles
        rate = np.atleast_1d(values["per_count"])[:, None]
        if np.any(values["share"]):
            if cycles is None:
                raise Refusal("effect pile_up: laser_cycles is missing, expected the number of laser shots in a frame")
            rate = rate + np.atleast_1d(values["share"])[:, None] / cycles[:, None, None]
        rate = np.maximum(rate, np.finfo(float).tiny)
        per_shot = rendering.expected * rate
        # All that the converter meets: a neighbour's light goes through channels of the same shots.
        met = per_shot + values["partner"] * rate * neighbours(rendering.expected, round(values["next"]))
        earlier = np.cumsum(met, axis=-1) - met
        # expm1(-μ)/-μ, which is 1 where μ vanishes, keeps the counts exact at small rates.
        hidden = np.where(met > 0, -np.expm1(-met) / np.where(met > 0, met, 1), 1)
        return rendering.expected * np.exp(-earlier) * hidden

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The other neighbour."""
        return [{"partner": 1.0, "next": 1.0}] if expected.shape[1] > 2 else []

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """How many shots there were need not be guessed where it is known."""
        return bool(np.any(values["per_count"])) and rendering.light.laser_cycles is not None


def neighbours(expected: np.ndarray, following: int) -> np.ndarray:
    """What each zone's neighbour receives, 0 where it has none. (F, P, T); following: 0 or 1, the parameter `next`."""
    zones = np.arange(expected.shape[1])
    other = following + ((zones - following) ^ 1)
    there = (zones >= following) & (other < len(zones))
    return np.where(there[:, None], expected[:, np.where(there, other, 0)], 0)


effect = PileUp()
