"""Nothing runs into anything, and nothing stands in a field of view: checked on the solids themselves."""

from itertools import combinations

import numpy as np
from manifold3d import Manifold

from devices.parts.bracket import Bracket
from devices.parts.placed import Placed
from devices.parts.solids import Part, mesh
from recordings.refusal import Refusal

TOUCH_MM3 = 0.5  # surfaces that touch share no more than this
FINE_MM = 1.0  # how finely the angle to what blocks the view is looked for
MOST_TILT_DEG = 40.0  # posts that lean more need supports


def expect_in_reach(placed: Placed) -> None:
    """Refuse a LiDAR so far from the camera, or looking so far aside, that no bracket could carry it."""
    away, bed = float(np.linalg.norm(placed.position)), placed.measures.bed
    if away > bed:
        raise Refusal(
            f"lidar_position_m is {away:.0f} mm from the camera, "
            f"expected at most {bed:.0f} mm, the printer's bed (mount.bed)"
        )
    tilt = np.degrees(np.arccos(np.clip(placed.rotation[2, 2], -1, 1)))
    if tilt > MOST_TILT_DEG:
        raise Refusal(
            f"lidar_rotation_deg turns the LiDAR {tilt:.0f} deg from the camera's axis, "
            f"expected at most {MOST_TILT_DEG:.0f} deg for a printed bracket"
        )


def expect_clear(bracket: Bracket, part: Part) -> None:
    """Refuse a bracket whose pieces, camera and board run into one another, or stand before an eye."""
    placed = bracket.placed
    solids = {"the LiDAR's board": placed.board, "the camera's body": placed.camera, "the bracket": part.solid}
    for (a, solid), (b, other) in combinations(solids.items(), 2):
        shared = (solid ^ other).volume()
        if shared > TOUCH_MM3:
            raise Refusal(f"{a} and {b} share {shared:.0f} mm³, expected none: {_remedy(a, b)}")
    for eye, seen, can_block in (
        ("the LiDAR", placed.lidar_view, ("the camera's body", "the bracket")),
        *((eye, seen, ("the LiDAR's board", "the bracket")) for eye, seen in placed.camera_views.items()),
    ):
        for name in can_block:
            _expect_unseen(eye, seen, name, solids[name], placed)
    if sum(bracket.screwed) < 2:
        raise Refusal("fewer than 2 of the board's holes are free of the camera, expected 2 for screws: move the LiDAR")


def _expect_unseen(eye: str, seen: Manifold, name: str, solid: Manifold, placed: Placed) -> None:
    inside = seen ^ solid
    if inside.volume() <= TOUCH_MM3:
        return
    where = np.asarray(mesh(inside.refine_to_length(FINE_MM)).vertices)
    nearest = ""
    if eye == "the LiDAR":
        there = (where - placed.position) @ placed.rotation
        ahead = there[there[:, 2] > 1e-6]
        angle = np.degrees(np.arctan(np.hypot(*ahead[:, :2].T) / ahead[:, 2])).min() if len(ahead) else 0.0
        nearest = f" up to {angle:.0f} deg from its axis"
    advice = "move lidar_position_m forward or away from the camera" if name != "the bracket" else "see rig.mount"
    raise Refusal(f"{name} stands in the field of view of {eye}{nearest}, expected nothing there: {advice}")


def _remedy(a: str, b: str) -> str:
    if {a, b} == {"the LiDAR's board", "the camera's body"}:
        return "lidar_position_m puts the sensor into the camera"
    return "move the LiDAR, or leave out the shelf with mount.shelf_thickness 0"


def expect_printable(part: Part, bed: float) -> None:
    """Refuse a part that is larger than the printer's bed, or that measures have cut into pieces."""
    pieces = len(part.solid.decompose())
    if pieces != 1:
        raise Refusal(
            f"{part.name} falls into {pieces} pieces, expected 1: "
            "move the LiDAR off the camera's plug, or see rig.mount"
        )
    if max(part.size[:2]) > bed:
        raise Refusal(
            f"{part.name} is {part.size[0]:.0f} x {part.size[1]:.0f} mm, "
            f"expected at most {bed:.0f} mm, the printer's bed (mount.bed)"
        )
