"""The patch holder: a column on the arm's flange, a black front with the patch, a blank one for the background."""

from dataclasses import dataclass

import numpy as np

from calibrate.rig import Rig
from devices.parts.measures import Measures, measures_from
from devices.parts.solids import Part, box, cylinder, joined
from recordings.refusal import Refusal

LEAST_CIRCLE = 26.0  # radius on which the front is screwed to the column, between the heads of the M6 screws
TOOL_TOLERANCE_MM = 0.5


@dataclass(frozen=True)
class Holder:
    """The holder; z = 0 on the flange, z up out of the patch, millimetres.

    The column stands on the flange; front and cover are exchanged on it by four M3 screws, which leaves the column,
    hence the arm's tool, as it is.
    """

    measures: Measures
    patch_radius: float

    @staticmethod
    def of(rig: Rig) -> "Holder":
        """The holder for a rig's patch; raises `Refusal` where the patch has no room on the front."""
        holder = Holder(measures_from(rig.mount), rig.patch_radius_m * 1e3)
        m = holder.measures
        needed = holder.circle + m.countersink / 2 + m.wall
        if holder.front_radius < needed:
            raise Refusal(
                f"mount.front_radius is {holder.front_radius:g} mm, expected at least {needed:.1f} mm "
                f"for a recess of {holder.recess:.1f} mm radius and the screws around it"
            )
        return holder

    @property
    def recess(self) -> float:
        """Radius of the recess for the sheeting."""
        return self.patch_radius + self.measures.fit

    @property
    def circle(self) -> float:
        """Radius of the circle of screws that hold the front: outside the recess."""
        return max(LEAST_CIRCLE, self.recess + self.measures.wall + self.measures.countersink / 2)

    @property
    def column_radius(self) -> float:
        """Radius of the column: the flange's, or more where the front's screws need it."""
        return max(self.measures.flange / 2, self.circle + self.measures.m3_pilot / 2 + self.measures.wall)

    @property
    def length(self) -> float:
        """From the flange to the patch, along z: the z of the tool."""
        m = self.measures
        return m.base_thickness + m.standoff + m.front_thickness

    @property
    def front_radius(self) -> float:
        """Radius of the front, which hides column and flange from whoever looks from `hide_deg` off its axis."""
        m = self.measures
        return m.front_radius or self.column_radius + self.length * np.tan(np.radians(m.hide_deg))

    @property
    def column(self) -> Part:
        """Base and column in one, flat on the flange."""
        m, top = self.measures, self.measures.base_thickness + self.measures.standoff
        column, out, r = cylinder((0, 0, 0), top, 2 * self.column_radius), [], m.flange_circle / 2
        for turn in (45, 135, 225, 315):
            across = m.channel / 2
            open_side = box((r, -across, m.base_thickness), (2 * self.column_radius, across, top + 1))
            channel = cylinder((r, 0, m.base_thickness), m.standoff + 1, m.channel) + open_side
            out.append((channel + cylinder((r, 0, -1), m.base_thickness + 2, m.m6_clearance)).rotate([0, 0, turn]))
        for turn in (0, 90, 180, 270):
            out.append(
                cylinder((self.circle, 0, top - m.pilot_depth), m.pilot_depth + 1, m.m3_pilot).rotate([0, 0, turn])
            )
        dowel = cylinder((r, 0, -1), m.dowel_depth + 1, m.dowel + m.fit / 2)
        out.append(dowel.rotate([0, 0, m.dowel_angle_deg]))
        return Part("column", column - joined(out), "print upright; 4 M6 screws and a dowel hold it to the flange")

    @property
    def cover(self) -> Part:
        """The blank front, for the background: all that moves but the patch."""
        m = self.measures
        disc = cylinder((0, 0, 0), m.front_thickness, 2 * self.front_radius)
        sink = (m.countersink - m.m3_clearance) / 2
        screw = cylinder((self.circle, 0, -1), m.front_thickness + 2, m.m3_clearance)
        screw += cylinder((self.circle, 0, m.front_thickness - sink), sink, m.m3_clearance, m.countersink)
        screws = joined([screw.rotate([0, 0, turn]) for turn in (0, 90, 180, 270)])
        return Part("cover", disc - screws, "print in matt black; in place of the front, for the background")

    @property
    def front(self) -> Part:
        """The front: the blank one with a recess, so that the sheeting ends flush with it."""
        m = self.measures
        recess = cylinder((0, 0, m.front_thickness - m.sheet), m.sheet + 1, 2 * self.recess)
        return Part("front", self.cover.solid - recess, "print in matt black, recess up; the sheeting goes into it")

    def tool(self) -> tuple[float, ...]:
        """(6,) what rig.arm.tool must be: metres and rotation vector."""
        return (0.0, 0.0, self.length * 1e-3, 0.0, 0.0, 0.0)

    def mismatch(self, rig: Rig) -> str | None:
        """One sentence where the rig's arm.tool is not this holder, else None."""
        if np.linalg.norm(np.subtract(rig.arm.tool[:3], self.tool()[:3])) * 1e3 <= TOOL_TOLERANCE_MM:
            return None
        said = ", ".join(f"{v * 1e3:g}" for v in rig.arm.tool[:3])
        return (
            f"arm.tool is at ({said}) mm but this holder puts the patch at (0, 0, {self.length:g}) mm from the flange; "
            f'the rig file needs "tool": {list(self.tool())}, or another mount.standoff'
        )
