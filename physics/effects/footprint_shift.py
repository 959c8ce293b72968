"""`footprint_shift`: zones look beside where their maps say."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class FootprintShift(Effect):
    """All maps are displaced in the image, by the same at every range: a zone weighs u with w(u − shift).

    The mount has tilted since the scan, or image and scan disagree on where a pixel is. One that slips goes on: after t
    seconds the shift is (x, y) + (slip_x, slip_y)·t. Zones may be displaced by different amounts, as where the scan of
    one of them was. A mount that gives way has three angles: pitch and yaw shift maps, roll turns them about the middle
    c of the image; and an image that was resampled or cropped since has them larger. Together they are a similarity,
    c + (1 + zoom)·R(turn)·(v − c) + shift of what the maps say of v (Hartley & Zisserman, Multiple View Geometry,
    2nd ed., §2.4.2). Whoever moves the weights of pixels, not maps, has what lies between these: `by_pixels` 1.
    """

    id = "footprint_shift"
    acts_on = "optics"
    grows = True
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
    forms = (
        ("x", "y"),
        ("x",),
        ("y",),
        ("x", "y", "turn"),
        ("x", "y", "zoom"),
        ("x", "y", "by_pixels"),
        ("slip_x", "slip_y"),
        ("x", "y", "turn", "zoom"),
        ("x", "y", "slip_x", "slip_y"),
        ("x", "y", "turn", "by_pixels"),
    )
    richer, common = forms[7:], forms[3:]
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
    )
    parameters += (
        Parameter("turn", "rad", -0.5, 0.5, 0.02, "Turned about the image's middle, clockwise.", vanishes_at=0.0),
        Parameter("by_pixels", "1", 0.0, 1.0, 0.0, "1 where weights of pixels move, 0 where maps do.", tries=(1.0,)),
        Parameter("zoom", "1", -0.5, 0.5, 0.02, "Larger by this part, about the image's middle.", vanishes_at=0.0),
        *(
            Parameter(f"slip_{axis}", "px/s", -100.0, 100.0, 1.0, "Growth of that in a second.", vanishes_at=0.0)
            for axis in "xy"
        ),
    )

    def moves_maps(self, values: Values) -> tuple[bool, bool]:
        """Those of single zones, and in each frame where it slips."""
        return bool(np.ndim(values["x"]) or np.ndim(values["y"])), bool(values["slip_x"] or values["slip_y"])

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """All footprints, moved: read at c + M⁻¹(u − c − shift), with M the matrix that turns and enlarges."""
        found = rendering.footprints
        cos, sin = np.cos(values["turn"]), np.sin(values["turn"])
        back = np.array([[cos, sin], [-sin, cos]]) / (1 + values["zoom"])
        x, y = np.tensordot(back, np.stack(np.broadcast_arrays(values["x"], values["y"])), 1)
        if x.ndim:
            zones = found.zone_grid[0] * found.zone_grid[1]
            found = found.zones_moved(np.broadcast_to(x, zones), np.broadcast_to(y, zones))
            x, y = 0.0, 0.0
        slips, similar = values["slip_x"] or values["slip_y"], values["turn"] or values["zoom"]
        if similar:
            width, height = found.field.full_size
            middle = np.stack([found.x_px - (width - 1) / 2, found.y_px - (height - 1) / 2])
            moved = middle - np.tensordot(back, middle, 1)
            x, y = x + moved[0], y + moved[1]
        # Where there are no frames it is as at the session's beginning.
        if slips and rendering.light is not None:
            slip = back @ np.array([values["slip_x"], values["slip_y"]])
            time_s = rendering.light.time_s[:, None, None]
            x, y = x + slip[0] * time_s, y + slip[1] * time_s
        elif not similar and found is not rendering.footprints:
            return found
        return found.moved(x, y, values["by_pixels"])


effect = FootprintShift()
