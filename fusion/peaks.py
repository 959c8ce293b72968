"""Depths the usual way: the strongest peak of each histogram, as the baseline that better ones are held against."""

import numpy as np
from scipy.constants import speed_of_light

from physics.sensor import SensorModel
from recordings.refusal import Refusal

# Bins on each side of the strongest that share in its centroid: five in all.
BESIDE = 2
# A peak is one where its strongest bin stands out of the pedestal by so many standard deviations of photon noise.
STANDS_OUT = 5.0


def peak_ranges(counts: np.ndarray, sensor: SensorModel) -> np.ndarray:
    """(..., P) metres: the centroid of the five bins about the strongest, less time zero and the pulse's mean delay.

    counts: (..., P, T). The pedestal, the median of the histogram, is taken off first. NaN where no bin stands out of
    it. Nothing else that a sensor does is undone. Raises `Refusal` where shapes do not fit.
    """
    found = np.asarray(counts, float)
    if found.shape[-2:] != (sensor.zones, sensor.bins):
        raise Refusal(f"counts have shape {found.shape}, expected (..., {sensor.zones}, {sensor.bins})")
    pedestal = np.median(found, axis=-1, keepdims=True)
    above = np.maximum(found - pedestal, 0)
    strongest = above.argmax(axis=-1)[..., None]
    near = np.clip(strongest + np.arange(-BESIDE, BESIDE + 1), 0, sensor.bins - 1)
    # At the window's edge a bin would be taken twice.
    twice = np.diff(near, axis=-1, prepend=-1) == 0
    weight = np.where(twice, 0, np.take_along_axis(above, near, axis=-1))
    total = weight.sum(axis=-1)
    bins = ((near + 0.5) * weight).sum(axis=-1) / np.where(total > 0, total, 1)
    pulse = sensor.response
    delay = pulse.time_s @ pulse.probability
    ranges = (bins * sensor.bin_width_s - sensor.time_zero_s - delay) * speed_of_light / 2
    highest, noise = above.max(axis=-1), np.sqrt(np.maximum(pedestal[..., 0], 1))
    return np.where(highest > STANDS_OUT * noise, ranges, np.nan)
