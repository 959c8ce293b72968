"""Bad luck with a RealSense is one sentence that says what to do."""

from types import SimpleNamespace

import numpy as np
import pyrealsense2 as rs
import pytest

from calibrate.rig import CameraSetup
from devices.camera.open import camera_matrix, open_camera
from devices.camera.pipeline import Pipeline, asked_of, choose, named_on_usb, warm_up, why_not
from devices.captures import DeviceLost
from devices.emulated.camera import SoftwareRealSense
from recordings.refusal import Refusal


def device(serial):
    return SimpleNamespace(get_info=lambda _: serial)


def test_the_first_or_the_named_camera_is_taken():
    one, two = device("111"), device("222")
    assert choose([one, two], "", []) is one
    assert choose([one, two], "222", []) is two
    with pytest.raises(Refusal, match="'333', expected the serial number of a camera here: 111, 222"):
        choose([one, two], "333", [])


def test_no_camera_and_no_permission_are_told_apart():
    with pytest.raises(Refusal, match=r"no RealSense found.*USB 3 port"):
        choose([], "", [])
    with pytest.raises(Refusal, match=r"D435I is plugged in, but.*udev rules"):
        choose([], "", ["Intel(R) RealSense(TM) Depth Camera D435I"])


def test_cameras_that_the_system_sees(tmp_path):
    for name, vendor, product in (
        ("1-1", "8086", "Intel(R) RealSense(TM) Depth Camera 435i"),
        ("1-2", "8086", "Bluetooth"),
        ("1-3", "046d", "RealSense look-alike"),
        ("1-4", "8086", None),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "idVendor").write_text(vendor + "\n")
        if product:
            (tmp_path / name / "product").write_text(product + "\n")
    assert named_on_usb(tmp_path) == ["Intel(R) RealSense(TM) Depth Camera 435i"]
    assert named_on_usb(tmp_path / "none") == []


def test_a_size_that_the_camera_lacks_is_refused_with_those_it_has():
    setup = CameraSetup(kind="rehearsed", size=(64, 48), fps=30)
    source = SoftwareRealSense(lambda: (np.zeros((48, 64, 3), np.uint8), np.zeros((48, 64), np.uint16)), setup)
    asked_of(source.device, setup)
    wrong = CameraSetup(kind="rehearsed", size=(848, 480), fps=90)
    with pytest.raises(Refusal, match=r"no colour and depth of 848x480 at 90 fps; set .* to one of: 64x48 at 30"):
        asked_of(source.device, wrong)
    source.device.register_info(rs.camera_info.usb_type_descriptor, "2.1")
    with pytest.raises(Refusal, match=r"on USB 2.1; use a USB 3 port and cable, or set"):
        asked_of(source.device, wrong)
    source.close()


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("xioctl(VIDIOC_S_FMT) failed Last Error: Device or resource busy", "in use by another program: close it"),
        ("failed to open usb interface: 0, error: RS2_USB_STATUS_ACCESS", "udev rules"),
        ("Couldn't resolve requests", "check its cable"),
        ("failed to set power state", "did not start (failed to set power state): unplug it"),
    ],
)
def test_why_streams_do_not_start(said, told):
    sentence = why_not(said, "123")
    assert sentence.startswith("RealSense 123")
    assert told in sentence


class Gone:
    """A pipeline of the SDK whose device was pulled out, or sends nothing."""

    def __init__(self, raises):
        self._raises = raises

    def try_wait_for_frames(self, _):
        if self._raises:
            raise RuntimeError("Device disconnected")
        return False, None

    def poll_for_frames(self):
        raise RuntimeError("Device disconnected")

    def stop(self):
        raise RuntimeError("stop() cannot be called before start()")


@pytest.mark.parametrize(("raises", "told"), [(True, "stopped: Device disconnected"), (False, "no frame for 0.25 s")])
def test_a_camera_that_goes_away_is_lost(raises, told):
    video = SimpleNamespace(as_video_stream_profile=lambda: None)
    active = SimpleNamespace(get_device=lambda: None, get_stream=lambda _: video)
    pipeline = Pipeline(Gone(raises), active)
    with pytest.raises(DeviceLost, match=told):
        pipeline.wait(0.25)
    with pytest.raises(DeviceLost, match="Device disconnected"):
        pipeline.drain()
    pipeline.close()


def test_a_camera_that_starts_but_sends_nothing_is_refused():
    closed = []

    def wait(_):
        raise DeviceLost("the RealSense sent no frame for 5 s")

    source = SimpleNamespace(wait=wait, close=lambda: closed.append(True))
    with pytest.raises(Refusal, match="RealSense 9 started, but the RealSense sent no frame for 5 s: plug it into"):
        warm_up(source, "9", 3)
    assert closed


@pytest.mark.skipif(len(rs.context().query_devices()) > 0, reason="a RealSense is plugged in")
def test_opening_none_says_so():
    with pytest.raises(Refusal, match="RealSense"):
        open_camera(CameraSetup(kind="realsense"))


def test_a_matrix_needs_a_lens():
    lens = {"fx": 600.0, "fy": 610.0, "ppx": 320.0, "ppy": 240.0}
    at = camera_matrix({"intrinsics": lens}) @ [0.1, 0.2, 1.0]
    np.testing.assert_allclose(at, [380, 362, 1])
    with pytest.raises(Refusal, match=r"expected camera\.intrinsics"):
        camera_matrix({"intrinsics": None})
