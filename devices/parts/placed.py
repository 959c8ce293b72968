"""What is held, not printed: camera body and LiDAR board where the rig file puts them, and all that they see."""

from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold

from calibrate.rig import Rig
from devices.parts.measures import Measures, measures_from
from devices.parts.solids import bounds, box, cylinder, posed, view

HEAD_HEIGHT = 2.0  # of an M3 button head on the board


@dataclass(frozen=True, eq=False)
class Placed:
    """The rig's devices in the camera's frame: x right, y down, z forward, millimetres, origin at the colour lens.

    rotation: (3, 3) and position: (3,) of the LiDAR, from its frame into the camera's.
    """

    measures: Measures
    rotation: np.ndarray
    position: np.ndarray

    @staticmethod
    def of(rig: Rig) -> "Placed":
        """The devices of a rig; raises `Refusal` where rig.mount has measures that cannot be."""
        camera_from_lidar = np.linalg.inv(rig.lidar_from_camera)
        return Placed(measures_from(rig.mount), camera_from_lidar[:3, :3], camera_from_lidar[:3, 3] * 1e3)

    @property
    def camera_middle(self) -> float:
        """X of the middle of the camera's body, where its 1/4-20 thread is."""
        return self.measures.camera_colour_left

    @property
    def camera_back(self) -> float:
        """Z of the camera's back."""
        return self.measures.camera_front - self.measures.camera_depth

    @property
    def camera(self) -> Manifold:
        """The camera's body, its long edges rounded."""
        m = self.measures
        r = max(m.camera_edge, 0.05)
        round_edge = Manifold.cylinder(m.camera_width, r, r, 48).rotate([0, 90, 0])
        left = self.camera_middle - m.camera_width / 2
        edges = [
            round_edge.translate([left, y, z])
            for y in (r - m.camera_height / 2, m.camera_height / 2 - r)
            for z in (self.camera_back + r, m.camera_front - r)
        ]
        return Manifold.batch_hull(edges)

    def on_board(self, x: float, y: float, z: float) -> np.ndarray:
        """(3,) in the camera's frame of a point on the board: from its middle, z above its face with the sensor."""
        m = self.measures
        turn = np.radians(m.board_turn_deg)
        turned = np.cos(turn) * x - np.sin(turn) * y + m.board_x, np.sin(turn) * x + np.cos(turn) * y + m.board_y
        return self.position + self.rotation @ np.array([*turned, z - m.lidar_above_board])

    @property
    def holes(self) -> list[np.ndarray]:
        """Where the axes of the board's four holes meet its back."""
        half = self.measures.board_hole_spacing / 2
        return [
            self.on_board(x, y, -self.measures.board_thickness)
            for x, y in ((-half, -half), (half, -half), (half, half), (-half, half))
        ]

    @property
    def board(self) -> Manifold:
        """The LiDAR's board with its holes, and the sensor on it."""
        m = self.measures
        half = m.board_size / 2
        plate = box((-half, -half, -m.board_thickness), (half, half, 0))
        at = m.board_hole_spacing / 2
        for x in (-at, at):
            for y in (-at, at):
                plate -= cylinder((x, y, -m.board_thickness - 1), m.board_thickness + 2, m.board_hole)
        plate = plate.rotate([0, 0, m.board_turn_deg]).translate([m.board_x, m.board_y, 0])
        w, h = m.lidar_window_width / 2, m.lidar_window_height / 2
        package = box((-w, -h, -0.1), (w, h, m.lidar_above_board))
        return posed((plate + package).translate([0, 0, -m.lidar_above_board]), self.rotation, self.position)

    def head(self, hole: np.ndarray) -> Manifold:
        """The head of a screw in one of the board's holes."""
        m = self.measures
        up = hole + self.rotation[:, 2] * m.board_thickness
        return posed(cylinder((0, 0, 0), HEAD_HEIGHT, m.m3_head), self.rotation, up)

    @property
    def lidar_view(self) -> Manifold:
        """What the LiDAR sees."""
        m = self.measures
        angles = m.lidar_width_deg, m.lidar_height_deg
        pyramid = view(angles, (m.lidar_window_width, m.lidar_window_height))
        return posed(pyramid, self.rotation, self.position)

    @property
    def camera_views(self) -> dict[str, Manifold]:
        """What the colour camera and the two infrared imagers see."""
        m = self.measures
        left = self.camera_middle - m.imager_left
        depth = view((m.depth_width_deg, m.depth_height_deg))
        return {
            "the colour camera": view((m.colour_width_deg, m.colour_height_deg)),
            "the left imager": depth.translate([left, 0, 0]),
            "the right imager": depth.translate([left + m.imager_baseline, 0, 0]),
        }

    def lowest_seen(self, front: float) -> float:
        """The largest y (down) that any field of view reaches behind the plane z = `front`."""
        lowest = -np.inf
        for seen in (self.lidar_view, *self.camera_views.values()):
            near = seen.trim_by_plane([0, 0, -1], -front)
            if not near.is_empty():
                lowest = max(lowest, bounds(near)[1][1])
        return lowest
