"""Counts beside the light that made them: for each bin, how much light every step of the response would put there."""

from dataclasses import dataclass

import numpy as np

from calibrate.impulse.likelihood import Counted
from physics.arrivals import Arrivals


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells of one zone that its pulse can reach, and for each frame all others as one cell more.

    design: (M, N) light that step j of the response registers in the cell; 0 in the cells of all others.
    frame: (M,) frame of each, ascending. counted: the counts. first: (F,) where each frame's cells begin.
    travel_steps: (F,) mean travel time of the frame's light, steps. many: (M,) bins that a cell stands for.
    """

    design: np.ndarray
    frame: np.ndarray
    counted: Counted
    first: np.ndarray
    travel_steps: np.ndarray
    many: np.ndarray

    def by_frame(self, values: np.ndarray) -> np.ndarray:
        """(F, ...) sums over the cells of each frame, of values (M, ...)."""
        return np.add.reduceat(values, self.first, axis=0)


def in_steps(arrivals: Arrivals, zone: int) -> np.ndarray:
    """(F, T, N) light that step j of the response would register in bin t, were all photons registered in that step.

    Arrivals lie on knots a step apart, and a bin holds n steps, so step j of light of knot k falls into one bin whole:
    the bin's light is a difference of the sum of light over knots.
    """
    lattice = arrivals.lattice
    steps, n = len(lattice.cumulative) - 1, lattice.per_bin
    frames, _, knots = arrivals.light.shape
    total = np.zeros((frames, knots + 1))
    np.cumsum(arrivals.light[:, zone], axis=1, out=total[:, 1:])
    before = steps - lattice.lead + n * np.arange(arrivals.bins + 1)[:, None] - np.arange(steps)
    return np.diff(total[:, np.clip(before, 0, knots)], axis=1)


def cells_of(
    arrivals: Arrivals, counts: np.ndarray, alive: np.ndarray, shots: np.ndarray | None, zero_s: np.ndarray, zone: int
) -> Cells:
    """The cells of a zone.

    counts, alive: (F, P, T). shots: (F,). zero_s: (F, P) or (P,) time zero, seconds.
    """
    light = in_steps(arrivals, zone)
    reached = light.any(axis=2)
    frames = len(light)
    shots = np.full(frames, np.inf) if shots is None else shots
    design, frame, seen, left, many = [], [], [], [], []
    for f in range(frames):
        near, c, a = reached[f], counts[f, zone], alive[f, zone]
        away = ~near
        design += [light[f][near], np.zeros((1, light.shape[2]))]
        frame += [f] * (int(near.sum()) + 1)
        seen += [c[near], [c[away].sum()]]
        left += [a[near], [a[away].sum()]]
        many += [np.ones(int(near.sum())), [away.sum()]]
    frame = np.array(frame)
    lattice, by_knot = arrivals.lattice, arrivals.light[:, zone]
    knots = lattice.first_s + lattice.step_s * np.arange(lattice.size)
    zero = np.broadcast_to(zero_s, arrivals.light.shape[:2])[:, zone]
    travel = (by_knot @ knots) / np.maximum(by_knot.sum(axis=1), np.finfo(float).tiny) - zero
    counted = Counted(np.concatenate(seen).astype(float), np.concatenate(left), shots[frame])
    first = np.searchsorted(frame, np.arange(frames))
    return Cells(np.concatenate(design), frame, counted, first, travel / lattice.step_s, np.concatenate(many))


def phase_gap(cells: list[Cells], per_bin: int) -> float:
    """The widest part of a bin in which no frame's light arrives, of the zone where it is narrowest; in bins."""
    gaps = []
    for zone in cells:
        phases = np.sort(zone.travel_steps / per_bin % 1)
        gaps.append(float(np.diff(phases, append=phases[0] + 1).max()))
    return min(gaps)
