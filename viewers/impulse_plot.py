"""A graph of an estimated impulse response with its error."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from calibrate.impulse import ImpulseEstimate
from recordings.atomic import written_aside


def save_impulse_plot(path: str | Path, estimate: ImpulseEstimate) -> None:
    """Write the response, or each zone's, on a linear and a logarithmic scale as a PNG; bands are one sigma."""
    figure = Figure(figsize=(11, 4.2), dpi=120, layout="constrained")
    several, errors = np.atleast_2d(estimate.probability), np.atleast_2d(estimate.sigma)
    # Density by bin, which does not depend on the steps.
    per_bin = estimate.bin_width_s / (estimate.time_s[1] - estimate.time_s[0])
    time = estimate.time_s * 1e9
    for axes, scale in zip(figure.subplots(1, 2), ("linear", "log"), strict=True):
        for zone, (row, sigma) in enumerate(zip(several * per_bin, errors * per_bin, strict=True)):
            low = np.maximum(row - sigma, 1e-9) if scale == "log" else row - sigma
            axes.fill_between(time, low, row + sigma, color=f"C{zone}", alpha=0.3, lw=0)
            axes.plot(time, row, color=f"C{zone}", lw=1, label=f"zone {zone}" if len(several) > 1 else "response ± 1σ")
        axes.set(xlabel="time after the nominal arrival (ns)", ylabel="probability per bin", yscale=scale)
        core = time[(several.max(axis=0) > 0.02 * several.max())]
        if scale == "linear":
            axes.set_xlim(core[0] - 0.1, core[-1] + 0.3)
        else:
            axes.set_ylim(1e-6, 2 * several.max() * per_bin)
        axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    canvas = FigureCanvasAgg(figure)
    with written_aside(path) as aside, aside.open("wb") as file:
        canvas.print_png(file)
