"""How expected counts change with what is fitted: by differences, of as many at once as change different counts."""

from collections.abc import Iterator

import numpy as np

from mismatch.columns import OF_ZONES, Rows, rows_of, spread
from mismatch.coordinate import bounds
from mismatch.form import Form, settings_at
from mismatch.remembered import Slopes
from mismatch.simulation import Simulation

STEP = 1e-3


def expected_at(simulation: Simulation, forms: tuple[Form, ...], x: np.ndarray) -> np.ndarray:
    """(F, P, T) expected counts at coordinates."""
    return simulation.expected(float(np.exp(x[0])), settings_at(forms, x))


def derivatives(
    simulation: Simulation, forms: tuple[Form, ...], x: np.ndarray, here: np.ndarray, known: Slopes | None = None
) -> tuple[Rows, Slopes | None]:
    """(F·P·T, N) change of expected counts `here` with each coordinate, and slopes of patches if there are any.

    known: such slopes, which are taken where they are near. Where each zone or bin has its own value, all are moved at
    once: each moves its own counts only. An edge moves the bin before it and the one after: even and odd edges are
    moved one after the other, patches each by itself. Sparse where every bin of every zone has its own.
    """
    turns = list(_turns(forms, x))
    # Coordinate by coordinate in memory: each is written, and multiplied with others, as a whole.
    written = np.sort(np.concatenate([which for axis, which, *_ in turns if axis not in OF_ZONES]))
    row = np.zeros(len(x), int)
    row[written] = np.arange(len(written))
    out = np.zeros((len(written), *here.shape))
    of_zones: list[Rows] = []

    def change(turn: tuple[str | None, np.ndarray, np.ndarray, np.ndarray]) -> None:
        axis, which, places, steps = turn
        moved = x.copy()
        moved[which] += steps
        changed = expected_at(simulation, forms, moved) - here
        if axis in OF_ZONES:
            of_zones.append(spread(rows_of(axis, changed, changed)[places], which, len(x), 1 / steps))
            return
        for coordinate, place, step in zip(which, places, steps, strict=True):
            cells = _moved_cells(axis, place)
            out[(row[coordinate], *cells)] = changed[cells] / step

    patches = [row[int(which[0])] for axis, which, *_ in turns if axis == "patch"]
    if patches and known is not None and known.near(here):
        turns = [turn for turn in turns if turn[0] != "patch"]
        out[patches] = known.at(here)
    else:
        known = None
    simulation.each(change, turns)
    if patches and known is None:
        known = Slopes(here, out[patches].astype(np.float32))
    rows = out.reshape(len(written), -1)
    if of_zones:
        rows = sum(of_zones, start=spread(rows, written, len(x)))
    return rows.T, known


def _turns(forms: tuple[Form, ...], x: np.ndarray) -> Iterator[tuple[str | None, np.ndarray, np.ndarray, np.ndarray]]:
    """What is moved at once: of what each has its own value, which coordinates, of which zones or bins, how far."""
    yield None, np.zeros(1, int), np.zeros(1, int), np.full(1, STEP)
    at = 1
    for form in forms:
        end = at + len(form.coordinates)
        while at < end:
            parameter, place = form.coordinates[at - end]
            count = 1 if place is None else form.sizes[parameter.name]
            axis = None if place is None else parameter.axis
            _, high = bounds(parameter)
            turns = {"edge": 2, "zone edge": 2, "patch": count}.get(axis, 1)
            for turn in range(turns):
                places = np.arange(turn, count, turns)
                which = at + places
                yield axis, which, places, np.where(x[which] + 2 * STEP > high, -STEP, STEP)
            at += count


def _moved_cells(axis: str | None, i: int) -> tuple[slice, slice, slice]:
    """Which of (F, P, T) counts move with a parameter, or with that of one zone, bin or edge."""
    every, one = slice(None), slice(i, i + 1)
    if axis == "zone":
        return every, one, every
    if axis == "bin":
        return every, every, one
    return every, every, slice(max(i - 1, 0), i + 1) if axis == "edge" else every
