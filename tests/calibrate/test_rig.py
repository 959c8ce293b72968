"""The rig file: what it says is what one gets, what it cannot mean is refused by name, its geometry by hand."""

import json
import math
from dataclasses import asdict, fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.rig import CAMERAS, MODES, RANGINGS, ArmSetup, CameraSetup, LidarSetup, Rig, load_rig, rig_from
from recordings.refusal import Refusal

metres = st.floats(-10, 10)
degrees = st.floats(-180, 180)
above_0 = st.floats(1e-4, 10)
texts = st.text(max_size=12)
lidars = st.builds(
    LidarSetup,
    port=texts,
    baud=st.integers(1, 10**7),
    mode=st.sampled_from(sorted(MODES)),
    ranging=st.sampled_from(RANGINGS),
    kilo_iterations=st.integers(0, 10**5),
    factory_calibration=texts,
)
cameras = st.builds(
    CameraSetup,
    kind=st.sampled_from(CAMERAS),
    device=texts,
    size=st.tuples(st.integers(1, 4096), st.integers(1, 4096)),
    fps=st.integers(1, 300),
    exposure_us=st.integers(0, 10**6),
    emitter=st.booleans(),
    intrinsics=st.one_of(st.just(()), st.tuples(*[st.floats(1, 4096)] * 4)),
)
arms = st.builds(ArmSetup, address=texts, tool=st.tuples(*[metres] * 6), joint_low_deg=st.tuples(*[degrees] * 6))
rigs = st.builds(
    Rig,
    name=texts,
    lidar_position_m=st.tuples(metres, metres, metres),
    lidar_rotation_deg=st.tuples(degrees, degrees, degrees),
    patch_radius_m=above_0,
    patch_distance_m=above_0,
    lidar=lidars,
    camera=cameras,
    arm=arms,
    mount=st.dictionaries(texts, metres, max_size=3),
)
json_values = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-5, 5), st.floats(allow_nan=True), texts),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(texts, inner, max_size=3)),
    max_leaves=5,
)


@given(rigs)
def test_a_rig_comes_back_from_its_file(rig):
    assert rig_from(json.loads(rig.text())) == rig


def test_an_empty_file_is_the_usual_rig(tmp_path):
    path = tmp_path / "rig.json"
    path.write_text("{}")
    assert load_rig(path) == Rig()


def test_what_is_left_out_keeps_its_default():
    rig = rig_from({"lidar": {"mode": "8x8"}, "patch_radius_m": 0.01})
    assert rig == replace(Rig(), patch_radius_m=0.01, lidar=LidarSetup(mode="8x8"))


@given(st.tuples(metres, metres, metres), st.tuples(degrees, degrees, degrees), st.tuples(metres, metres, metres))
def test_the_transform_by_hand(position, rotation, point):
    """Rotation about x, then y, then z, of the LiDAR's axes; its origin at the position."""
    (a, b, c) = (math.radians(angle) for angle in rotation)
    about_x = [[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]]
    about_y = [[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]]
    about_z = [[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]]
    seen = np.array(point)
    for matrix in (about_x, about_y, about_z):
        seen = np.array(matrix) @ seen
    seen += position
    transform = Rig(lidar_position_m=position, lidar_rotation_deg=rotation).lidar_from_camera
    assert transform @ [*seen, 1] == pytest.approx([*point, 1], abs=1e-9)
    assert np.linalg.det(transform) == pytest.approx(1)


@pytest.mark.parametrize(
    ("said", "names"),
    [
        ([], "rig is a list of 0"),
        ("rig", "rig is the text 'rig'"),
        ({"lidr": {}}, "unknown field 'lidr'"),
        ({"lidar": {"mod": "3x3"}}, "rig.lidar has the unknown field 'mod'"),
        ({"lidar": []}, "rig.lidar is a list of 0"),
        ({"lidar": {"mode": "5x5"}}, "lidar.mode is '5x5', expected one of 3x3, 4x4, 3x6, 8x8"),
        ({"lidar": {"ranging": "medium"}}, "expected one of long, short"),
        ({"lidar": {"baud": 0}}, "lidar.baud is 0, expected more than 0"),
        ({"lidar": {"baud": 1.5}}, "rig.lidar.baud is 1.5, expected a whole number"),
        ({"lidar": {"port": 3}}, "rig.lidar.port is 3, expected a text"),
        ({"camera": {"kind": "kinect"}}, "expected one of realsense, opencv, rehearsed"),
        ({"camera": {"size": [848]}}, "rig.camera.size is a list of 1, expected a list of 2"),
        ({"camera": {"size": [848, 0]}}, "camera.size is 0"),
        ({"camera": {"size": [848.5, 480]}}, r"rig.camera.size\[0\] is 848.5, expected a whole number"),
        ({"camera": {"fps": -30}}, "camera.fps is -30"),
        ({"camera": {"emitter": 1}}, "rig.camera.emitter is 1, expected true or false"),
        ({"camera": {"intrinsics": [600, 600]}}, "expected fx, fy, cx, cy"),
        ({"arm": {"tool": [0, 0, 0]}}, "rig.arm.tool is a list of 3, expected a list of 6"),
        ({"arm": {"tool": [0, 0, "0", 0, 0, 0]}}, r"rig.arm.tool\[2\] is the text '0'"),
        ({"lidar_position_m": [0, 0]}, "rig.lidar_position_m is a list of 2, expected a list of 3"),
        ({"lidar_position_m": [0, 0, math.nan]}, r"rig.lidar_position_m\[2\] is nan, expected a finite number"),
        ({"patch_radius_m": 0}, "patch_radius_m is 0"),
        ({"patch_radius_m": True}, "rig.patch_radius_m is True, expected a finite number"),
        ({"patch_distance_m": -1}, "patch_distance_m is -1"),
        ({"patch_distance_m": math.inf}, "expected a finite number"),
        ({"mount": [1]}, "rig.mount is .*, expected an object of numbers by name"),
        ({"mount": {"wall": "2"}}, "rig.mount.wall is the text '2'"),
    ],
)
def test_what_it_cannot_mean_is_named(said, names):
    with pytest.raises(Refusal, match=names) as wrong:
        rig_from(said)
    assert "\n" not in str(wrong.value)


@given(st.sampled_from([f.name for f in fields(Rig)]), json_values)
def test_any_value_is_a_rig_or_a_refusal(name, value):
    try:
        rig = rig_from({name: value})
    except Refusal:
        return
    assert rig_from(json.loads(rig.text())) == rig


@given(st.sampled_from(["lidar", "camera", "arm"]), st.data())
def test_any_value_in_a_part_is_a_rig_or_a_refusal(part, data):
    name = data.draw(st.sampled_from(sorted(asdict(getattr(Rig(), part)))))
    try:
        rig = rig_from({part: {name: data.draw(json_values)}})
    except Refusal:
        return
    assert rig_from(json.loads(rig.text())) == rig


@pytest.mark.parametrize(
    ("content", "says"),
    [(b'{"name": ', "damaged rig file"), (b"\xff\xfe", "damaged rig file"), (b'{"nam": "a"}', "unknown field 'nam'")],
)
def test_a_file_that_is_none_names_its_place(tmp_path, content, says):
    path = tmp_path / "rig.json"
    path.write_bytes(content)
    with pytest.raises(Refusal, match=says) as wrong:
        load_rig(path)
    assert str(wrong.value).startswith(str(path))


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError):
        load_rig(tmp_path / "rig.json")
