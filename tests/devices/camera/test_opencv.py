"""Any camera of OpenCV: right colours, fresh frames, and refusals that say what to do."""

import cv2
import numpy as np
import pytest

from calibrate.rig import CameraSetup
from devices.camera.open import open_camera
from devices.camera.opencv import STALE, open_opencv
from devices.captures import DeviceLost
from recordings.refusal import Refusal

SETUP = CameraSetup(kind="opencv", device="0", size=(8, 6), fps=30)


class Video:
    """What cv2.VideoCapture does: frame k is blue k, green 100, red 200."""

    def __init__(self, size=(8, 6), frames=100, opens=True, time_ms=0.0):
        self._size, self._frames, self._opens, self._time_ms = size, frames, opens, time_ms
        self.read_so_far, self.asked, self.released = 0, {}, False

    def __call__(self, place):
        self.place = place
        return self

    def isOpened(self):
        return self._opens

    def set(self, what, value):
        self.asked[what] = value
        return True

    def get(self, what):
        return self._time_ms if what == cv2.CAP_PROP_POS_MSEC else self.asked.get(what, 0.0)

    def getBackendName(self):
        return "SCRIPT"

    def grab(self):
        self.read_so_far += 1
        return self.read_so_far <= self._frames

    def read(self):
        if not self.grab():
            return False, None
        bgr = np.empty((*self._size[::-1], 3), np.uint8)
        bgr[:] = self.read_so_far, 100, 200
        return True, bgr

    def release(self):
        self.released = True


def test_a_frame_is_fresh_and_its_colours_are_in_order():
    video = Video(time_ms=2500.0)
    camera = open_opencv(SETUP, video)
    assert video.place == 0
    waiting = video.read_so_far
    picture = camera.capture()
    # Red, green, blue; and all frames that may have waited were passed over.
    assert picture.rgb[0, 0].tolist() == [200, 100, waiting + STALE + 1]
    assert picture.depth_m is None
    assert picture.device_s == 2.5
    assert camera.capture().number - picture.number == STALE + 1
    camera.close()
    assert video.released


def test_settings_and_lens_come_from_the_rig():
    setup = CameraSetup(kind="opencv", size=(8, 6), fps=15, exposure_us=5000, intrinsics=(7.0, 8.0, 4.0, 3.0))
    video = Video()
    said = open_opencv(setup, video).said
    assert video.asked[cv2.CAP_PROP_EXPOSURE] == 50
    assert video.asked[cv2.CAP_PROP_FPS] == 15
    assert [said["intrinsics"][k] for k in ("fx", "fy", "ppx", "ppy", "width", "height")] == [7, 8, 4, 3, 8, 6]
    assert open_opencv(SETUP, Video()).said["intrinsics"] is None


def test_a_camera_without_a_clock_has_no_time():
    picture = open_opencv(SETUP, Video()).capture()
    assert np.isnan(picture.device_s)
    assert picture.said["clock"] == "none"


def test_a_camera_that_stops_is_lost():
    camera = open_opencv(SETUP, Video(frames=3))
    with pytest.raises(DeviceLost, match="camera 0 sent no frame"):
        camera.capture()


@pytest.mark.parametrize(
    ("video", "told"),
    [
        (Video(opens=False), "camera 0 does not open: plug it in"),
        (Video(frames=0), "opens but sends no frame"),
        (Video(size=(16, 12)), "sends 16x12, expected 8x6: set camera.size"),
    ],
)
def test_bad_luck_is_one_sentence(video, told):
    with pytest.raises(Refusal, match=told):
        open_opencv(SETUP, video)
    assert video.released


def test_a_real_video_is_opened_by_its_path(tmp_path):
    path = tmp_path / "film.avi"
    film = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 30, (64, 48))
    if not film.isOpened():
        pytest.skip("this OpenCV writes no video")
    for _ in range(12):
        film.write(np.full((48, 64, 3), (10, 100, 220), np.uint8))
    film.release()
    camera = open_camera(CameraSetup(kind="opencv", device=str(path), size=(64, 48)))
    np.testing.assert_allclose(camera.capture().rgb.mean((0, 1)), [220, 100, 10], atol=6)
    camera.close()
