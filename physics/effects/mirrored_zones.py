"""`mirrored_zones`: the zones are not in the order that the maps assume."""

from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.optimize import linear_sum_assignment

from physics.clock import Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering
from physics.zone_order import taken

# What says that zones are exchanged: in such a share, of which less than half is no exchange.
SHARES = ("rows", "columns", "transposed", "zones_exchanged", "rows_exchanged", "columns_exchanged", "reordered")
HALF = 0.5
# What no logarithm may meet.
NOTHING = 1e-9


class MirroredZones(Effect):
    """Zones look where others were said to: two of them first, or two rows or columns, then all rows mirrored, then
    columns, then rows for columns: zones counted down the columns, whatever the grid.

    Each zone's weights become (1 − s) · its own + s · those of the zone it is exchanged with: s = 1 is the exchange,
    and a fit can find its way there. Footprints are exchanged, not what is the zone's own in time and counting: time
    zero, background, gain. With `clocks` 1 zones bring their time zeros along, as where histograms are exchanged, not
    maps, and with `levels` 1 their backgrounds; these are mixed in the same shares. On a grid of one row or column
    there is nothing to mirror that way. Where the zones are in any other order, `place` says in whose place each looks;
    what is no order leaves all where they were.
    """

    id = "mirrored_zones"
    acts_on = "optics"
    exact = True
    order = -1  # Which zone looks where comes before what zones do to their light.
    sentence = "The zones are in another order: mirrored, turned, rolled, or two of them, rows or columns exchanged."
    look_alikes = (
        LookAlike(
            "footprint_shift", "Light one corner alone: where zones are mirrored, that of another corner answers."
        ),
        LookAlike(
            "zone_gain", "Cover one half of the field: a gain leaves the other half lit, mirrored zones swap them."
        ),
        LookAlike("stray_light", "Light one corner alone: mirrored, one other zone answers; stray light is in all."),
    )
    forms = (
        ("rows",),
        ("columns",),
        ("rows", "columns"),
        ("transposed",),
        ("rows", "transposed"),
        ("columns", "transposed"),
        ("rows", "columns", "transposed"),
        ("zones_exchanged",),
        ("rows_exchanged",),
        ("columns_exchanged",),
        ("reordered",),
    )
    # Maps are in another order, or histograms.
    richer = tuple((*names, *with_them) for names in forms for with_them in (("levels",), ("clocks", "levels")))
    forms = (*forms, *((*names, "clocks") for names in forms), *richer)
    parameters = tuple(
        # A little, and not half: half of all would make all zones alike, where no slope shows the way.
        Parameter(
            name,
            unit="1",
            low=0.0,
            high=1.0,
            start=0.1,
            vanishes_at=0.0,
            sentence=sentence,
        )
        for name, sentence in (
            ("rows", "1 where the first row of zones looks where the last was said to, and so on."),
            ("columns", "1 where the first column of zones looks where the last was said to, and so on."),
            ("transposed", "1 where rows are columns: zones are counted down, where the maps' go along."),
            ("zones_exchanged", "1 where zones `first` and `second` look where the other was said to."),
            ("rows_exchanged", "1 where the zones of rows `first` and `second` do."),
            ("columns_exchanged", "1 where the zones of columns `first` and `second` do."),
            ("reordered", "1 where each zone looks where zone `place` was said to."),
        )
    ) + tuple(
        Parameter(
            name,
            unit="1",
            low=0.0,
            high=1e4,
            start=start,
            sentence="Which zone, row or column is exchanged, from 0; in between, a share of two.",
        )
        for name, start in (("first", 0.0), ("second", 1.0))
    )
    parameters += (
        Parameter("clocks", "1", 0.0, 1.0, 0.0, "1 where zones bring their time zeros along.", tries=(1.0,)),
        Parameter("levels", "1", 0.0, 1.0, 0.0, "1 where they bring their backgrounds along.", tries=(1.0,)),
        Parameter("place", "1", 0.0, 1e4, 0.0, "Which zone, from 0, each takes the place of.", axis="zone"),
    )

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints of zones that take shares of each other's."""
        mixed = taken(rendering.footprints.zone_grid, values)
        return rendering.footprints.changed(
            lambda weights: np.moveaxis(np.moveaxis(weights, -3, -1) @ mixed.T, -1, -3),
        )

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """Zones' time zeros, exchanged with them or not."""
        zero = np.asarray(rendering.clock.time_zero_s, float)
        if not values["clocks"] or zero.shape[-1:] in ((), (1,)):
            return rendering.clock
        theirs = zero @ taken(rendering.footprints.zone_grid, values).T
        return replace(rendering.clock, time_zero_s=zero + values["clocks"] * (theirs - zero))

    def background(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Zones' backgrounds, exchanged with them or not."""
        level = rendering.background
        if not values["levels"] or np.ndim(level) < 2 or level.shape[-2] == 1:
            return level
        return level + values["levels"] * (taken(rendering.footprints.zone_grid, values) @ level - level)

    def contradiction(self, values: Values, rendering: Rendering) -> str | None:
        """Zones are in each other's place or not; a small share of another's light is a ghost, or stray."""
        largest = max(values[name] for name in SHARES)
        return None if largest == 0 or largest > HALF else f"of another zone's place each has {largest:.2g} only"

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The two zones, rows and columns that fit best in each other's place, and the order that fits best of all."""
        level = np.minimum(rendering.background, expected)
        gain = gain_in_place(expected + excess, expected - level, level)
        rows, columns = rendering.footprints.zone_grid
        zones = np.arange(rows * columns).reshape(rows, columns)
        found = []
        for name, lines in (
            ("zones_exchanged", zones.reshape(-1, 1)),
            ("rows_exchanged", zones),
            ("columns_exchanged", zones.T),
        ):
            pairs = list(combinations(range(len(lines)), 2))
            if pairs:
                i, j = max(pairs, key=lambda pair: _of_both(gain, *lines[list(pair)]))
                found.append({name: self.parameter(name).start, "first": float(i), "second": float(j)})
        place = linear_sum_assignment(gain, maximize=True)[1].astype(float)
        return [*found, {"reordered": self.parameter("reordered").start, "place": place}]


def gain_in_place(counts: np.ndarray, signal: np.ndarray, level: np.ndarray) -> np.ndarray:
    """(P, P) log-likelihood that each zone's counts (rows) gain with each's signal (columns) beside its own level.

    counts, signal, level: (F, P, T). Poisson, the signal as bright as makes the sums alike.
    """
    found = np.empty((counts.shape[1],) * 2)
    bright = np.maximum(signal.sum(axis=(0, 2)), NOTHING)
    for zone, row in enumerate(found):
        seen, own = counts[:, zone, None], np.maximum(level[:, zone, None], NOTHING)
        times = np.maximum(seen.sum() - own.sum(), 0) / bright
        expected = times[:, None] * signal + own
        row[:] = (seen * np.log(expected) - expected).sum(axis=(0, 2))
    return found - np.diag(found)[:, None]


def _of_both(gain: np.ndarray, one: np.ndarray, other: np.ndarray) -> float:
    """What zones gain in all, one by one in each other's place."""
    return float(gain[one, other].sum() + gain[other, one].sum())


effect = MirroredZones()
