"""Graphs of how calibrations agree: over all thresholds, and as the scan gets shorter."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from calibrate.sparse import SparseScan
from recordings.atomic import written_aside


def save_iou_curve(path: str | Path, thresholds: np.ndarray, iou: np.ndarray, marked: float) -> None:
    """Write overlap against threshold as a PNG; iou: (len(thresholds), P). A line a zone, and their mean."""
    figure = Figure(figsize=(6, 4), dpi=120, layout="constrained")
    axes = figure.subplots()
    axes.plot(thresholds, iou, color="0.75", lw=0.8)
    axes.plot(thresholds, iou.mean(axis=1), color="C0", lw=2, label="mean over zones")
    axes.axvline(marked, color="C3", ls=":", label=f"threshold {marked:g}")
    axes.set(xlabel="threshold (fraction of the peak)", ylabel="IoU of the supports", ylim=(0, 1), xlim=(0, 1))
    axes.legend()
    _save(figure, path)


def save_sparse_curve(path: str | Path, scans: Sequence[SparseScan]) -> None:
    """Write cosine and IoU against the number of scan points as a PNG: mean and standard deviation over zones."""
    figure = Figure(figsize=(6, 4), dpi=120, layout="constrained")
    axes = figure.subplots()
    points = [scan.points for scan in scans]
    for name, values in (("cosine", [s.cosine for s in scans]), ("IoU", [s.iou for s in scans])):
        axes.errorbar(points, [v.mean() for v in values], [v.std() for v in values], marker="o", capsize=3, label=name)
    axes.set(xscale="log", xlabel="scan points", ylabel="agreement with the full map", ylim=(0, 1.02))
    axes.set_xticks(points, [str(n) for n in points])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend()
    _save(figure, path)


def _save(figure: Figure, path: str | Path) -> None:
    canvas = FigureCanvasAgg(figure)
    with written_aside(path) as aside, aside.open("wb") as file:
        canvas.print_png(file)
