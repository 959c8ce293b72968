"""`pile_up`: one event per timing channel and laser shot."""

from typing import Any

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from recordings.refusal import Refusal

# Standard deviations, of two zones together, from which they may share a converter.
SHOWN = 3.0


class PileUp(Effect):
    """A channel registers the first photon after a shot and is dead for the rest of its cycle.

    Of N shots, with μ_t photons expected in bin t by shot and channel, the bin registers

        N · exp(-Σ_{s<t} μ_s) · (1 - exp(-μ_t))

    (Coates 1968, J. Phys. E 1, 878). A zone whose light is shared by n channels has μ = λ/n and n times N shots:
    `share` is 1/n. Where nobody says how many shots there were, `per_count` stands for share/N. Two zones may be timed
    by one converter, which what either sees keeps busy: of μ and ν in a bin, the zone that sees μ gets
    μ/(μ + ν)·(1 - exp(-μ - ν)), with `partner` of the other's ν. `other` says which zone that is.
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
            "partner", "1", 0.0, 1.0, 0.0, "Part of another zone's light that the same converter times.", tries=(1.0,)
        ),
        Parameter(
            "other",
            unit="1",
            low=-1.0,
            high=1e6,
            start=-1.0,
            axis="zone",
            sentence="Which zone that is, its own number where none; -1 where zones 0 and 1, 2 and 3 go together.",
        ),
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
        # All that the converter meets: another zone's light goes through channels of the same shots.
        met = per_shot + values["partner"] * rate * light_of_others(values, rendering.expected)
        earlier = np.cumsum(met, axis=-1) - met
        # expm1(-μ)/-μ, which is 1 where μ vanishes, keeps the counts exact at small rates.
        hidden = np.where(met > 0, -np.expm1(-met) / np.where(met > 0, met, 1), 1)
        return rendering.expected * np.exp(-earlier) * hidden

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """Each zone with the one that hides its photons best, beside what it hides itself."""
        light = np.maximum(expected - rendering.background, 0)
        earlier = np.cumsum(light, axis=-1) - light / 2
        zones = expected.shape[1]
        evidence = np.zeros((zones, zones))
        for zone in range(zones):
            # To first order what all of them hide; each in units of its noise.
            noise = np.sqrt(np.maximum(expected[:, zone], 1)).ravel()
            hidden = (expected[:, zone] * earlier.transpose(1, 0, 2)).reshape(zones, -1) / noise
            known = np.stack([expected[:, zone].ravel() / noise, hidden[zone]])
            left = hidden - (hidden @ known.T) @ np.linalg.pinv(known @ known.T) @ known
            size = np.sqrt((left**2).sum(axis=1))
            shown = -(left @ (excess[:, zone].ravel() / noise)) / np.maximum(size, 1e-12)
            evidence[zone] = np.where(size > 1e-6 * np.sqrt((hidden**2).sum(axis=1)), shown, 0)
        return [{"partner": 1.0, "other": found}] if (found := _paired(evidence)) is not None else []

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """How many shots there were need not be guessed where it is known."""
        return bool(np.any(values["per_count"])) and rendering.light.laser_cycles is not None


def other_zones(values: Values, zones: int) -> np.ndarray:
    """(P,) which zone shares each one's converter, its own number where none does."""
    alone = np.arange(zones)
    other = np.broadcast_to(np.rint(np.asarray(values["other"], float)).astype(int), (zones,))
    other = np.where(other < 0, alone ^ 1, other)
    return np.where(other < zones, other, alone)


def light_of_others(values: Values, expected: np.ndarray) -> np.ndarray:
    """(F, P, T) what the zone receives that shares each one's converter."""
    other = other_zones(values, expected.shape[1])
    return np.where((other != np.arange(len(other)))[:, None], expected[:, other], 0)


def _paired(evidence: np.ndarray) -> np.ndarray | None:
    """(P,) for each zone the other of its pair, the clearest first. evidence: (P, P) standard deviations, both ways."""
    both, found = np.triu(evidence + evidence.T, 1), np.arange(len(evidence))
    while both.max(initial=0) > SHOWN:
        one, other = np.unravel_index(both.argmax(), both.shape)
        found[one], found[other] = other, one
        both[[one, other]], both[:, [one, other]] = 0, 0
    return found.astype(float) if (found != np.arange(len(found))).any() else None


effect = PileUp()
