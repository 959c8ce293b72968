"""`pile_up`: one event per timing channel and laser shot."""

from typing import Any

import numpy as np

from physics.dead_time import alive
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from recordings.refusal import Refusal

# Standard deviations by which zones must show it to be taken to share a converter.
SHOWN = 3.0


class PileUp(Effect):
    """A channel registers the first photon after a shot and is dead for the rest of its cycle, or for `dead` seconds.

    Of N shots, with μ_t photons expected in bin t by shot and channel, the bin registers

        N · exp(-Σ_{s<t} μ_s) · (1 - exp(-μ_t))

    (Coates 1968, J. Phys. E 1, 878). Where a channel is alive again before its cycle ends, no photons before are
    replaced by no event in the dead time before: 1 - Σ_s q_s·W(t - s) for the exponential, with q the events by shot
    and channel, of which no two are less than a dead time apart, and W the chance that one so many bins before is less
    than that before, both somewhere in their bins (a non-paralysable counter: Müller 1973, Nucl. Instrum. Methods 112,
    47). A zone whose light is shared by n channels has μ = λ/n and n times N shots:
    `share` is 1/n. Where nobody says how many shots there were, `per_count` stands for share/N. Several zones may be
    timed by one converter, which what any of them sees keeps busy: of μ and, in the others, ν in a bin, the zone that
    sees μ gets μ/(μ + ν)·(1 - exp(-μ - ν)), with `partner` of the others' ν. `converter` says which zones those are.
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
    forms = (
        ("share",),
        ("per_count",),
        ("share", "partner"),
        ("per_count", "partner"),
        ("share", "dead"),
        ("per_count", "dead"),
    )
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
            "partner", "1", 0.0, 1.0, 0.0, "Part of other zones' light that the same converter times.", tries=(1.0,)
        ),
        Parameter(
            "converter",
            unit="1",
            low=-1.0,
            high=1e6,
            start=-1.0,
            axis="zone",
            sentence="Number of the converter that times a zone; -1 where zones 0 and 1, 2 and 3 go together.",
        ),
        Parameter(
            "dead",
            unit="s",
            low=1e-9,
            high=1.0,
            start=1.0,
            tries=(5e-9, 1.2e-8),
            sentence="How long a channel is dead after an event: to the end of its cycle where longer than that.",
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
        # All that the converter meets: other zones' light goes through channels of the same shots.
        met = per_shot + values["partner"] * rate * light_of_others(values, rendering.expected)
        ready = alive(met, values["dead"] / rendering.clock.bin_width_s)
        # expm1(-μ)/-μ, which is 1 where μ vanishes, keeps the counts exact at small rates.
        hidden = np.where(met > 0, -np.expm1(-met) / np.where(met > 0, met, 1), 1)
        return rendering.expected * ready * hidden

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """Zones together that hide one another's photons, beside what each hides itself."""
        zones = expected.shape[1]
        promised, square = _hidden_by_others(excess, expected, rendering)
        row, column = np.divmod(np.arange(zones), rendering.footprints.zone_grid[1])
        found = [_together(promised, square), row, column]
        best = max(found, key=lambda number: _gained(number, promised, square))
        if _gained(best, promised, square) <= SHOWN**2:
            return []
        return [{"partner": 1.0, "converter": np.unique(best, return_inverse=True)[1].astype(float)}]

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """How many shots there were need not be guessed where it is known."""
        return bool(np.any(values["per_count"])) and rendering.light.laser_cycles is not None


def shared(values: Values, zones: int) -> np.ndarray:
    """(P, P) whether two zones, not one and the same, share a converter."""
    number = np.broadcast_to(np.rint(np.asarray(values["converter"], float)).astype(int), (zones,))
    number = np.where(number < 0, -1 - np.arange(zones) // 2, number)
    return (number[:, None] == number) & ~np.eye(zones, dtype=bool)


def light_of_others(values: Values, expected: np.ndarray) -> np.ndarray:
    """(F, P, T) what the zones receive that share each one's converter."""
    return np.einsum("pq,fqt->fpt", shared(values, expected.shape[1]).astype(float), expected)


def _hidden_by_others(excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> tuple[np.ndarray, np.ndarray]:
    """(P, P), (P, P, P) for each zone, to first order: by which part of what the others hide its excess is explained.

    What one zone hides of another is what comes after the one's light; beside gain and what a zone hides itself. First
    the excess's product with each other's, then those of all with one another, in units of the zone's noise.
    """
    light = np.maximum(expected - rendering.background, 0)
    earlier = np.cumsum(light, axis=-1) - light / 2
    zones = expected.shape[1]
    promised, square = np.zeros((zones, zones)), np.zeros((zones, zones, zones))
    for zone in range(zones):
        noise = np.sqrt(np.maximum(expected[:, zone], 1)).ravel()
        hidden = -(expected[:, zone] * earlier.transpose(1, 0, 2)).reshape(zones, -1) / noise
        known = np.stack([expected[:, zone].ravel() / noise, hidden[zone]])
        left = hidden - (hidden @ known.T) @ np.linalg.pinv(known @ known.T) @ known
        promised[zone], square[zone] = left @ (excess[:, zone].ravel() / noise), left @ left.T
        # Where nothing is left but rounding.
        square[zone] += np.diag(1e-9 * (hidden**2).sum(axis=1) + 1e-300)
    return promised, square


def _gained(number: np.ndarray, promised: np.ndarray, square: np.ndarray) -> float:
    """Deviance that zones gain, each by one amplitude, that share converters with the same numbers (P,); less where
    they would have to hide less than nothing."""
    total = 0.0
    for zone in range(len(number)):
        others = np.flatnonzero((number == number[zone]) & (np.arange(len(number)) != zone))
        if len(others):
            amount = promised[zone, others].sum()
            total += amount * abs(amount) / square[zone][np.ix_(others, others)].sum()
    return float(total)


def _together(promised: np.ndarray, square: np.ndarray) -> np.ndarray:
    """(P,) number of each zone's converter: those are put together that gain most by it, as long as that is much."""
    best = np.arange(len(promised))
    while True:
        pairs = [(one, other) for one in np.unique(best) for other in np.unique(best) if one < other]
        tried = [np.where(best == other, one, best) for one, other in pairs]
        before = _gained(best, promised, square)
        merged = max(tried, key=lambda number: _gained(number, promised, square), default=best)
        if _gained(merged, promised, square) <= before + SHOWN**2:
            return best
        best = merged


effect = PileUp()
