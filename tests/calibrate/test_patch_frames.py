import threading

import cv2
import numpy as np
import pytest

from calibrate.patch_frames import GreyFrames
from recordings.progress import silent
from recordings.refusal import Refusal


class Counted:
    """Frames that remember which were read and how many were being used at once."""

    def __init__(self, count, bad=None):
        self.count, self.bad = count, bad
        self.reads, self.open, self.most = [], 0, 0
        self.lock = threading.Lock()

    def __len__(self):
        return self.count

    def __getitem__(self, index):
        if index == self.bad:
            raise Refusal(f"rgb[{index}] is damaged")
        with self.lock:
            self.reads.append(index)
            self.open += 1
            self.most = max(self.most, self.open)
        return np.full((4, 6, 3), index % 256, np.uint8)


def test_frames_come_in_order_few_at_a_time():
    frames = Counted(300)
    grey = GreyFrames(frames)
    seen = []
    for index, level in grey.each(range(300), lambda _, image: int(image[0, 0]), silent, ""):
        with frames.lock:
            frames.open -= 1
        seen.append((index, level))
    assert seen == [(index, index % 256) for index in range(300)]
    assert sorted(frames.reads) == sorted([0, *range(300)])
    assert frames.most < 50


def test_grey_frames_are_preferred_where_there_are_any():
    class Grey(Counted):
        def grey(self, index):
            return np.full((4, 6), 7, np.uint8)

    frames = Grey(3)
    assert GreyFrames(frames).read(2).tolist() == [[7] * 6] * 4
    assert frames.reads == []


def test_what_goes_wrong_in_a_frame_is_heard_and_threads_are_restored():
    before = cv2.getNumThreads()
    with pytest.raises(Refusal, match=r"rgb\[7\] is damaged"):
        list(GreyFrames(Counted(20, bad=7)).each(range(20), lambda _, image: None, silent, ""))
    with pytest.raises(ZeroDivisionError):
        list(GreyFrames(Counted(20)).each(range(20), lambda index, _: 1 // (index - 5), silent, ""))
    assert cv2.getNumThreads() == before


@pytest.mark.parametrize(
    "frame",
    [
        np.zeros((4, 6), np.uint8),
        np.zeros((4, 6, 4), np.uint8),
        np.zeros((4, 6, 3), np.float32),
        np.zeros((4, 6, 3), np.uint16),
        np.zeros((0, 6, 3), np.uint8),
        np.uint8(3),
    ],
    ids=["grey", "rgba", "float", "16 bits", "empty", "number"],
)
def test_frames_that_are_no_colour_images_are_refused(frame):
    with pytest.raises(Refusal, match=r"rgb\[0\] is .*expected uint8 \(H, W, 3\)"):
        GreyFrames([frame])


def test_no_frames_and_other_sizes_are_refused():
    with pytest.raises(Refusal, match="no frames"):
        GreyFrames([])
    frames = GreyFrames([np.zeros((4, 6, 3), np.uint8), np.zeros((4, 5, 3), np.uint8)])
    with pytest.raises(Refusal, match=r"rgb\[1\] is 5 x 4 pixels, expected 6 x 4 as in rgb\[0\]"):
        frames.read(1)
