"""`mirrored_zones`: the zones are not in the order that the maps assume."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering
from recordings.refusal import Refusal


class MirroredZones(Effect):
    """Zones look where others were said to: rows are exchanged first, then columns, then rows for columns.

    Each zone's weights become (1 − s) · its own + s · those of the zone it is exchanged with: s = 1 is the exchange,
    and a fit can find its way there. Footprints are exchanged, not what is the zone's own in time and counting: time
    zero, background, gain. On a grid of one row or column there is nothing to mirror that way.
    """

    id = "mirrored_zones"
    acts_on = "optics"
    order = -1  # Which zone looks where comes before what zones do to their light.
    sentence = "Rows or columns of the zones are mirrored, or rows and columns are exchanged."
    look_alikes = (
        LookAlike(
            "footprint_shift", "Light one corner alone: where zones are mirrored, that of another corner answers."
        ),
        LookAlike(
            "zone_gain", "Cover one half of the field: a gain leaves the other half lit, mirrored zones swap them."
        ),
        LookAlike("stray_light", "Light one corner alone: mirrored, one other zone answers; stray light is in all."),
    )
    # A grid that is not square is refused its transpose, and that alone.
    forms = (("rows",), ("columns",), ("rows", "columns"), ("transposed",))
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
            ("transposed", "1 where rows are columns; 0 where the grid is not square, as nothing else can be."),
        )
    )

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints of zones that take shares of each other's."""
        mixed = exchange(rendering.footprints.zone_grid, values["rows"], values["columns"], values["transposed"])
        return rendering.footprints.changed(
            lambda weights: np.moveaxis(np.moveaxis(weights, -3, -1) @ mixed.T, -1, -3),
        )


def exchange(grid: tuple[int, int], rows: float, columns: float, transposed: float) -> np.ndarray:
    """(P, P) share of each zone's weights (columns) in those it comes to have (rows)."""
    if transposed and grid[0] != grid[1]:
        raise Refusal(
            f"effect mirrored_zones: transposed is {transposed:g} for {grid[0]} x {grid[1]} zones, "
            "expected 0 where the grid is not square"
        )
    zones = np.arange(grid[0] * grid[1]).reshape(grid)
    mixed = own = np.eye(zones.size)
    for share, other in ((rows, zones[::-1]), (columns, zones[:, ::-1]), (transposed, zones.T)):
        if share:
            mixed = ((1 - share) * own + share * own[other.ravel()]) @ mixed
    return mixed


effect = MirroredZones()
