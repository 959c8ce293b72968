"""Zones share a supply that sags: what others draw from it, one lacks."""

from itertools import product

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

ALL, ROW, COLUMN = 0, 1, 2
# What is left at least of a sensitivity.
LEAST = 0.05


class SharedSupply(Effect):
    """Light of a zone over 1 + drawn · o, with o that of the other zones on its supply over the most of any.

    Or times 1 - drawn · o, by the part `straight`: a supply's voltage goes straight down with what is drawn, and so may
    a detector's chance to count with its voltage. A supply feeds all zones, those of a row or those of a column, by
    `feeds` 0, 1 or 2. Where it is the detectors' the background draws from it and sags with it, where it is the laser's
    that does neither.
    """

    id = "shared_supply"
    acts_on = "detector"
    order = 80  # All that a zone counts, before histograms are mixed.
    sentence = "each zone is less sensitive the more light others receive"
    forms = (("drawn",),)
    parameters = (
        Parameter("drawn", unit="1", low=-0.5, high=10.0, start=0.05, vanishes_at=0.0, sentence="How much it sags."),
        Parameter("feeds", unit="1", low=ALL, high=COLUMN, start=ALL, sentence="Which zones: all, a row, a column."),
        Parameter("background", "1", 0.0, 1.0, 1.0, "Whether the background sags: 0 the laser's supply, 1 theirs."),
        Parameter("straight", "1", 0.0, 1.0, 0.0, "Part of that which goes straight down with what others draw."),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts by what is left of the supply."""
        background = np.minimum(rendering.background, rendering.expected)
        light = rendering.expected - background
        drawing = (light + values["background"] * background).sum(axis=-1)
        others = drawing @ fed_together(rendering.footprints.zone_grid, round(values["feeds"]))
        others = others / max(float(others.max()), 1e-300)
        drawn, straight = values["drawn"] * others, values["straight"]
        left = ((1 - straight) / (1 + drawn) + straight * np.maximum(1 - drawn, LEAST))[..., None]
        return light * left + background * (1 + values["background"] * (left - 1))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Every way to feed them in which zones have others, with the background and without, on either course."""
        strength, grid = self.parameter("drawn").start, rendering.footprints.zone_grid
        ways = [feeds for feeds in (ALL, ROW, COLUMN) if fed_together(grid, feeds).any()]
        each = product(ways, (0.0, 1.0), (0.0, 1.0))
        return [{"drawn": strength, "feeds": float(f), "background": b, "straight": s} for f, b, s in each]


def fed_together(grid: tuple[int, int], feeds: int) -> np.ndarray:
    """(P, P) 1 for zones that share a supply, of a grid of rows and columns; 0 for others, and for a zone itself."""
    line = np.divmod(np.arange(grid[0] * grid[1]), grid[1])[feeds - 1] if feeds else np.zeros(grid[0] * grid[1])
    return (line[:, None] == line) & ~np.eye(len(line), dtype=bool)


effect = SharedSupply()
