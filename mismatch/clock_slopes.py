"""What counts change by where a response and delays of zones, as they were estimated, are off."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from calibrate.impulse.cells import in_steps
from mismatch.fit import fit_nominal
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation
from physics.arrivals import arrivals
from physics.clock import Clock
from physics.pulse import ImpulseResponse

# A response is loose in pieces of so many bins where there is more than this part of its most, and before and after in
# pieces that become longer.
CLEAR, PIECE_BINS = 0.02, 0.5
BEFORE_BINS, AFTER_BINS = (1, 1, 2, 4), (1, 1, 2, 2, 4, 4, 8, 8, 16, 16)
# Standard deviation of a piece, as a part of what is there and of the whole; and of a delay, in bins.
OF_PIECE, OF_WHOLE, OF_DELAY = 0.3, 0.01, 0.2
# So many numbers are kept at most, and so many are made at a time.
MOST_NUMBERS, AT_A_TIME = 1 << 26, 1 << 24


def loosened(simulation: Simulation) -> Simulation:
    """The same with a clock that may be off."""
    return replace(simulation, loose=clock_slopes(simulation, fit_nominal(simulation).gain))


def clock_slopes(simulation: Simulation, gain: float) -> np.ndarray | None:
    """(K, F, P, T) change of expected counts with each number of an estimated clock, by a standard deviation of it.

    These are pieces of the response, whose whole stays 1, and delays of zones whose time zeros do not hold. None where
    it would be too large.
    """
    frames, zones, bins = simulation.counts.shape
    clock = longer(simulation.clock, sum(BEFORE_BINS), sum(AFTER_BINS))
    light = arrivals(simulation.light, simulation.footprints, clock)
    pieces = _pieces(response := np.diff(light.lattice.cumulative), light.lattice.per_bin)
    later = -np.gradient(response) * OF_DELAY * light.lattice.per_bin
    if (len(pieces) + zones) * simulation.counts.size > MOST_NUMBERS:
        return None
    ways = gain * np.stack([*pieces, later], axis=1)
    ways = ways.astype(np.float32)
    found = np.zeros((len(pieces) + zones, frames, zones, bins), np.float32)
    many = max(1, AT_A_TIME // (bins * len(response)))
    for start in range(0, frames, many):
        some = slice(start, start + many)
        part = replace(light, light=light.light[some])
        for zone in range(zones):
            if simulation.dead is None or not simulation.dead[zone]:
                changes = np.moveaxis(in_steps(part, zone) @ ways, 2, 0)
                changes[np.abs(changes) < LEAST] = 0.0
                found[: len(pieces), some, zone] = changes[:-1]
                if not simulation.timed:
                    found[len(pieces) + zone, some, zone] = changes[-1]
    return found[found.any(axis=(1, 2, 3))]


def longer(clock: Clock, before_bins: int, after_bins: int) -> Clock:
    """With a response that is next to nothing for some bins before and after."""
    per_bin, pulse = clock.lattice.per_bin, clock.pulse
    ends = (before_bins * per_bin, after_bins * per_bin)
    probability = np.pad(pulse.probability, ends, constant_values=1e-12)
    first = pulse.time_s[0] - ends[0] * pulse.step_s
    return replace(clock, pulse=ImpulseResponse(first + pulse.step_s * np.arange(len(probability)), probability))


def _pieces(response: np.ndarray, per_bin: int) -> list[np.ndarray]:
    """Changes (N,) of a response by a standard deviation of each piece of it, its whole left as it is."""
    clear = np.flatnonzero(response > CLEAR * response.max())
    first, last = clear[0], clear[-1] + 1
    edges = [
        *(first - per_bin * np.cumsum(BEFORE_BINS)),
        *np.arange(first, last, max(1, round(PIECE_BINS * per_bin))),
        *(last + per_bin * np.cumsum([0, *AFTER_BINS])),
    ]
    edges = np.unique(np.clip(edges, 0, len(response)))
    found = []
    for start, end in pairwise(edges):
        piece = np.zeros(len(response))
        piece[start:end] = (OF_PIECE * response[start:end].sum() + OF_WHOLE) / (end - start)
        found.append(piece - piece.sum() * response)
    return found
