"""Frames that choose and frames that decide: blocks in turn, so that neighbours in time are not on both sides."""

import numpy as np

from recordings.refusal import Refusal

BLOCKS = 12


def halves(frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the frames that choose and of those that are held out."""
    if frames < 2:
        raise Refusal(
            f"the recording has {frames} frame, expected 2 or more: some to choose a model, others to judge it"
        )
    length = max(1, frames // BLOCKS)
    held = np.arange(frames) // length % 2 == 1
    return np.flatnonzero(~held), np.flatnonzero(held)
