"""The RealSense class on the SDK's software device, and on scripted frames where that device does as it is told."""

import json
import time
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pyrealsense2 as rs
import pytest

from calibrate.rig import CameraSetup
from devices.camera.realsense import CLOCK_PERIOD_MS, IN_FLIGHT, RealSense, metres
from devices.captures import DeviceLost
from devices.clock import DeviceClock
from devices.emulated.camera import SoftwareRealSense
from recordings.refusal import Refusal

SIZE = (64, 48)
SETUP = CameraSetup(kind="rehearsed", size=SIZE)


class Scene:
    """Each look is brighter than the one before, so that a picture tells which look it is."""

    def __init__(self, depth_mm=1500):
        self.looks = 0
        self.depth_mm = depth_mm

    def __call__(self):
        self.looks += 1
        rgb = np.full((SIZE[1], SIZE[0], 3), self.looks % 150, np.uint8)
        rgb[..., 1] += 100
        depth = np.full(SIZE[::-1], self.depth_mm, np.uint16)
        depth[:3] = 0
        return rgb, depth


@pytest.fixture
def opened():
    """Opens cameras that are closed in the end."""
    cameras = []

    def opening(look, setup=SETUP, **said):
        cameras.append(RealSense(SoftwareRealSense(look, setup, **said), setup))
        return cameras[-1]

    yield opening
    for camera in cameras:
        camera.close()


def test_a_picture_is_what_was_seen(opened):
    rng = np.random.default_rng(5)
    rgb = rng.integers(0, 256, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
    depth = np.full(SIZE[::-1], 2345, np.uint16)
    depth[10:20, 30:40] = 0
    picture = opened(lambda: (rgb, depth)).capture()
    np.testing.assert_array_equal(picture.rgb, rgb)
    assert picture.rgb.dtype == np.uint8
    assert picture.depth_m.dtype == np.float32
    # The unknown patch stays unknown but for its rim, into which neighbours reach.
    assert np.isnan(picture.depth_m[11:19, 31:39]).all()
    assert np.isfinite(np.delete(picture.depth_m, np.s_[10:20], axis=0)).all()
    np.testing.assert_allclose(picture.depth_m[np.isfinite(picture.depth_m)], 2.345, rtol=1e-6)


def test_depth_is_moved_into_the_colour_camera(opened):
    # A plane at z with a strip of nearer z2: the strip at depth column u is seen by colour at u + fx shift / z2.
    focal, shift, near, far = 40.0, 0.05, 500, 2000
    depth = np.full(SIZE[::-1], far, np.uint16)
    depth[:, 20:24] = near
    lens = (focal, focal, (SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2)
    camera = opened(lambda: (np.zeros((*SIZE[::-1], 3), np.uint8), depth), intrinsics=lens, shift_m=shift)
    seen = camera.capture().depth_m[20]
    moved = focal * shift / (near * 1e-3)
    assert moved == pytest.approx(4)
    np.testing.assert_allclose(seen[24:28], near * 1e-3, rtol=1e-6)
    np.testing.assert_allclose(seen[31:60], far * 1e-3, rtol=1e-6)
    assert camera.said["depth_to_colour"]["translation"][0] == pytest.approx(shift)


def test_a_camera_without_depth_gives_none(opened):
    scene = Scene()
    camera = opened(lambda: (scene()[0], None), with_depth=False)
    picture = camera.capture()
    assert picture.depth_m is None
    assert picture.rgb[0, 0].tolist() == [1, 101, 1]
    assert "depth_to_colour" not in camera.said
    assert camera.said["projector"] == "none"


def test_a_scene_may_give_metres(opened):
    rgb, counts = Scene()()
    metre = np.where(counts, counts * np.float32(1e-3), np.nan)
    seen = opened(lambda: (rgb, metre)).capture().depth_m
    np.testing.assert_array_equal(seen, opened(lambda: (rgb, counts)).capture().depth_m)


def test_a_picture_of_another_size_never_gets_to_the_sdk(opened):
    small = np.zeros((4, 4, 3), np.uint8), np.zeros((4, 4), np.uint16)
    with pytest.raises(DeviceLost, match=r"shape \(4, 4, 3\), expected \(48, 64, 3\)"):
        opened(lambda: small).capture()


def test_times_and_numbers_go_up(opened):
    camera = opened(Scene(), clock_s=12.0, speed=50.0)
    pictures = [camera.capture() for _ in range(5)]
    for before, after in pairwise(pictures):
        assert after.number > before.number
        assert after.device_s > before.device_s >= 12.0
        assert after.host_s >= before.host_s
    last = pictures[-1].said
    start, read, end = last["clock_read"]
    assert start <= end
    assert read <= pictures[-1].device_s
    assert last["clock"] == "hardware_clock"
    assert last["pictures"] == 5


def test_the_clock_goes_on_where_it_starts_anew(opened):
    camera = opened(Scene(), clock_s=CLOCK_PERIOD_MS / 1e3 - 2, speed=500.0)
    looked = [camera.capture().device_s]
    while looked[-1] < CLOCK_PERIOD_MS / 1e3 + 2:
        looked.append(camera.capture().device_s)
    assert np.all(np.diff(looked) > 0)


def test_the_camera_s_clock_is_known_with_all_its_latency():
    source = SoftwareRealSense(Scene(), SETUP, clock_s=50.0, skew=1e-3)
    camera = RealSense(source, SETUP)
    clock = DeviceClock("camera")
    for picture in (camera.capture() for _ in range(40)):
        clock.heard(picture.device_s, picture.host_s)
        clock.asked(*picture.said["clock_read"])
    relation = clock.relation()
    before, shown, after = time.time(), source.clock_ms() / 1e3, time.time()
    host, sigma = relation.host(shown)
    most = relation.systematic_s + 5 * sigma + 1e-3
    assert np.isfinite(relation.systematic_s)
    assert before - most <= host <= after + most
    camera.close()


class Late:
    """A source whose first frames were made before anybody asked; `told` says whether it tells its time."""

    def __init__(self, source, held, told):
        self._source, self._told = source, told
        self.device, self.colour, self.depth = source.device, source.colour, source.depth
        self.clock_rate = source.clock_rate
        self._held = [source.wait(1) for _ in range(held)]

    def drain(self):
        pass

    def wait(self, timeout_s):
        return self._held.pop(0) if self._held else self._source.wait(timeout_s)

    def clock_ms(self):
        return self._source.clock_ms() if self._told else None

    def close(self):
        self._source.close()


@pytest.mark.parametrize(("held", "told", "seen"), [(2, True, 3), (0, True, 1), (2, False, IN_FLIGHT + 1)])
def test_frames_exposed_before_the_call_are_passed_over(held, told, seen):
    camera = RealSense(Late(SoftwareRealSense(Scene(), SETUP), held, told), SETUP)
    picture = camera.capture()
    assert picture.rgb[0, 0, 0] == seen
    assert camera.tally["discarded"] == seen - 1
    assert ("clock_read" in picture.said) == told
    camera.close()


class Frame:
    """One frame of colour as the SDK hands it over, without a clock of the camera."""

    def __init__(self, number):
        self._number = number

    def __iter__(self):
        yield self

    def get_color_frame(self):
        return self

    def get_frame_number(self):
        return self._number

    def get_timestamp(self):
        return self._number * 33.0

    def get_frame_timestamp_domain(self):
        return rs.timestamp_domain.system_time

    def supports_frame_metadata(self, _):
        return False

    def get_data(self):
        return np.zeros((2, 2, 3), np.uint8)


def scripted(numbers, like):
    """A source of frames with these numbers that is gone after the last."""
    script = iter(numbers)

    def wait(_):
        number = next(script, None)
        if number is None:
            raise DeviceLost("unplugged")
        return Frame(number)

    return SimpleNamespace(
        device=like.device,
        colour=like.colour,
        depth=None,
        clock_rate=1.0,
        drain=lambda: None,
        wait=wait,
        clock_ms=lambda: None,
        close=lambda: None,
    )


@pytest.fixture
def like():
    source = SoftwareRealSense(Scene(), SETUP, with_depth=False)
    yield source
    source.close()


def test_lost_and_repeated_frames_are_counted(like):
    camera = RealSense(scripted([7, 8, 8, 11, 12], like), SETUP)
    live = camera.frames()
    assert [next(live).number for _ in range(5)] == [7, 8, 8, 11, 12]
    with pytest.raises(DeviceLost, match="unplugged"):
        next(live)
    assert (camera.tally["lost"], camera.tally["repeated"]) == (2, 1)


def test_what_happens_between_captures_is_no_loss(like):
    camera = RealSense(scripted([*range(1, 5), *range(90, 94)], like), SETUP)
    assert [camera.capture().number for _ in range(2)] == [1 + IN_FLIGHT, 90 + IN_FLIGHT]
    assert camera.tally["lost"] == 0


def test_a_camera_whose_frames_never_come_anew_is_lost(like):
    with pytest.raises(DeviceLost, match="none of them exposed after"):
        RealSense(scripted([5] * 100, like), SETUP).capture()


@pytest.mark.parametrize("emitter", [False, True])
def test_the_projector_is_as_the_rig_says(opened, emitter):
    setup = CameraSetup(kind="rehearsed", size=SIZE, emitter=emitter, exposure_us=5000)
    camera = opened(Scene(), setup)
    settings = camera.said["settings"]
    assert settings["Stereo Module"]["emitter_enabled"] == emitter
    assert settings["RGB Camera"]["exposure"] == 50
    assert settings["RGB Camera"]["enable_auto_exposure"] == 0
    assert camera.said["projector"].startswith("on" if emitter else "off")
    assert camera.capture().said["depth"]["frame_emitter_mode"] == emitter
    assert camera.capture().said["temperature_c"] == 40
    json.dumps([camera.said, camera.capture().said])


def test_an_exposure_out_of_range_is_refused():
    setup = CameraSetup(kind="rehearsed", size=SIZE, exposure_us=2_000_000)
    with pytest.raises(Refusal, match="exposure_us is 2000000, expected 100 to 1000000"):
        SoftwareRealSense(Scene(), setup)


def test_units_become_metres():
    units = np.array([[0, 1], [1000, 65535]], np.uint16)
    expected = [[None, 0.001], [1.0, 65.535]]
    for got, want in zip(metres(units, 1e-3).ravel(), np.ravel(expected), strict=True):
        assert np.isnan(got) if want is None else got == pytest.approx(want, rel=1e-6)
