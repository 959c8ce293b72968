"""What the chip itself finds in its histograms: two objects a zone, each a distance and a confidence."""

import numpy as np

from physics.timing import BIN_WIDTH_S, ZERO_BINS

LIGHT_M_S = 299_792_458.0
RECORDS = 36  # zones 1-9 and 10-18, object 1, then the same for object 2
THRESHOLD = 6  # the datasheet's default confidence threshold
# Bins after the crosstalk of the cover glass, and about the first object, in which no other one is looked for.
NEAR_BINS, APART_BINS = 3, 8


def find_objects(counts: np.ndarray, ranging: str) -> tuple[np.ndarray, np.ndarray]:
    """Distances, mm, and confidences, (36,) uint16 and uint8 in the order of the result registers; 0 where none is.

    counts: (bursts, 10, T), channel 0 the reference. The chip's own algorithm is not published; this one takes the two
    highest bins after the crosstalk, centres them by their neighbours, and calls a peak's height over the spread of
    the baseline its confidence.
    """
    distance, confidence = np.zeros((2, 2, 9)), np.zeros((2, 2, 9))  # object, burst, channel
    zero = np.array(ZERO_BINS[ranging])
    mm_per_bin = BIN_WIDTH_S[ranging] * LIGHT_M_S / 2 * 1000
    for burst, channels in enumerate(np.asarray(counts, float)[:2, 1:]):
        baseline = np.median(channels, axis=1, keepdims=True)
        left = channels - baseline
        left[np.arange(left.shape[1]) < zero[:, None] + NEAR_BINS] = 0
        for number in range(2):
            at = left.argmax(axis=1)
            peak = left[np.arange(9), at]
            found = peak / np.sqrt(baseline[:, 0] + 1)
            seen = found >= THRESHOLD
            distance[number, burst] = np.where(seen, (_centre(left, at) - zero) * mm_per_bin, 0)
            confidence[number, burst] = np.where(seen, np.minimum(found, 255), 0)
            left[np.abs(np.arange(left.shape[1]) - at[:, None]) <= APART_BINS] = 0
    _nearest_first(distance, confidence)
    whole = np.clip(np.rint(distance), 0, 65535).astype(np.uint16)
    return whole.ravel(), confidence.astype(np.uint8).ravel()


def _centre(heights: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Centre of mass of each row's highest bin and its two neighbours, bins."""
    around = np.clip(at[:, None] + np.arange(-1, 2), 0, heights.shape[1] - 1)
    mass = np.maximum(np.take_along_axis(heights, around, axis=1), 0)
    return (mass * around).sum(axis=1) / np.maximum(mass.sum(axis=1), 1e-9)


def _nearest_first(distance: np.ndarray, confidence: np.ndarray) -> None:
    """Change places where both objects are there and the second is nearer."""
    swap = (distance[1] > 0) & (distance[1] < distance[0])
    for values in (distance, confidence):
        values[:, swap] = values[::-1, swap]
