"""A sheet of a drawing at full size: views of solids with dimensions, hatched sections, notes."""

import numpy as np
from manifold3d import Manifold
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon
from matplotlib.path import Path as Outline

from viewers.part_edges import Looking, edges

A3_MM = (420.0, 297.0)
INCH_MM = 25.4
SMALL, NORMAL, LARGE = 6.5, 7.5, 11.0  # points


class Sheet:
    """An A3 sheet; its unit is the millimetre, so that it prints at full size."""

    def __init__(self, title: str, notes: list[str]):
        self.figure = Figure(figsize=[side / INCH_MM for side in A3_MM])
        self.axes = self.figure.add_axes((0, 0, 1, 1))
        self.axes.set(xlim=(0, A3_MM[0]), ylim=(0, A3_MM[1]), aspect="equal")
        self.axes.axis("off")
        self.axes.add_patch(Polygon([(8, 8), (412, 8), (412, 289), (8, 289)], fill=False, lw=0.8))
        self.text((14, 280), title, size=LARGE, weight="bold", ha="left")
        self.text((14, 274), "millimetres; full size on A3, printed without scaling; seen in third angle", ha="left")
        for line, note in enumerate(notes):
            self.text((14, 12 + 4.2 * (len(notes) - 1 - line)), note, size=NORMAL, ha="left")

    def text(self, at, words: str, size: float = SMALL, colour="black", **how) -> None:
        """Words at a place."""
        how = {"ha": "center", "va": "center"} | how
        self.axes.text(*at, words, fontsize=size, color=colour, **how)

    def line(self, points, colour="black", width=0.5, **how) -> None:
        """A line through points."""
        self.axes.plot(*np.transpose(points), color=colour, lw=width, solid_capstyle="round", **how)


class View:
    """One view on a sheet: `at` is where the solid's origin lies."""

    def __init__(self, sheet: Sheet, looking: Looking, at: tuple[float, float], name: str, scale: float = 1.0):
        self.sheet, self.looking, self.at, self.name, self.scale = sheet, looking, np.array(at), name, scale

    def place(self, point) -> np.ndarray:
        """(..., 2) on the sheet of points (..., 3) of the solid's frame."""
        return self.at + self.scale * self.looking.flat(point)

    def draw(self, solid: Manifold, among: list[Manifold], colour="black", width=0.7, dashes=True) -> None:
        """The edges of a solid among others, those that are hidden as faint dashes."""
        seen, hidden = (self.at + self.scale * pieces for pieces in edges(solid, self.looking, among))
        if dashes:
            every_other = hidden[np.arange(len(hidden)) % 3 != 0]
            self.sheet.axes.add_collection(LineCollection(every_other, colors="0.72", linewidths=0.3))
        self.sheet.axes.add_collection(LineCollection(seen, colors=colour, linewidths=width, capstyle="round"))

    def fill(self, solid: Manifold, colour, opacity: float) -> None:
        """What a solid covers, tinted."""
        for outline in self.looking.outline(solid):
            patch = Polygon(self.at + self.scale * outline, color=colour, alpha=opacity, lw=0, zorder=0)
            self.sheet.axes.add_patch(patch)

    def cut(self, solid: Manifold, colour="0.35", hatch="/////") -> None:
        """The section of a solid by the plane through its origin that faces the viewer, hatched."""
        axes = self.looking.axes
        section = solid.transform(np.column_stack([axes, np.zeros(3)])).slice(0.0).to_polygons()
        corners, codes = [], []
        for outline in section:
            closed = np.vstack([outline, outline[:1]])
            corners.append(self.at + self.scale * closed)
            codes += [Outline.MOVETO] + [Outline.LINETO] * (len(closed) - 2) + [Outline.CLOSEPOLY]
        if corners:
            shape = Outline(np.vstack(corners), codes)
            self.sheet.axes.add_patch(PathPatch(shape, fc="none", ec=colour, hatch=hatch, lw=0.7))

    def axis_cross(self, origin, directions, name: str, colour) -> None:
        """The axes of a frame: (3, 3), columns x, y, z, those that do not point at the viewer."""
        start = self.place(origin)
        self.sheet.axes.plot(*start, "o", color=colour, ms=2.5)
        for label, direction in zip("xyz", np.transpose(directions), strict=True):
            tip = self.place(np.asarray(origin) + 11 * direction)
            if np.linalg.norm(tip - start) > 4 * self.scale:
                arrow = {"arrowstyle": "-|>", "color": colour, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
                self.sheet.axes.annotate("", tip, start, arrowprops=arrow)
                across = (tip - start)[0] / np.linalg.norm(tip - start)
                side = "center" if abs(across) < 0.5 else "left" if across > 0 else "right"
                self.sheet.text(start + 1.15 * (tip - start), f"{label} {name}", colour=colour, ha=side)

    def measure(self, a, b, away: float, words: str | None = None, along: int = 0) -> None:
        """A dimension from point a to b, (3,), along the page's x (0) or y (1); `away`: where its line stands.

        away: distance of the line from the view's origin, on the other axis of the page, millimetres.
        """
        a, b = self.place(a), self.place(b)
        other = 1 - along
        if abs(a[along] - b[along]) < 0.05:
            return
        ends = []
        for point in (a, b):
            end = point.copy()
            end[other] = self.at[other] + away
            beyond = end.copy()
            beyond[other] += np.copysign(1.2, end[other] - point[other])
            self.sheet.line([point, beyond], colour="0.45", width=0.25)
            ends.append(end)
        length = abs(ends[1][along] - ends[0][along])
        arrow = {"arrowstyle": "<|-|>", "color": "0.2", "lw": 0.4, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 5}
        self.sheet.axes.annotate("", ends[0], ends[1], arrowprops=arrow)
        middle = (ends[0] + ends[1]) / 2
        middle[other] += 1.6 if along == 0 else -1.6
        backing = {"fc": "white", "ec": "none", "pad": 0.3, "alpha": 0.85}
        words = words or f"{length / self.scale:.1f}".removesuffix(".0")
        self.sheet.text(middle, words, rotation=0 if along == 0 else 90, bbox=backing)

    def point_out(self, point, words: str, offset) -> None:
        """Words beside a point, with a line to it."""
        start = self.place(point)
        arrow = {"arrowstyle": "-", "color": "0.45", "lw": 0.35, "shrinkA": 0, "shrinkB": 0}
        self.sheet.axes.annotate(
            words, start, start + np.asarray(offset, float), fontsize=SMALL, ha="center", va="center", arrowprops=arrow
        )

    def caption(self, at) -> None:
        """The view's name, at a place relative to its origin."""
        self.sheet.text(self.at + np.asarray(at, float), self.name, size=NORMAL, weight="bold")
