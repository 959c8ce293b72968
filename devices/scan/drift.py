"""How the sensor drifted while it scanned, from the pose that it saw again and again."""

from typing import Any

import numpy as np

from devices.scan.journal import Journal


def drift(journal: Journal) -> dict[str, Any] | None:
    """Change of light and of its arrival over the scan, None where the monitor pose was seen less than twice.

    Each look is the mean histogram m of all looks, brighter by a and later by s, above a floor: a m − a s m' + c per
    zone, fitted by least squares weighted with photon noise. Good for shifts below a bin.

    signal: change from the first look to the last relative to the mean, by a line through all of them, over zones;
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
    signal, arrival = np.array([_against(counts.mean(axis=0), look) for look in counts]).T
    change, change_sigma = _rise(times, signal)
    shift, shift_sigma = _rise(times, arrival)
    return {
        "looks": len(looks),
        "signal": change,
        "signal_sigma": change_sigma,
        "arrival_bins": shift,
        "arrival_bins_sigma": shift_sigma,
    }


def _against(mean: np.ndarray, look: np.ndarray) -> tuple[float, float]:
    """Light of a look (P, T) relative to the mean's (P, T), and by how many bins it comes later."""
    floor = np.kron(np.eye(len(mean)), np.ones((mean.shape[1], 1)))
    design = np.column_stack([mean.ravel(), -np.gradient(mean, axis=1).ravel(), floor])
    weight = 1 / np.sqrt(np.maximum(mean.ravel(), 1))
    brighter, later, *_ = np.linalg.lstsq(design * weight[:, None], look.ravel() * weight, rcond=None)[0]
    return float(brighter), float(later / brighter)


def _rise(times_s: np.ndarray, values: np.ndarray) -> tuple[float, float | None]:
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
