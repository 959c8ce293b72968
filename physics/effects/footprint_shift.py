"""`footprint_shift`: zones look beside where their maps say."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class FootprintShift(Effect):
    """All maps are displaced in the image by one vector, the same at every range: a zone weighs u with w(u − shift).

    The mount has tilted since the scan, or image and scan disagree on where a pixel is. One that slips goes on: after t
    seconds the shift is (x, y) + (slip_x, slip_y)·t. Zones may be displaced by different amounts, as where the scan of
    one of them was.
    """

    id = "footprint_shift"
    acts_on = "optics"
    sentence = "The maps of all zones are displaced in the image by the same number of pixels."
    look_alikes = (
        LookAlike("parallax", "Step the target in range: a shift stays, parallax goes with 1 / depth."),
        LookAlike(
            "footprint_blur",
            "Let an edge enter the field from either side: a shift is early on one, late on the other.",
        ),
        LookAlike("time_lag", "Hold sensor and scene still: a shift stays, a lag goes."),
        LookAlike("mirrored_zones", "Light one corner alone: after a shift its own zone still answers."),
    )
    # Zone by zone either is tried alone: together they would be tried along the diagonal.
    forms = (("x", "y"), ("x",), ("y",), ("x", "y", "slip_x", "slip_y"))
    richer = common = forms[3:]
    parameters = tuple(
        # A choice: about half the side of the patch that a scan moves, which is what a careless mount gives.
        Parameter(
            axis,
            unit="px",
            low=-100.0,
            high=100.0,
            start=6.0,
            vanishes_at=0.0,
            axis="zone",
            sentence=f"How far to the {side}, in pixels of the full-size image.",
        )
        for axis, side in (("x", "right"), ("y", "bottom"))
    ) + tuple(
        Parameter(f"slip_{axis}", "px/s", -100.0, 100.0, 1.0, "By how much that grows in a second.", vanishes_at=0.0)
        for axis in "xy"
    )

    def moves_maps(self, values: Values) -> tuple[bool, bool]:
        """Those of single zones, and in each frame where it slips."""
        return bool(np.ndim(values["x"]) or np.ndim(values["y"])), bool(values["slip_x"] or values["slip_y"])

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """All footprints, moved."""
        found, x, y = rendering.footprints, values["x"], values["y"]
        # Where there are no frames it is as at the session's beginning.
        slips = rendering.light is not None and bool(values["slip_x"] or values["slip_y"])
        if np.ndim(x) or np.ndim(y):
            zones = found.zone_grid[0] * found.zone_grid[1]
            found = found.zones_moved(np.broadcast_to(x, zones), np.broadcast_to(y, zones))
            x, y = 0.0, 0.0
            if not slips:
                return found
        if slips:
            time_s = rendering.light.time_s[:, None, None]
            x, y = x + values["slip_x"] * time_s, y + values["slip_y"] * time_s
        return found.moved(x, y)


effect = FootprintShift()
