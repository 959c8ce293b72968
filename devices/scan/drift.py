"""How the sensor drifted while it scanned, from the pose that it saw again and again."""

from typing import Any

import numpy as np

from devices.scan.journal import Journal

# Of the largest counts of a zone's first histogram: bins that hold its pulses.
IN_PULSE = 0.2


def drift(journal: Journal) -> dict[str, Any] | None:
    """Change of light and of its arrival over the scan, None where the monitor pose was seen less than twice.

    signal: relative change from the first look to the last, by a line through all of them, over zones together;
    signal_sigma: its standard error from the scatter about the line. arrival_bins, arrival_bins_sigma: the same of the
    mean arrival, bins. looks: how often it was seen.
    """
    looks = [
        (s.frames[0].time_s, np.mean([f.counts for f in s.frames], axis=0)) for s in journal.samples("monitor", False)
    ]
    if len(looks) < 2:
        return None
    times = np.array([at for at, _ in looks])
    counts = np.stack([mean for _, mean in looks])
    # Above the floor, within the pulses of the first look: what ambient light does is another matter.
    above = np.maximum(counts - np.median(counts, axis=2, keepdims=True), 0)
    inside = above[0] > IN_PULSE * above[0].max(axis=1, keepdims=True)
    light = (above * inside).sum(axis=(1, 2))
    bins = np.arange(counts.shape[2])
    arrival = (above * inside * bins).sum(axis=(1, 2)) / np.maximum(light, 1)
    signal, signal_sigma = _change(times, light / max(light.mean(), 1e-9))
    shift, shift_sigma = _change(times, arrival)
    return {
        "looks": len(looks),
        "signal": signal,
        "signal_sigma": signal_sigma,
        "arrival_bins": shift,
        "arrival_bins_sigma": shift_sigma,
    }


def _change(times_s: np.ndarray, values: np.ndarray) -> tuple[float, float | None]:
    """Rise of a straight line over the whole time, and its standard error, None for two values."""
    span = np.ptp(times_s)
    if not span:
        return 0.0, None
    design = np.column_stack([np.ones(len(times_s)), (times_s - times_s[0]) / span])
    line, *_ = np.linalg.lstsq(design, values, rcond=None)
    free = len(values) - 2
    if not free:
        return float(line[1]), None
    variance = np.square(values - design @ line).sum() / free * np.linalg.inv(design.T @ design)[1, 1]
    return float(line[1]), float(np.sqrt(variance))
