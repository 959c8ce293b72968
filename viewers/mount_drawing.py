"""The drawing of the printed parts: the bracket with what it holds and what that sees, and the patch holder."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_pdf import PdfPages

from devices.parts.bracket import Bracket
from devices.parts.holder import Holder
from devices.parts.solids import Part, bounds, posed, view
from recordings.atomic import written_aside
from viewers.part_edges import Looking
from viewers.part_sheet import Sheet, View

CAMERA, LIDAR = "tab:blue", "tab:red"
FRONT = Looking((-1, 0, 0), (0, -1, 0))
SIDE = Looking((0, 0, 1), (0, -1, 0))
TOP = Looking((-1, 0, 0), (0, 0, -1))
CORNER = Looking((-0.8, 0, 0.6), (-0.18, -0.954, -0.24))
ABOVE = Looking((1, 0, 0), (0, 1, 0))
# The section runs through two of the flange's screws; the view from above is turned with it.
THROUGH_SCREWS = Looking((np.sqrt(0.5), np.sqrt(0.5), 0), (0, 0, 1))


def save_drawing(path: Path, bracket: Bracket, part: Part, holder: Holder, notes: list[str]) -> None:
    """Write the drawing, a PDF of two sheets, whole or not at all."""
    sheets = bracket_sheet(bracket, part, notes), holder_sheet(holder)
    with written_aside(path) as aside, PdfPages(aside, metadata={"CreationDate": None}) as pages:
        for sheet in sheets:
            pages.savefig(sheet.figure)


def bracket_sheet(bracket: Bracket, part: Part, notes: list[str]) -> Sheet:
    """The bracket from three sides and from a corner, with camera, LiDAR and their fields of view."""
    sheet = Sheet("Bracket for camera and LiDAR", notes)
    placed = bracket.placed
    among = [part.solid, placed.camera, placed.board]
    low, high = bounds(part.solid)
    middle = (low + high) / 2
    # Third angle: what is seen from above lies above, what is seen from the left lies left.
    front = View(sheet, FRONT, (300 + middle[0], 62 + high[1]), "front")
    side = View(sheet, SIDE, (150, front.at[1]), "side, from the left of the front view")
    top = View(sheet, TOP, (front.at[0], 222), "top")
    corner = View(sheet, CORNER, (105, 205) - CORNER.flat(middle), "from a corner")
    for each in (front, side, top, corner):
        if each in (side, top):
            each.fill(
                view((placed.measures.colour_width_deg, placed.measures.colour_height_deg), reach=40), CAMERA, 0.1
            )
            m = placed.measures
            seen = view(
                (m.lidar_width_deg, m.lidar_height_deg), (m.lidar_window_width, m.lidar_window_height), reach=60
            )
            each.fill(posed(seen, placed.rotation, placed.position), LIDAR, 0.12)
        each.draw(part.solid, among, dashes=each is not corner)
        each.draw(placed.camera, among, CAMERA, 0.6, dashes=False)
        each.draw(placed.board, among, LIDAR, 0.6, dashes=False)
        each.axis_cross((0, 0, 0), np.eye(3), "camera", CAMERA)
        each.axis_cross(placed.position, placed.rotation, "LiDAR", LIDAR)
    _measure_front(front, bracket, low, high)
    _measure_side(side, bracket, low, high)
    _measure_top(top, bracket, low, high)
    lowest = min(CORNER.flat(np.vstack([low, high, (low[0], high[1], high[2]), (high[0], high[1], high[2])]))[:, 1])
    corner.caption((CORNER.flat(middle)[0], lowest - 7))
    return sheet


def _measure_front(front: View, bracket: Bracket, low: np.ndarray, high: np.ndarray) -> None:
    placed = bracket.placed
    p, (pad, other) = placed.position, bracket.pads
    bottom = -high[1]
    upper = -min(-placed.measures.camera_height / 2, low[1])
    front.measure((0, 0, 0), p, upper + 14, along=0)
    front.measure((pad[0], pad[1], 0), (other[0], other[1], 0), upper + 6, along=0)
    front.measure((low[0], high[1], 0), (high[0], high[1], 0), bottom - 16, along=0)
    holes = bracket.table_holes
    front.measure((*holes[0][:1], high[1], 0), (*holes[1][:1], high[1], 0), bottom - 8, along=0)
    front.measure((*holes[1][:1], high[1], 0), (*holes[2][:1], high[1], 0), bottom - 8, along=0)
    left = -max(high[0], placed.camera_middle + placed.measures.camera_width / 2)
    front.measure((0, 0, 0), p, left - 6, along=1)
    front.measure((high[0], low[1], 0), (high[0], high[1], 0), left - 14, along=1)
    right = -min(low[0], placed.camera_middle - placed.measures.camera_width / 2)
    _, _, _, last = placed.holes
    front.measure(placed.holes[0], last, right + 7, along=1)
    front.point_out(last, _hole_words(bracket), (right - front.looking.flat(last)[0] + 26, -6))
    front.caption((-bracket.placed.camera_middle, bottom - 24))


def _hole_words(bracket: Bracket) -> str:
    m, pins = bracket.placed.measures, bracket.screwed.count(False)
    words = f"{4 - pins} x pilot {m.m3_pilot:g} for M3"
    return words + (f"\n{pins} x pin {bracket.pin:g}" if pins else "")


def _measure_side(side: View, bracket: Bracket, low: np.ndarray, high: np.ndarray) -> None:
    placed, m = bracket.placed, bracket.placed.measures
    top, bottom = max(m.camera_height / 2, -low[1]), -high[1]
    side.measure((0, 0, 0), placed.position, top + 8, along=0)
    side.measure((0, 0, placed.camera_back), (0, 0, m.camera_front), top + 16, along=0)
    side.measure((0, high[1], low[2]), (0, high[1], high[2]), bottom - 16, along=0)
    side.measure((0, high[1], low[2]), (0, high[1], bracket.face), bottom - 8, along=0)
    side.measure((0, high[1], bracket.face), (0, high[1], bracket.table_holes[0][2]), bottom - 8, along=0)
    side.measure((0, bracket.foot_top, low[2]), (0, high[1], low[2]), low[2] - 6, along=1)
    side.measure((0, 0, low[2]), (0, high[1], low[2]), low[2] - 14, along=1)
    for words, at, reach, half, colour in (
        (f"camera {m.colour_height_deg:g}°", np.zeros(3), 40, -m.colour_height_deg / 2, CAMERA),
        (f"LiDAR {m.lidar_height_deg:g}°", placed.position, 60, m.lidar_height_deg / 2, LIDAR),
    ):
        rotation = np.eye(3) if half < 0 else placed.rotation
        corner = at + rotation @ [0, reach * np.tan(np.radians(half)), reach]
        side.sheet.text(side.place(corner) + np.array([-8, -np.sign(half) * 4]), words, colour=colour)
    side.caption((0, bottom - 24))


def _measure_top(top: View, bracket: Bracket, low: np.ndarray, high: np.ndarray) -> None:
    placed, m = bracket.placed, bracket.placed.measures
    left = m.camera_width / 2 - placed.camera_middle
    ends = (-left, 0, placed.camera_back), (placed.camera_middle + m.camera_width / 2, 0, placed.camera_back)
    back = -low[2]
    top.measure(*ends, back + 14, along=0)
    top.measure((0, 0, placed.camera_back), (placed.camera_middle, 0, placed.camera_back), back + 6, along=0)
    right = max(left, -low[0])
    thread = (placed.camera_middle, 0, m.camera_front - m.camera_thread_behind)
    top.measure((placed.camera_middle, 0, m.camera_front), thread, right + 6, along=1)
    top.measure((0, 0, placed.camera_back), (0, 0, bracket.face), right + 13, along=1)
    if m.shelf_thickness:
        top.point_out(thread, "1/4-20 UNC\nfrom below", (right + placed.camera_middle + 26, -4))
    top.caption((-placed.camera_middle, back + 22))


def holder_sheet(holder: Holder) -> Sheet:
    """Column and front from the patch's side, and both in section."""
    m, top = holder.measures, holder.measures.base_thickness + holder.measures.standoff
    column, front = holder.column, holder.front
    notes = [
        f"column.stl: {column.note}",
        f"front.stl: {front.note}; cover.stl is the same without the recess",
        f"4 x M3 x 12 countersunk, blackened; recess {2 * holder.recess:.1f} wide, {m.sheet:g} deep for the sheeting",
        f"flange to patch: {holder.length:g}, the z of rig.arm.tool",
    ]
    sheet = Sheet("Patch holder for an ISO 9409-1-50-4-M6 flange", notes)
    above = View(sheet, ABOVE, (75, 200), "column, from the patch")
    above.draw(column.solid, [column.solid])
    above.measure((-holder.column_radius, 0, 0), (holder.column_radius, 0, 0), -holder.column_radius - 8, along=0)
    angle = np.radians(m.dowel_angle_deg)
    dowel = m.flange_circle / 2 * np.array([np.cos(angle), np.sin(angle), 0])
    above.point_out(dowel, f"dowel {m.dowel:g}, {m.dowel_depth:g} deep, from below", (-12, 18))
    screw = m.flange_circle / 2 * np.array([1, 1, 0]) * np.sqrt(0.5)
    above.point_out(screw, f"4 x {m.m6_clearance:g} on circle {m.flange_circle:g}", (22, 22))
    above.point_out(
        (holder.circle, 0, 0),
        f"4 x pilot {m.m3_pilot:g}\n{m.pilot_depth:g} deep, circle {2 * holder.circle:g}",
        (26, -8),
    )
    above.caption((0, -holder.column_radius - 16))
    face = View(sheet, ABOVE, (300, 195), "front")
    face.draw(front.solid, [front.solid], dashes=False)
    face.measure((-holder.front_radius, 0, 0), (holder.front_radius, 0, 0), -holder.front_radius - 8, along=0)
    face.measure((-holder.recess, 0, 0), (holder.recess, 0, 0), holder.recess + 2, along=0)
    face.point_out((holder.circle, 0, 0), f"4 x {m.m3_clearance:g}\ncountersunk {m.countersink:g}", (46, -30))
    face.caption((0, -holder.front_radius - 16))
    cut = View(sheet, THROUGH_SCREWS, (150, 62), "section through two of the M6 screws")
    cut.cut(column.solid)
    cut.cut(front.solid.translate([0, 0, top]), hatch="\\\\\\\\\\")
    outer = THROUGH_SCREWS.axes[0]
    cut.measure((0, 0, 0), (0, 0, holder.length), holder.front_radius + 16, f"{holder.length:g} tool", along=1)
    cut.measure((0, 0, 0), (0, 0, m.base_thickness), -holder.column_radius - 8, along=1)
    cut.measure(0 * outer, [0, 0, top], -holder.front_radius - 8, along=1)
    cut.measure(-holder.recess * outer, holder.recess * outer, holder.length + 8, along=0)
    cut.measure(-m.flange_circle / 2 * outer, m.flange_circle / 2 * outer, -8, along=0)
    cut.caption((0, -16))
    return sheet
