"""Pictures go over the socket as they are, and whatever breaks is heard of at the other end."""

import os
import socket
import stat
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from calibrate.rig import CameraSetup
from devices.camera.open import open_camera
from devices.captures import DeviceLost
from devices.emulated.pictures import PictureClient, millimetres, serve_pictures
from recordings.refusal import Refusal


@pytest.fixture
def address():
    with tempfile.TemporaryDirectory() as folder:  # pytest's own paths are too long for a socket
        yield str(Path(folder) / "camera")


def view(size=(6, 4)):
    rgb = np.arange(size[0] * size[1] * 3, dtype=np.uint8).reshape(size[1], size[0], 3)
    depth = np.linspace(0.1, 3.0, size[0] * size[1], dtype=np.float32).reshape(size[::-1])
    depth[0, 0] = np.nan
    return rgb, depth


def setup(address, size=(6, 4)):
    return CameraSetup(kind="rehearsed", device=address, size=size)


@pytest.mark.parametrize("depth", [True, False])
def test_a_picture_comes_out_as_it_went_in(address, depth):
    rgb, metres = view()
    with serve_pictures(address, view, (6, 4), depth=depth):
        client = PictureClient(address)
        for _ in range(3):
            seen, mm = client.look()
            np.testing.assert_array_equal(seen, rgb)
            if depth:
                assert mm[0, 0] == 0
                np.testing.assert_allclose(mm.ravel()[1:] * 1e-3, metres.ravel()[1:], atol=0.5e-3)
            else:
                assert mm is None
        client.close()


def test_the_camera_of_a_rehearsal_is_opened_by_its_address(address):
    with serve_pictures(address, lambda: view((64, 48)), (64, 48), intrinsics=(50.0, 51.0, 30.0, 20.0), speed=20.0):
        camera = open_camera(setup(address, (64, 48)))
        other = open_camera(setup(address, (64, 48)))  # several may look at one scene
        picture = camera.capture()
        np.testing.assert_array_equal(picture.rgb, view((64, 48))[0])
        np.testing.assert_array_equal(other.capture().rgb, picture.rgb)
        assert camera.said["intrinsics"]["fy"] == 51
        camera.close()
        camera.close()
        other.close()


def test_a_camera_that_is_pulled_out_of_the_scene_is_lost_and_comes_back(address):
    script = iter([view(), DeviceLost("the cable was pulled"), view()])

    def look():
        seen = next(script)
        if isinstance(seen, Exception):
            raise seen
        return seen

    with serve_pictures(address, look, (6, 4)):
        camera = open_camera(setup(address))
        camera.capture()
        with pytest.raises(DeviceLost, match="the cable was pulled"):
            camera.capture()
        camera.capture()
        camera.close()


def test_a_rehearsal_that_ends_is_a_lost_camera(address):
    server = serve_pictures(address, view, (6, 4))
    camera = open_camera(setup(address))
    camera.capture()
    server.close()
    with pytest.raises(DeviceLost, match="went away"):
        camera.capture()
    camera.close()
    assert not os.path.exists(address)


def test_a_scene_without_depth_says_so(address):
    with serve_pictures(address, lambda: (view()[0], None), (6, 4)):
        camera = open_camera(setup(address))
        with pytest.raises(DeviceLost, match="depth=False"):
            camera.capture()
        camera.close()


def test_a_rehearsal_takes_over_what_a_killed_one_left(address):
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(address)
    with serve_pictures(address, view, (6, 4)):
        assert stat.S_IMODE(os.stat(address).st_mode) == 0o600
        PictureClient(address).close()


def test_what_is_not_a_dead_socket_is_left_alone(address):
    with serve_pictures(address, view, (6, 4)):
        with pytest.raises(Refusal, match="in use by another rehearsal"):
            serve_pictures(address, view, (6, 4))
        PictureClient(address).close()
    Path(address).write_text("mine")
    with pytest.raises(Refusal, match="is a file, expected no file"):
        serve_pictures(address, view, (6, 4))
    assert Path(address).read_text() == "mine"


def test_no_rehearsal_and_another_size_are_refused(address):
    with pytest.raises(Refusal, match=r"no rehearsal answers.*difflidar rehearse"):
        open_camera(setup(address))
    with (
        serve_pictures(address, view, (6, 4)),
        pytest.raises(Refusal, match=r"has \[6, 4\] pixels, expected camera.size \[848, 480\]"),
    ):
        open_camera(setup(address, (848, 480)))


@settings(max_examples=40)
@given(hnp.arrays(np.float32, st.tuples(st.integers(1, 4), st.integers(1, 5)), elements=st.floats(width=32)))
def test_depth_is_counted_in_millimetres(depth):
    counts = millimetres(depth)
    for metres, count in zip(depth.ravel().tolist(), counts.ravel().tolist(), strict=True):
        if 0.001 <= metres <= 65.5:
            assert abs(count - metres * 1e3) <= 0.51
        elif not -0.001 <= metres <= 65.54:  # also NaN
            assert count == 0
