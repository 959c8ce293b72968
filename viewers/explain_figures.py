"""The figures of a report: small pictures in SVG that take the colours of the page they stand in."""

import io
import re
from collections.abc import Callable

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from mismatch.poisson import signed
from mismatch.verdict import Deviance
from viewers.compared import Compared

# Stands for the page's own text colour; so readers with a dark page see light lines.
INK = "#010203"
RECORDED, BEFORE, AFTER, NOISE = "#9a9a9a", "#d9730d", "#1f78c8", "#4c9a52"
# Blue where less was recorded than simulated, red where more; the grey middle suits light and dark pages.
SIGNED = LinearSegmentedColormap.from_list("signed", ["#0b5fb0", "#7fb6e6", "#e9e9e9", "#f0a07c", "#b01c12"])
STYLE = {
    "svg.fonttype": "none", "svg.hashsalt": "report", "font.family": "sans-serif", "font.size": 9, "axes.titlesize": 9,
    "ytick.labelsize": 8,
    "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK,
    "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "axes.linewidth": 0.6,
}  # fmt: skip
TOP_IN, BOTTOM_IN = 0.25, 0.42
WIDTH_IN = 4.3  # so that text keeps its size on a phone


def histogram(shown: Compared, bins: slice, zone: int, frame: int | None, width_s: float) -> str:
    """Recorded counts of a zone beside both simulations, in one frame or, where `frame` is None, summed over all."""
    pick = (lambda cube: cube[:, zone].sum(axis=0)) if frame is None else (lambda cube: cube[frame, zone])
    recorded, before, after = (pick(cube)[bins] for cube in (shown.recorded, shown.before, shown.after))
    edges = np.arange(bins.start, bins.start + len(recorded) + 1) - 0.5
    title = f"zone {zone}, " + ("all frames" if frame is None else f"frame {shown.frames[frame]}")

    def draw(axes: Axes, below: Axes) -> None:
        axes.stairs(recorded, edges, fill=True, color=RECORDED, alpha=0.55, label="recorded")
        simulated = [(before, BEFORE, "simulated before")]
        if not np.array_equal(before, after):
            simulated.append((after, AFTER, "simulated after"))
        for counts, colour, label in simulated:
            axes.stairs(counts, edges, color=colour, lw=1.4, label=label)
            below.stairs(signed(recorded, counts), edges, color=colour, lw=1.1)
        # On a square-root axis Poisson noise is equally high everywhere.
        axes.set_yscale("function", functions=(lambda y: np.sqrt(np.maximum(y, 0)), np.square))
        top = 1.08 * max(recorded.max(), before.max(), after.max(), 1)
        rounded = {float(f"{t**2:.1g}") for t in np.linspace(0, np.sqrt(top), 5)}
        ticks = sorted(t for t in rounded if t <= top)
        axes.set_yticks(ticks, [f"{t:,.0f}" for t in ticks])
        axes.minorticks_off()
        axes.set(ylim=(0, top), xlim=(edges[0], edges[-1]), title=title, ylabel="counts")
        axes.tick_params(labelbottom=False)
        axes.legend(fontsize=8)
        below.axhspan(-2, 2, color=RECORDED, alpha=0.25, lw=0)
        below.set(xlim=axes.get_xlim(), ylabel="residual", xlabel=f"bin ({width_s * 1e12:.0f} ps each)")

    return _drawn(draw, 3.1, (3, 1))


def residual_map(values: np.ndarray, scale: float, title: str, ylabel: str, first_bin: int, rows: np.ndarray) -> str:
    """Signed deviance (rows, bins) as a picture from -scale to scale; rows: (N,) what the rows are numbered."""

    def draw(axes: Axes) -> None:
        extent = (first_bin - 0.5, first_bin + values.shape[1] - 0.5, len(rows) - 0.5, -0.5)
        picture = axes.imshow(
            values, cmap=SIGNED, vmin=-scale, vmax=scale, aspect="auto", extent=extent, interpolation="none"
        )
        axes.set(title=title, xlabel="bin", ylabel=ylabel)
        ticks = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), 9)).round().astype(int))
        axes.set_yticks(ticks, [str(rows[i]) for i in ticks])
        axes.figure.subplots_adjust(right=0.9)
        axes.figure.colorbar(picture, ax=axes, label="standard deviations", pad=0.02, fraction=0.07)

    return _drawn(draw, 2.7)


def deviances(train: Deviance, heldout: Deviance) -> str:
    """Deviance per cell before and after against the floor, of frames that chose and of those held out."""

    def draw(axes: Axes) -> None:
        for row, fit in enumerate((heldout, train)):
            axes.plot([fit.nominal, fit.explained], [row, row], color=INK, lw=0.8, zorder=1)
            for value, colour, marker, name in (
                (fit.floor, NOISE, "|", "floor"),
                (fit.nominal, BEFORE, "o", "before"),
                (fit.explained, AFTER, "o", "after"),
            ):
                size = 16 if marker == "|" else 7
                axes.plot(
                    value, row, marker, color=colour, ms=size, mew=2, ls="", label=name if row else None, zorder=2
                )
        axes.set_yticks([0, 1], ["held-out\nframes", "frames\nthat chose"])
        axes.set(ylim=(-0.6, 2.0), xlabel="Poisson deviance per cell")
        axes.margins(x=0.08)
        axes.locator_params(axis="x", nbins=5)
        axes.grid(axis="x", alpha=0.3, lw=0.5)
        axes.legend(ncols=3, loc="upper center", fontsize=8, columnspacing=1, handletextpad=0.3)

    return _drawn(draw, 1.9)


def deviance_by_frame(shown: Compared) -> str:
    """Deviance per cell of every frame, before and after, beside what noise gives; held-out frames shaded."""

    def draw(axes: Axes) -> None:
        number = np.arange(len(shown.frames))
        held = np.flatnonzero(~shown.chosen)
        for k, i in enumerate(held):
            axes.axvspan(i - 0.5, i + 0.5, color=RECORDED, alpha=0.18, lw=0, label=None if k else "held out")
        lines = shown.by_frame()
        axes.plot(number, lines["before"], color=BEFORE, lw=1.2, label="before")
        if not np.array_equal(lines["before"], lines["after"]):
            axes.plot(number, lines["after"], color=AFTER, lw=1.2, label="after")
        axes.plot(number, lines["noise"], color=NOISE, lw=1.2, ls="--", label="noise alone")
        ticks = np.unique(np.linspace(0, len(number) - 1, min(len(number), 7)).round().astype(int))
        axes.set_xticks(ticks, [str(shown.frames[i]) for i in ticks])
        low, high = axes.get_ylim()
        axes.set(
            xlabel="frame",
            ylabel="deviance per cell",
            xlim=(-0.5, len(number) - 0.5),
            ylim=(low, high + 0.3 * (high - low)),
        )
        axes.legend(ncols=4, loc="upper center", fontsize=8, columnspacing=1, handlelength=1.2, handletextpad=0.4)

    return _drawn(draw, 2.3)


def _drawn(draw: Callable[..., None], height_in: float, rows: tuple[int, ...] = (1,)) -> str:
    """Graphs one below the other as an SVG element: no metadata, no ids that others have, as wide as its place."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, height_in))
        figure.patch.set_alpha(0)
        graphs = figure.subplots(len(rows), height_ratios=rows, squeeze=False)[:, 0]
        # Fixed margins: to find them out takes ten times as long as to draw.
        above, under = TOP_IN / height_in, BOTTOM_IN / height_in
        figure.subplots_adjust(left=0.19, right=0.985, top=1 - above, bottom=under, hspace=0.12)
        for axes in graphs:
            axes.patch.set_alpha(0)
        draw(*graphs)
        text = io.StringIO()
        FigureCanvasSVG(figure).print_svg(text, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :].replace(INK, "currentColor")
    svg = re.sub(r"<style.*?</style>", "", svg, flags=re.DOTALL)  # it would rule the whole page
    svg = re.sub(r' xmlns(:xlink)?="[^"]*"', "", svg)  # a page knows them
    svg = re.sub(r' id="[\w.]+_\d+"', "", svg)
    return re.sub(r'(<svg [^>]*?) ?(width|height)="[^"]*pt"( [^>]*?)(width|height)="[^"]*pt"', r"\1\3", svg, count=1)
