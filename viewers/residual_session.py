"""An explanation as a rerun session: recorded and simulated histograms and their residuals on one timeline."""

from pathlib import Path

import numpy as np
import rerun as rr
from rerun import blueprint as rrb

from mismatch.explain import Explanation
from mismatch.poisson import signed
from mismatch.verdict import Verdict
from recordings.atomic import written_aside
from viewers.compared import Compared, bins_of_interest, compared
from viewers.explain_figures import AFTER, BEFORE, NOISE, RECORDED
from viewers.wording import found_in_words, grouped, headline, plain_name, quantity

MOST_ZONES = 9  # with histograms of their own, those that changed most; the residuals hold all zones
MOST_FRAMES = 360  # drawn; the deviance is that of every frame
LEAST_SCALE = 4.0  # of the residuals, standard deviations
HEIGHT = 0.6  # of a histogram, relative to its width
# Of lines; negative: points of the screen. The simulations lie above the recording.
WIDTHS, ORDER = {"recorded": -2.0, "before": -1.0, "after": -1.0}, {"recorded": 1, "before": 2, "after": 3}
COLOURS = {"recorded": RECORDED, "before": BEFORE, "after": AFTER, "noise": NOISE}


def write_residuals(explanation: Explanation, path: str | Path) -> None:
    """Write a session that opens laid out: histograms, residuals before and after side by side, deviance, verdict."""
    shown = compared(explanation)
    told = shown.improvement if explanation.explained.forms else shown.remaining
    zones = np.sort(np.argsort(-told.sum(axis=0))[:MOST_ZONES])
    with written_aside(path) as aside, rr.RecordingStream("difflidar") as session:
        session.save(str(aside), default_blueprint=_blueprint(zones, bins_of_interest(shown)))
        text = rr.TextDocument(verdict_text(explanation.verdict), media_type="text/markdown")
        session.log("verdict", text, static=True)
        _deviance(session, shown)
        _frames(session, shown, zones)
        session.flush()
        session.disconnect()


def verdict_text(verdict: Verdict) -> str:
    """The verdict as markdown."""
    parts = [f"# {headline(verdict)}", found_in_words(verdict)]
    for effect in verdict.effects:
        told = "\n".join(
            f"* {plain_name(name)}{f' [{index}]' if index else ''}: {quantity(one.value, one.sigma, one.unit)}"
            for name, values in grouped(effect.parameters)
            for index, one in values
        )
        parts += [f"## {plain_name(effect.id)}", effect.sentence, told]
    parts += [verdict.next_measurement or "", *verdict.notes]
    parts.append(
        "Residuals are the signed square root of the deviance, in standard deviations of photon noise: "
        "yellow where more was recorded than simulated, cyan where less. Histograms: recorded grey, simulated before "
        "the effects orange, after blue; their height is the square root of the counts, on which noise is equally high."
    )
    return "\n\n".join(part for part in parts if part)


def _deviance(session: rr.RecordingStream, shown: Compared) -> None:
    """Deviance per cell of every frame."""
    indexes = [
        rr.TimeColumn("frame", sequence=shown.frames),
        rr.TimeColumn("time", duration=shown.time_s - shown.time_s[0]),
    ]
    for name, values in shown.by_frame().items():
        session.log(f"deviance/{name}", rr.SeriesLines(colors=_rgb(name), names=name), static=True)
        session.send_columns(f"deviance/{name}", indexes, rr.Scalars.columns(scalars=values), strict=True)


def _frames(session: rr.RecordingStream, shown: Compared, zones: np.ndarray) -> None:
    """Histograms of some zones and residuals of all, frame by frame."""
    pairs = {"before": shown.before, "after": shown.after}
    residuals = {name: signed(shown.recorded, simulated).astype(np.float32) for name, simulated in pairs.items()}
    # One scale for both, so that what vanishes is seen to vanish.
    scale = max(LEAST_SCALE, float(np.quantile(np.abs(residuals["before"]), 0.999)))
    bins, count = bins_of_interest(shown), len(shown.frames)
    tops = np.maximum(shown.recorded, shown.before).max(axis=(0, 2)).clip(1)
    wide = bins.stop - bins.start
    for p in zones:
        top = -HEIGHT * wide
        line = [[bins.start - 0.5, top], [bins.start + wide - 0.5, top]]
        label = rr.LineStrips2D(
            [line], labels=f"{tops[p]:,.0f} counts", colors=[128, 128, 128], radii=-0.5, show_labels=True
        )
        session.log(f"zone/{p}/scale", label, static=True)
    for f in np.unique(np.linspace(0, count - 1, min(count, MOST_FRAMES)).round().astype(int)):
        session.set_time("frame", sequence=int(shown.frames[f]))
        session.set_time("time", duration=float(shown.time_s[f] - shown.time_s[0]))
        for name, values in residuals.items():
            picture = rr.Tensor(values[f], dim_names=("zone", "bin"), value_range=(-scale, scale))
            session.log(f"residual/{name}", picture)
        for p in zones:
            for name, counts in {"recorded": shown.recorded, **pairs}.items():
                outline = _outline(counts[f, p, bins], bins.start, tops[p])
                line = rr.LineStrips2D([outline], colors=_rgb(name), radii=WIDTHS[name], draw_order=ORDER[name])
                session.log(f"zone/{p}/{name}", line)


def _outline(counts: np.ndarray, first_bin: int, top: float) -> np.ndarray:
    """(2·T, 2) points of a histogram's steps: bin, and up the square root of counts, on which noise is equally high."""
    x = np.arange(first_bin, first_bin + len(counts) + 1) - 0.5
    height = -HEIGHT * len(counts) * np.sqrt(np.maximum(counts, 0) / top)
    return np.stack([np.repeat(x, 2)[1:-1], np.repeat(height, 2)], axis=1)


def _rgb(name: str) -> list[int]:
    """The colour of a curve, 0 to 255."""
    return [int(COLOURS[name][i : i + 2], 16) for i in (1, 3, 5)]


def _blueprint(zones: np.ndarray, bins: slice) -> rrb.Blueprint:
    """Histograms on the left; residuals, deviance and the verdict on the right."""
    wide = bins.stop - bins.start
    bounds = rrb.VisualBounds2D(
        x_range=(bins.start - 0.03 * wide, bins.stop + 0.03 * wide), y_range=(-1.15 * HEIGHT * wide, 0.08 * wide)
    )
    histograms = rrb.Grid(
        *(rrb.Spatial2DView(origin=f"zone/{p}", name=f"zone {p}", visual_bounds=bounds) for p in zones),
        grid_columns=int(np.ceil(np.sqrt(len(zones)))),
        name="histograms",
    )
    residuals = [
        rrb.TensorView(
            origin=f"residual/{name}",
            name=f"residual {name} (zone by bin)",
            scalar_mapping=rrb.TensorScalarMapping(colormap="CyanToYellow", mag_filter="nearest"),
            slice_selection=rrb.TensorSliceSelection(width=1, height=0),
            view_fit="fill",
        )
        for name in ("before", "after")
    ]
    return rrb.Blueprint(
        rrb.Horizontal(
            histograms,
            rrb.Vertical(
                rrb.Horizontal(*residuals),
                rrb.TimeSeriesView(origin="deviance", name="deviance per cell: before, after, noise alone"),
                rrb.TextDocumentView(origin="verdict", name="verdict"),
            ),
            column_shares=[1, 1],
        ),
        rrb.TimePanel(state="collapsed", timeline="frame", play_state="paused"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )
