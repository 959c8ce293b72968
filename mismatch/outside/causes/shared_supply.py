"""Zones share a supply that sags: what others draw from it, one lacks."""

from itertools import product

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering

ALL, ROW, COLUMN = 0, 1, 2


class SharedSupply(Effect):
    """Light of a zone over 1 + drawn · o, with o that of the other zones on its supply over the most of any.

    A supply feeds all zones, those of a row or those of a column, by `feeds` 0, 1 or 2. Where it is the detectors' the
    background sags with it, where it is the laser's that stays.
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
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts by what is left of the supply."""
        background = np.minimum(rendering.background, rendering.expected)
        light = rendering.expected - background
        others = light.sum(axis=-1) @ fed_together(rendering.footprints.zone_grid, round(values["feeds"]))
        others = others / max(float(others.max()), 1e-300)
        left = 1 / (1 + values["drawn"] * others)[..., None]
        return light * left + background * (1 + values["background"] * (left - 1))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Every way to feed them in which zones have others, with the background and without."""
        strength, grid = self.parameter("drawn").start, rendering.footprints.zone_grid
        ways = [feeds for feeds in (ALL, ROW, COLUMN) if fed_together(grid, feeds).any()]
        both = product(ways, (0.0, 1.0))
        return [{"drawn": strength, "feeds": float(feeds), "background": whose} for feeds, whose in both]


def fed_together(grid: tuple[int, int], feeds: int) -> np.ndarray:
    """(P, P) 1 for zones that share a supply, of a grid of rows and columns; 0 for others, and for a zone itself."""
    line = np.divmod(np.arange(grid[0] * grid[1]), grid[1])[feeds - 1] if feeds else np.zeros(grid[0] * grid[1])
    return (line[:, None] == line) & ~np.eye(len(line), dtype=bool)


effect = SharedSupply()
