"""Counts as a clock that is off makes them, which are never fewer than none."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Settled:
    """Expected counts beside a clock that was moved.

    mean: (F, P, T) counts. b: (K,) how far the clock is off, in standard deviations of its numbers. by_expected,
    by_clock: (F, P, T) derivatives of `mean` by what was expected and by what the clock changes, or (1,) for all.
    """

    mean: np.ndarray
    b: np.ndarray
    by_expected: np.ndarray
    by_clock: np.ndarray


def changed(expected: np.ndarray, change: np.ndarray, b: np.ndarray) -> Settled:
    """Expected counts E (F, P, T) with a change C of them.

    E + C as long as half of them are left, and E² / -4C beyond, which goes on from there with the same slope and never
    falls to nothing: the clock moves in proportion to light where it is, as far as there is some.
    """
    far = change < -expected / 2
    part = np.where(far, expected / np.where(far, -2 * change, 1.0), 1.0)
    return Settled(np.where(far, expected * part / 2, expected + change), b, part, part**2)
