"""Frames of a scan as grey images, each decoded once, a few at a time."""

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import cv2
import numpy as np

from recordings.progress import Progress
from recordings.refusal import Refusal

Found = TypeVar("Found")


class GreyFrames:
    """Frames (H, W, 3) uint8 RGB, read as grey (H, W) uint8; all must have the size of the first.

    Where `frames` has a method `grey(i)`, which may decode brightness alone, that is used.
    """

    def __init__(self, frames: Sequence[np.ndarray]) -> None:
        if not len(frames):
            raise Refusal("rgb holds no frames, expected at least one")
        self._frames = frames
        self._shape: tuple[int, ...] | None = None
        self._shape = self.read(0).shape

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self._shape[1], self._shape[0]

    def read(self, index: int) -> np.ndarray:
        """Frame `index` in grey; `Refusal` where it is no colour image of the first frame's size."""
        if hasattr(self._frames, "grey"):
            frame = np.asarray(self._frames.grey(index))
            expected, axes = "(H, W)", 2
        else:
            frame = np.asarray(self._frames[index])
            expected, axes = "(H, W, 3)", 3
        if frame.ndim != axes or frame.shape[2:] not in ((), (3,)) or frame.dtype != np.uint8 or not frame.size:
            raise Refusal(f"rgb[{index}] is {frame.dtype} of shape {frame.shape}, expected uint8 {expected}")
        if self._shape and frame.shape[:2] != self._shape:
            height, width = self._shape
            raise Refusal(
                f"rgb[{index}] is {frame.shape[1]} x {frame.shape[0]} pixels, expected {width} x {height} as in rgb[0]"
            )
        return frame if axes == 2 else cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)

    def each(
        self,
        indices: Sequence[int],
        work: Callable[[int, np.ndarray], Found],
        progress: Progress,
        label: str,
    ) -> Iterator[tuple[int, Found]]:
        """Frame numbers and what `work` makes of each frame, in order, on all cores, few frames ahead.

        Decoding and OpenCV let other threads run; OpenCV's own threads would only compete with these, and rest.
        """
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        threads_before = cv2.getNumThreads()
        waiting: deque = deque()
        cv2.setNumThreads(1)
        try:
            with ThreadPoolExecutor(cores) as pool:
                for index in progress(indices, len(indices), label):
                    index = int(index)
                    waiting.append((index, pool.submit(lambda i: work(i, self.read(i)), index)))
                    if len(waiting) > 2 * cores:
                        done, future = waiting.popleft()
                        yield done, future.result()
                while waiting:
                    done, future = waiting.popleft()
                    yield done, future.result()
        finally:
            cv2.setNumThreads(threads_before)
