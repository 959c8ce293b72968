"""Histograms of a session: counts by range, the depths fitted to them, and residuals; some frames at a time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr

from mismatch.poisson import signed
from recordings.rrd.arrays import tensors
from recordings.rrd.columns import TENSOR
from viewers.footprint_contours import named
from viewers.session_frame import SessionFrame, SessionRig
from viewers.session_panels import WHITE, Log, colours_of

RESIDUAL_SCALE = 6.0  # of the colours, standard deviations
MARK_BINS = 0.7  # width of a fitted depth
PER_METRE = 1000.0  # ranges are shown in millimetres, which the library takes fast, as whole numbers
MOST_MM, MOST_COUNTS = 1 << 20, (1 << 32) - 1
VALUES = "BarChart:values"
DEPTHS = "depth_of_zone"


@dataclass(frozen=True, eq=False)
class Counted:
    """Of a frame what histograms show. number: of the frame; since_s: seconds since the first; see `SessionFrame`."""

    number: int
    since_s: float
    counts: np.ndarray | None
    surface_m: np.ndarray | None
    surface_share: np.ndarray | None

    @classmethod
    def of(cls, number: int, since_s: float, frame: SessionFrame) -> "Counted":
        """Copies, because whoever pushed the frame may use its arrays again."""
        parts = (frame.counts, frame.surface_m, frame.surface_share)
        return cls(number, since_s, *(None if part is None else np.array(part) for part in parts))


def log_charts(log: Log, rig: SessionRig) -> None:
    """Axes and colours of the charts."""
    colours = colours_of(len(rig.zones))
    lines = rr.SeriesPoints(colors=colours, names=named(rig.zones), markers="circle", marker_sizes=2)
    log(DEPTHS, lines, static=True)
    if rig.range_m is None:
        return
    for zone, range_m, colour in zip(rig.zones, rig.range_m, colours, strict=True):
        width_mm = PER_METRE * (abs(float(np.diff(range_m).mean())) if len(range_m) > 1 else 1.0)
        widths = np.full(len(range_m), width_mm)
        chart = rr.BarChart(np.zeros(1), color=colour, abscissa=PER_METRE * range_m, widths=widths)
        log(f"lidar/zone/{zone}", but_values(chart), static=True)
        log(f"lidar/zone/{zone}/depths", but_values(rr.BarChart(np.zeros(1), color=WHITE)), static=True)


def send_histograms(recording: rr.RecordingStream, rig: SessionRig, frames: Sequence[Counted]) -> None:
    """Send the histograms of some frames, column by column: for each of them alone it takes ten times as long."""
    counted = [frame for frame in frames if frame.counts is not None]
    if counted:
        counts = np.stack([frame.counts for frame in counted])
        whole = np.clip(counts, 0, MOST_COUNTS).astype(np.uint32)
        for p, zone in enumerate(rig.zones):
            chart = rr.BarChart.columns(values=tensors(whole[:, p], TENSOR))
            recording.send_columns(f"lidar/zone/{zone}", _times(counted), chart, strict=True)
        if any(frame.surface_m is not None for frame in counted):
            _send_marks(recording, rig, counted, whole.max(axis=2))
    seen = [frame for frame in frames if frame.surface_m is not None]
    if seen:
        ranges, shares = marks(seen, len(rig.zones))
        at = np.nan_to_num(shares, nan=-1).argmax(axis=2)[..., None]
        strongest = np.take_along_axis(ranges, at, axis=2)[..., 0]
        lines = rr.Scalars.columns(scalars=strongest.ravel()).partition(np.full(len(seen), len(rig.zones)))
        recording.send_columns(DEPTHS, _times(seen), lines, strict=True)


def _times(frames: Sequence[Counted]) -> list[rr.TimeColumn]:
    """Both timelines."""
    return [
        rr.TimeColumn("frame", sequence=[frame.number for frame in frames]),
        rr.TimeColumn("time", duration=[frame.since_s for frame in frames]),
    ]


def log_residual(log: Log, counts: np.ndarray, expected: np.ndarray) -> None:
    """Recorded less simulated, both (P, T), in standard deviations."""
    residual = signed(np.asarray(counts, float), expected).astype(np.float32)
    log("residual", rr.Tensor(residual, dim_names=("zone", "bin"), value_range=(-RESIDUAL_SCALE, RESIDUAL_SCALE)))


def _send_marks(recording: rr.RecordingStream, rig: SessionRig, frames: Sequence[Counted], peaks: np.ndarray) -> None:
    """Bars at the fitted depths, as high as their share of the largest count, peaks (n, P)."""
    ranges, shares = marks(frames, len(rig.zones))
    seen = np.isfinite(ranges)
    # One of no height where nothing is: else the last frame's would stay.
    at_mm = np.where(seen, np.clip(PER_METRE * np.nan_to_num(ranges), 0, MOST_MM), 0).round().astype(np.uint32)
    height = np.where(seen, shares * peaks[..., None], 0).round().astype(np.uint32)
    for p, zone in enumerate(rig.zones):
        width_mm = np.float32(MARK_BINS * PER_METRE * abs(float(np.diff(rig.range_m[p]).mean())))
        chart = rr.BarChart.columns(
            values=tensors(height[:, p], TENSOR),
            abscissa=tensors(at_mm[:, p], TENSOR),
            widths=np.full((len(frames), ranges.shape[2]), width_mm),
        )
        recording.send_columns(f"lidar/zone/{zone}/depths", _times(frames), chart, strict=True)


def marks(frames: Sequence[Counted], zones: int) -> tuple[np.ndarray, np.ndarray]:
    """(n, P, S) ranges of surfaces, metres, and their shares of the light, NaN where there are fewer than S."""
    most = max(1, *(0 if frame.surface_m is None else frame.surface_m.shape[1] for frame in frames))
    table = np.full((2, len(frames), zones, most), np.nan)
    for i, frame in enumerate(frames):
        if frame.surface_m is not None:
            found = frame.surface_m.shape[1]
            table[0, i, :, :found] = frame.surface_m
            table[1, i, :, :found] = 1.0 if frame.surface_share is None else frame.surface_share
    table[1][~np.isfinite(table[0])] = np.nan
    return table[0], table[1]


def but_values(chart: rr.BarChart) -> list[Any]:
    """A chart's components except its values; `from_fields` of this version of the library fails without them."""
    return [part for part in chart.as_component_batches() if part.component_descriptor().component != VALUES]
