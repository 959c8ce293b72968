"""What of a session holds for all frames: its text, the camera's footprints, and colours by zone."""

from collections.abc import Callable

import numpy as np
import rerun as rr

from viewers.footprint_contours import contours
from viewers.overlay import zone_colours
from viewers.session_frame import SessionRig

WHITE, TRACK, UNKNOWN = [255, 255, 255], [255, 200, 60], [160, 160, 160]
NO_ZONE = 255

# Entity, what to log there, and static=True for what holds for all frames.
Log = Callable[..., None]


def colours_of(zones: int) -> np.ndarray:
    """(P, 3) uint8 colours of the zones."""
    return (255 * zone_colours(zones)).astype(np.uint8)


def colours_by_index(zones: int) -> np.ndarray:
    """(256, 3) uint8 colours for every value of an index of zones; grey where there is no such zone."""
    table = np.full((NO_ZONE + 1, 3), UNKNOWN, np.uint8)
    known = min(zones, NO_ZONE)
    table[:known] = colours_of(zones)[:known]
    return table


def log_rig(log: Log, rig: SessionRig) -> None:
    """The text, the colour of the track, and which way is up."""
    log("world", upright(rig.first_pose), static=True)
    text = "\n\n".join((f"# {rig.title}", *rig.sentences))
    log("about", rr.TextDocument(text, media_type="text/markdown"), static=True)
    log("world/trajectory", rr.LineStrips3D.from_fields(colors=TRACK, radii=-1.5), static=True)


def upright(pose: np.ndarray | None) -> rr.ViewCoordinates:
    """Which way is up in the world: the axis that is most so in the camera's image at `pose` (4, 4); -y without one."""
    up = -np.asarray(np.eye(4) if pose is None else pose, float)[:3, 1]
    axis = int(np.abs(up).argmax())
    return getattr(rr.ViewCoordinates, f"RIGHT_HAND_{'XYZ'[axis]}_{'UP' if up[axis] > 0 else 'DOWN'}")


def log_footprints(log: Log, rig: SessionRig, size: tuple[int, int]) -> None:
    """Where the zones look, over the camera's image of (H, W) pixels."""
    if rig.footprints is None:
        return
    rows = zip(rig.zones, contours(rig.footprints, size), colours_of(len(rig.zones)), strict=True)
    for zone, lines, colour in rows:
        if lines:
            drawn = rr.LineStrips2D(lines, colors=colour, draw_order=10)
            log(f"world/rig/camera/footprint/{zone}", drawn, static=True)
