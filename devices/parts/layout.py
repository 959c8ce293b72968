"""Where the pieces of the bracket go: plate, pads, shelf, posts, foot and holes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from devices.parts.placed import Placed
from devices.parts.solids import bounds
from recordings.refusal import Refusal

SINK = 1.0  # how far solids reach into one another, so that they become one
FIRM = 3.0  # a 1/4-20 screw's head needs this much of the shelf around it
CABLE_ROOM = 3.0  # between board and foot
M3_LENGTHS = (8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50)  # usual ones of ISO 4762, millimetres
TIE, TIES_APART = (5.0, 2.5), 10.0  # slots for a cable tie: width and height, and between their middles
SPARE = 0.5  # by which a screw stays short of the end of the camera's thread


@dataclass(frozen=True)
class Layout:
    """Places in the camera's frame, x right, y down, z forward, millimetres."""

    placed: Placed

    @cached_property
    def face(self) -> float:
        """Z of the plate's front: behind the camera and behind every post's end."""
        m = self.placed.measures
        back = self.placed.camera_back
        ends = [back, *(hole[2] for hole in self.placed.holes)]
        least = back - min(ends) + m.least_post + m.post / 2 * float(np.hypot(*self.placed.rotation[:2, 2]))
        return back - (self.camera_screw(least) - m.camera_m3_depth + SPARE - m.plate_thickness)

    def camera_screw(self, pad: float) -> int:
        """Length of the usual M3 screw that passes plate and a pad of this length or more into the camera."""
        m = self.placed.measures
        needed = m.plate_thickness + pad + m.camera_m3_depth - SPARE
        for length in M3_LENGTHS:
            if length >= needed - 1e-6:
                return length
        raise Refusal(
            f"the LiDAR stands so far behind the camera that its pads would be {pad:.0f} mm long, "
            f"expected M3 screws of at most {M3_LENGTHS[-1]} mm to reach the camera"
        )

    @cached_property
    def foot_top(self) -> float:
        """Y of the foot's upper side: below camera, board and shelf, and out of every field of view."""
        placed, m = self.placed, self.placed.measures
        shelf = m.camera_height / 2 + (m.shelf_thickness + m.m6_clearance if m.shelf_thickness else 0)
        lowest = bounds(placed.board)[1][1] + CABLE_ROOM, shelf, placed.lowest_seen(self.face + m.foot_depth) + 1
        return float(max(lowest))

    @cached_property
    def pads(self) -> list[tuple[float, float]]:
        """X and y of the two M3 screws into the camera's back."""
        m = self.placed.measures
        middle = self.placed.camera_middle
        return [(middle + side * m.camera_m3_spacing / 2, m.camera_m3_below) for side in (-1, 1)]

    @cached_property
    def screwed(self) -> list[bool]:
        """Which of the board's holes take a screw: those whose screw's head would run into the camera take a pin."""
        return [(self.placed.head(hole) ^ self.placed.camera).is_empty() for hole in self.placed.holes]

    @cached_property
    def sides(self) -> tuple[float, float]:
        """X of the plate's left and right end."""
        m = self.placed.measures
        low, high = bounds(self.placed.board)
        x = [low[0] - 1 - m.rib, high[0] + 1 + m.rib]
        x += [pad[0] + side * m.pad / 2 for pad in self.pads for side in (-1, 1)]
        left, right = min(x), max(x)
        short = max(0.0, 2 * (m.table_pitch + m.m6_clearance + m.rib) - (right - left))
        return left - short / 2, right + short / 2

    @cached_property
    def table_holes(self) -> list[np.ndarray]:
        """Where the foot's holes begin on its upper side: M6, 1/4-20, M6, at the pitch of an optical table."""
        m = self.placed.measures
        z = self.face + m.foot_depth - 2 * m.m6_clearance
        return [np.array([sum(self.sides) / 2 + n * m.table_pitch, self.foot_top, z]) for n in (-1, 0, 1)]

    @property
    def pin(self) -> float:
        """Diameter of the pins in holes that take no screw."""
        return self.placed.measures.board_hole - 1.5 * self.placed.measures.fit

    @cached_property
    def top(self) -> float:
        """Y of the plate's upper end."""
        m = self.placed.measures
        return float(min(bounds(self.placed.board)[0][1], m.camera_m3_below - m.pad / 2) - 1)

    @property
    def plug(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Two corners of the room for the camera's plug, open where only a thin wall would be left beside it."""
        m = self.placed.measures
        left, half = self.placed.camera_middle - m.camera_width / 2 - 1, m.camera_height / 2 - m.wall
        low = [
            value - 10 * m.wall if value - edge < m.wall else value
            for value, edge in ((left, self.sides[0]), (-half, self.top))
        ]
        return (low[0], low[1]), (left + 1 + m.usb_width, half)

    @cached_property
    def ties(self) -> list[tuple[float, float]]:
        """Middles of two slots for a cable tie, as near to the board as there is room; none where there is none."""
        m = self.placed.measures
        low, high = (corner[:2] for corner in bounds(self.placed.board))
        base = np.array([self.post_base(hole)[:2] for hole in self.placed.holes])
        taken = [self.plug, (low, high), (base.min(axis=0) - m.post / 2, base.max(axis=0) + m.post / 2)]
        taken += [(np.array(pad) - m.pad / 2, np.array(pad) + m.pad / 2) for pad in self.pads]
        if m.shelf_thickness:
            taken.append(tuple(corner[:2] for corner in self.shelf_corners))
        half = np.array([TIE[0], TIES_APART + TIE[1]]) / 2 + m.wall
        first = np.array([self.sides[0] + m.rib, self.top]) + half
        last = np.array([self.sides[1] - m.rib, self.foot_top]) - half
        places = np.stack(np.meshgrid(*(np.arange(a, b, 1.0) for a, b in zip(first, last, strict=True))), -1).reshape(
            -1, 2
        )
        for a, b in taken:
            places = places[~((places + half > a) & (places - half < b)).all(axis=1)]
        if not len(places):
            return []
        # Behind the camera they are hard to thread.
        low_camera, high_camera = (corner[:2] for corner in bounds(self.placed.camera))
        behind = ((places + half > low_camera) & (places - half < high_camera)).all(axis=1)
        away = np.linalg.norm(places - (low + high) / 2, axis=1) + 1e3 * behind
        x, y = places[away.argmin()]
        return [(x, y - TIES_APART / 2), (x, y + TIES_APART / 2)]

    def post_base(self, hole: np.ndarray) -> np.ndarray:
        """(3,) where a post's axis meets the plate's front."""
        along = self.placed.rotation[:, 2]
        return hole - along * (hole[2] - self.face) / along[2]

    @property
    def shelf_corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Two corners of the shelf under the camera."""
        m, x, y = self.placed.measures, self.placed.camera_middle, self.placed.measures.camera_height / 2
        front = m.camera_front - m.camera_thread_behind + m.m6_clearance / 2 + FIRM
        low = x - m.shelf_width / 2, y + m.fit, self.face - SINK
        return np.array(low), np.array([x + m.shelf_width / 2, y + m.shelf_thickness, front])
