"""Noise of an earlier frame that a frame shows again: counts that were not cleared, which no light explains."""

import numpy as np
from scipy.stats import norm

from mismatch.checks import BRIGHT, Check

# Frames back that are looked at, as a memory of several histograms has its turns; and products of so many cells, as
# if all weighed alike, from which on their sum is normal.
BACK, ENOUGH = 8, 300.0
TINY = 1e-9


def afterimage(excess: np.ndarray, mean: np.ndarray, frames: np.ndarray) -> Check:
    """The frames back of which most is seen again. excess, mean: (F, P, T) counts beyond, and expected; frames: (F,).

    Were a share s of counts n of a frame left in one after it, that would expect s · (n - μ) more: the score of s is
    the sum of products of what both have beyond their means, over the mean. Noise of frames has nothing in common. What
    a cell has in all frames is no noise, and taken off.
    """
    seen = mean >= BRIGHT
    white = np.where(seen, excess / np.sqrt(np.maximum(mean, TINY)), 0)
    often = np.maximum(seen.sum(axis=0), 1)
    white = np.where(seen, white - white.sum(axis=0) / often, 0)
    worst, back = 1.0, 1
    for away in range(1, BACK + 1):
        before = np.flatnonzero(np.isin(frames + away, frames))
        after = np.searchsorted(frames, frames[before] + away)
        both = seen[before] & seen[after]
        weight = np.where(both, np.sqrt(mean[before] / np.maximum(mean[after], TINY)), 0)
        variance = float((weight**2).sum())
        if variance**2 < ENOUGH * float((weight**4).sum()) or not variance > 0:
            continue
        # Less their mean, two of n numbers of variance 1 have a product of -1/n in the mean.
        score = (weight * (white[before] * white[after] + 1 / often)).sum()
        p = float(norm.sf(score / np.sqrt(variance)))
        if p < worst:
            worst, back = p, away
    ago = "the frame before" if back == 1 else f"the frame {back} before"
    return Check(min(1.0, BACK * worst), f"frames show the noise of {ago} again: counts stay in memory", foreign=True)
