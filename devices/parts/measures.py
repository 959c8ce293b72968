"""Every measure of the parts by name, where it is from, and how a rig file sets another."""

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

from recordings.refusal import Refusal

ANY_SIGN = ("camera_m3_below", "board_x", "board_y", "board_turn_deg", "dowel_angle_deg")
MOST = 2000.0  # millimetres: nothing here is larger
MAY_BE_ZERO = ("shelf_thickness", "front_radius", "camera_edge")


@dataclass(frozen=True)
class Measures:
    """Millimetres, and degrees where the name says so. "Below" and "behind" are meant as the camera looks.

    Sources: [D400] Intel's datasheet of the D400 family, 337029; [URDF] the D435 description in Intel's ROS package;
    [TMF] ams's datasheet DS000693; [ISO] ISO 9409-1-50-4-M6; [inferred] no source: measure your own before printing.
    """

    # The camera, a RealSense D435i; left is its own left.
    camera_width: float = 90.0  # [D400]
    camera_height: float = 25.0  # [D400]
    camera_depth: float = 25.05  # [D400], [URDF]
    camera_edge: float = 4.5  # radius of the body's long edges, at least this [inferred]
    camera_front: float = 4.3  # front plate ahead of the lenses' origin: 4.2 to the glass [D400], and 0.1 [URDF]
    camera_colour_left: float = 32.5  # colour lens from the middle of the body: 17.5 and 15 [URDF]
    camera_thread_behind: float = 14.9  # 1/4-20 UNC thread in the bottom, behind the front plate [URDF]
    camera_m3_spacing: float = 45.0  # of two M3 threads in the back [D400]
    camera_m3_below: float = 0.0  # of their line below the middle [inferred]
    camera_m3_depth: float = 3.0  # most that a screw may enter [D400]
    colour_width_deg: float = 69.0  # field of view of the colour camera [D400]
    colour_height_deg: float = 42.0  # [D400]
    depth_width_deg: float = 87.0  # of the two infrared imagers [D400]
    depth_height_deg: float = 58.0  # [D400]
    imager_left: float = 17.5  # left imager from the middle of the body [URDF]
    imager_baseline: float = 50.0  # [D400]
    usb_width: float = 12.0  # room for the plug behind the camera's left end [inferred]

    # The LiDAR, a TMF882x on a board of 1 inch with four holes (SparkFun's Qwiic format).
    lidar_width_deg: float = 41.0  # field of view, the widest map [TMF]
    lidar_height_deg: float = 52.0  # [TMF]
    lidar_window_width: float = 4.6  # package: laser and receiver side by side [TMF]
    lidar_window_height: float = 2.0  # [TMF]
    lidar_above_board: float = 1.4  # optical centre above the board: the package's height [TMF], [inferred]
    board_size: float = 25.4  # SparkFun's 1 inch format
    board_hole_spacing: float = 20.32  # 0.8 inch
    board_hole: float = 3.3  # diameter, 0.13 inch
    board_thickness: float = 1.6  # usual [inferred]
    board_x: float = 0.0  # middle of the board from the optical centre, along the LiDAR's x [inferred]
    board_y: float = 0.0  # along its y [inferred]
    board_turn_deg: float = 0.0  # of the board about the LiDAR's axis

    # The bracket.
    plate_thickness: float = 5.0
    least_post: float = 5.0  # between plate and board, or plate and camera
    post: float = 7.0  # diameter of the posts under the board
    pad: float = 10.0  # diameter of the pads behind the camera
    shelf_thickness: float = 4.0  # under the camera, for the 1/4-20 screw; 0 leaves it out
    shelf_width: float = 14.0
    fit: float = 0.2  # gap between what is printed and what it holds
    foot_thickness: float = 8.0
    foot_depth: float = 40.0
    rib: float = 5.0  # thickness of the ribs between plate and foot
    table_pitch: float = 25.0  # of the holes of an optical table
    m3_clearance: float = 3.4  # ISO 273
    m3_head: float = 5.7  # ISO 7380 button head
    m3_pilot: float = 2.5  # an M3 screw cuts its own thread in plastic
    m3_grip: float = 8.0  # depth of that thread
    m6_clearance: float = 6.6  # ISO 273; a 1/4-20 screw passes, too
    nut_flats: float = 11.4  # 1/4-20 hexagon nut, 7/16 inch, and 0.3
    nut_height: float = 5.0  # of its pocket

    # The patch holder.
    flange: float = 63.0  # [ISO]
    flange_circle: float = 50.0  # four M6 at 45 degrees [ISO]
    dowel: float = 6.0  # [ISO]
    dowel_depth: float = 6.0
    dowel_angle_deg: float = 90.0  # on the same circle [inferred]
    base_thickness: float = 8.0
    standoff: float = 22.0  # column between base and front
    channel: float = 11.5  # for the heads of the M6 screws, 10 wide by ISO 4762
    pilot_depth: float = 10.0  # of the front's screws in the column
    front_thickness: float = 5.0
    front_radius: float = 0.0  # 0: as large as hides the flange
    hide_deg: float = 35.0  # from how far off the patch's axis the front hides the flange
    sheet: float = 0.5  # thickness of the retroreflective sheeting, and depth of its recess [inferred]
    countersink: float = 6.7  # M3 countersunk head, ISO 10642

    # What can be printed.
    wall: float = 2.0
    bed: float = 220.0


def measures_from(said: Mapping[str, float], place: str = "rig.mount") -> Measures:
    """The measures, with those of a rig file; `Refusal` names one that is unknown or impossible."""
    known = [f.name for f in fields(Measures)]
    for name, value in said.items():
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ", expected one that `difflidar mount --example` lists"
            raise Refusal(f"{place} has the unknown measure {name!r}{hint}")
        if name in ANY_SIGN:
            allowed, expected = math.isfinite(value), "a finite number"
        elif name.endswith("_deg"):
            most = 80 if name == "hide_deg" else 170
            allowed, expected = 0 < value < most, f"degrees between 0 and {most}"
        else:
            allowed, expected = 0 < value < MOST or (value == 0 and name in MAY_BE_ZERO), "millimetres above 0"
        if not allowed:
            raise Refusal(f"{place}.{name} is {value:g}, expected {expected}")
    measures = Measures(**said)
    _expect_thick(measures, place)
    return measures


def _expect_thick(m: Measures, place: str) -> None:
    """Refuse measures that leave a wall which is too thin to print."""
    walls = {
        "plate_thickness": m.plate_thickness,
        "rib": m.rib,
        "foot_thickness less nut_height": m.foot_thickness - m.nut_height,
        "base_thickness less dowel_depth": m.base_thickness - m.dowel_depth,
        "front_thickness less sheet": m.front_thickness - m.sheet,
        "base_thickness and standoff less pilot_depth": m.base_thickness + m.standoff - m.pilot_depth,
        "post round m3_pilot": (m.post - m.m3_pilot) / 2,
        "pad round m3_clearance": (m.pad - m.m3_clearance) / 2,
        "flange round its screws": (m.flange - m.flange_circle - m.m6_clearance) / 2,
    }
    if m.shelf_thickness:
        walls["shelf_thickness less fit"] = m.shelf_thickness - m.fit
        walls["shelf_width round m6_clearance"] = (m.shelf_width - m.m6_clearance) / 2
    for name, left in walls.items():
        if left < m.wall - 1e-9:
            raise Refusal(f"{place}: {name} leaves a wall of {left:g} mm, expected at least {m.wall:g} mm (mount.wall)")
