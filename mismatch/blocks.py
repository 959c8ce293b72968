"""Frames that choose and frames that decide: blocks in turn, so that neighbours in time are not on both sides."""

import numpy as np

from recordings.refusal import Refusal

BLOCKS = 24


def halves(frames: int, blocks: int = BLOCKS) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the frames that choose and of those that are held out, in so many blocks or more.

    Blocks are dealt by the sequence of Thue and Morse, which has no period: a scene that moves in equal steps, or to
    and fro, shows each of its places on both sides.
    """
    if frames < 2:
        raise Refusal(
            f"the recording has {frames} frame, expected 2 or more: some to choose a model, others to judge it"
        )
    length = max(1, frames // blocks)
    held = np.bitwise_count(np.arange(frames) // length) % 2 == 1
    return np.flatnonzero(~held), np.flatnonzero(held)


def finer(frames: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Other halves, for what shows in so few frames that `halves` has them all on one side.

    Single frames by the same sequence, where blocks are longer; and every other frame.
    """
    singly = halves(frames, frames)
    every = np.arange(frames)
    found = [] if np.array_equal(singly[0], halves(frames)[0]) else [singly]
    return [*found, (every[::2], every[1::2])]
