"""The bracket: a back plate with pads for the camera, posts for the LiDAR's board, and a foot for tripod or table."""

from functools import cached_property

import numpy as np
from manifold3d import Manifold

from devices.parts.layout import SINK, SPARE, TIE, Layout
from devices.parts.solids import Part, box, cylinder, joined, lying, posed


class Bracket(Layout):
    """The solids at the places of the layout; printed on its back, with camera and LiDAR up."""

    @property
    def plate(self) -> Manifold:
        """The back plate, with room for the camera's plug, a window for the wires and slots for cable ties."""
        m = self.placed.measures
        back = self.face - m.plate_thickness
        plate = box((self.sides[0], self.top, back), (self.sides[1], self.foot_top + m.foot_thickness, self.face))
        plate -= self.through(*self.plug)
        x, y, _ = np.mean([self.post_base(hole) for hole in self.placed.holes], axis=0)
        half = (m.board_hole_spacing - m.post - m.wall) / 2
        plate -= self.through((x - half, y - half), (x + half, y + half))
        for x, y in self.ties:
            plate -= self.through((x - TIE[0] / 2, y - TIE[1] / 2), (x + TIE[0] / 2, y + TIE[1] / 2))
        return plate

    def through(self, low: tuple[float, float], high: tuple[float, float]) -> Manifold:
        """What a rectangular hole takes out of the plate."""
        return box((*low, self.face - self.placed.measures.plate_thickness - 1), (*high, self.face + 1))

    def post(self, hole: np.ndarray, screwed: bool) -> tuple[Manifold, Manifold]:
        """A post under one of the board's holes, and what is drilled from it; a pin on it where no screw goes in."""
        m, rotation = self.placed.measures, self.placed.rotation
        length = np.linalg.norm(hole - self.post_base(hole))
        over = m.post / 2 * np.hypot(*rotation[:2, 2]) / rotation[2, 2] + SINK
        post = posed(cylinder((0, 0, -length - over), length + over, m.post), rotation, hole)
        post = post.trim_by_plane([0, 0, 1], self.face - m.plate_thickness)
        if screwed:
            deep = min(m.m3_grip, length + m.plate_thickness - m.wall)
            return post, posed(cylinder((0, 0, -deep), deep + 1, m.m3_pilot), rotation, hole)
        pin = cylinder((0, 0, -SINK), SINK + m.board_thickness, self.pin)
        return post + posed(pin, rotation, hole), Manifold()

    @property
    def screws(self) -> list[str]:
        """What it is screwed together with, a sentence each."""
        m, pins = self.placed.measures, self.screwed.count(False)
        screw = self.camera_screw(self.placed.camera_back - self.face)
        said = [f"camera: 2 x M3 x {screw} from behind, {m.camera_m3_depth - SPARE:g} mm of it in the camera"]
        if m.shelf_thickness:
            said.append(f"camera: 1 short 1/4-20 UNC screw from below, through {m.shelf_thickness:g} mm")
        grip = "M3 x 8, which cut their own thread" if m.m3_grip >= 8 - m.board_thickness else "short M3"
        said.append(f"LiDAR's board: {4 - pins} x {grip}" + (f", and {pins} pins under the camera" if pins else ""))
        return [*said, "foot: 2 x M6 on a table, or a 1/4-20 UNC nut in its pocket for a tripod"]

    @cached_property
    def part(self) -> Part:
        """The whole bracket."""
        m, back = self.placed.measures, self.face - self.placed.measures.plate_thickness
        solids, holes = [self.plate], []
        for x, y in self.pads:
            solids.append(cylinder((x, y, self.face - SINK), self.placed.camera_back - self.face + SINK, m.pad))
            holes.append(cylinder((x, y, back - 1), self.placed.camera_back - back + 2, m.m3_clearance))
        for hole, screwed in zip(self.placed.holes, self.screwed, strict=True):
            post, drilled = self.post(hole, screwed)
            solids.append(post)
            holes.append(drilled)
        if m.shelf_thickness:
            shelf, drilled = self.shelf
            solids.append(shelf)
            holes.append(drilled)
        foot, drilled = self.foot
        solids.append(foot)
        holes.append(drilled)
        return Part("bracket", joined(solids) - joined(holes), "print on its back, as it lies in the file")

    @property
    def shelf(self) -> tuple[Manifold, Manifold]:
        """The shelf under the camera, and its hole for a 1/4-20 screw."""
        m = self.placed.measures
        hole = self.placed.camera_middle, m.camera_height / 2 - 1, m.camera_front - m.camera_thread_behind
        return box(*self.shelf_corners), lying(hole, m.shelf_thickness + 2, m.m6_clearance)

    @property
    def foot(self) -> tuple[Manifold, Manifold]:
        """The foot with two ribs, and its holes: M6 for a table, 1/4-20 with a pocket for the nut for a tripod."""
        m, top, (left, right) = self.placed.measures, self.foot_top, self.sides
        front, bottom = self.face + m.foot_depth, top + m.foot_thickness
        foot = box((left, top, self.face - SINK), (right, bottom, front))
        for x in (left, right - m.rib):
            corners = [
                (x + dx, y, z)
                for dx in (0, m.rib)
                for y, z in (
                    (top + SINK, self.face - SINK),
                    (top + SINK, front - m.rib),
                    (top - 0.35 * m.foot_depth, self.face - SINK),
                )
            ]
            foot += Manifold.hull_points(np.array(corners))
        holes = [lying(at - [0, 1, 0], m.foot_thickness + 2, m.m6_clearance) for at in self.table_holes]
        nut = 2 / np.sqrt(3) * m.nut_flats
        holes.append(lying(self.table_holes[1] - [0, 1, 0], m.nut_height + 1, nut, segments=6))
        return foot, joined(holes)
