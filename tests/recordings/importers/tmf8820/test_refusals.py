"""TMF8820 files that cannot be used: refused in a sentence that names the place."""

import contextlib
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from recordings.importers import tmf8820_json
from recordings.refusal import Refusal

KEPT = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=80, deadline=None)


NAN, INFINITE = float("nan"), float("inf")


TURNED = [[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


WRONG = {
    "no hists": ({"hists": ...}, "frame 1 has no hists"),
    "no place in one": ({"dist_to_plane": ...}, "frame 1 has no dist_to_plane"),
    "no pose in one": ({"pose": ...}, "frame 1 has no pose"),
    "ragged": ({"hists": [[1, 2], [3]]}, "frame 1: hists is no array of numbers"),
    "other shape": ({"hists": [[1, 2]] * 9}, r"frame 1: hists has shape \(9, 2\), expected \(9, 16\)"),
    "flat": ({"hists": [1] * 9}, "frame 1: hists is no array"),
    "empty": ({"hists": []}, "frame 1: hists is no array"),
    "text": ({"hists": [["many"] * 16] * 9}, "frame 1: hists is no array"),
    "truth": ({"hists": [[True] * 16] * 9}, "frame 1: hists is no array"),
    "nothing": ({"hists": None}, "frame 1: hists is no array"),
    "holes": ({"hists": [[None] * 16] * 9}, "frame 1: hists is no array"),
    "negative": ({"hists": [[1] * 16] * 8 + [[1] * 15 + [-3]]}, r"frame 1: hists\[8, 15\] is -3"),
    "fraction": ({"hists": [[1] * 16] * 8 + [[1.5] * 16]}, r"frame 1: hists\[8, 0\] is 1.5"),
    "not a number": ({"hists": [[NAN] * 16] * 9}, r"frame 1: hists\[0, 0\] is nan"),
    "too many": ({"hists": [[1 << 32] * 16] * 9}, r"frame 1: hists\[0, 0\] is 4294967296"),
    "far too many": ({"hists": [[10**30] * 16] * 9}, "frame 1: hists is no array"),
    "pose 3x3": ({"pose": np.eye(3).tolist()}, "frame 1: pose has shape"),
    "pose nan": ({"pose": [[NAN] * 4] * 4}, r"frame 1: pose\[0, 0\] is nan"),
    "pose not rigid": ({"pose": [*(2 * np.eye(4)).tolist()[:3], [0, 0, 0, 1]]}, "frame 1: pose"),
    "pose mirrors": ({"pose": TURNED}, "frame 1: pose mirrors"),
    "pose last row": ({"pose": [*np.eye(4).tolist()[:3], [0, 0, 1, 1]]}, "frame 1: pose ends in"),
    "pose far": ({"pose": [[1, 0, 0, 1e300], *np.eye(4).tolist()[1:]]}, "frame 1: pose translation"),
    "distance negative": ({"dist_to_plane": -0.1}, "frame 1: dist_to_plane is -0.1"),
    "distance infinite": ({"dist_to_plane": INFINITE}, "frame 1: dist_to_plane is inf"),
    "distance far": ({"dist_to_plane": 1e200}, "frame 1: dist_to_plane is 1e"),
    "distance a list": ({"dist_to_plane": [0.1]}, "frame 1: dist_to_plane is no array"),
    "other fields": ({"joint_angles": [0, NAN]}, "frame 1: joint_angles holds NaN"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_frame_is_refused_with_its_place(folder, name, frame, written):
    changes, said = WRONG[name]
    with pytest.raises(Refusal, match=said):
        tmf8820_json.stream(written(folder, [frame(), frame(1, **changes), frame(2)]))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "not JSON"),
        (b'[{"hists": [[1', "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b'[{"hists": ' + b"9" * 5000 + b"}]", "not JSON"),
        (b'[{"hists": "\xff\xfe"}]', "not JSON"),
        (b"[]", "not a list of frames"),
        (b"{}", "not a list of frames"),
        (b"[1, 2]", "not a list of frames"),
        (b'"hists"', "not a list of frames"),
    ],
)
def test_what_is_no_list_of_frames_is_refused(folder, content, said):
    path = folder / "sweep.json"
    path.write_bytes(content)
    with pytest.raises(Refusal, match=said):
        tmf8820_json.stream(path)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (None, "zone_spec.json is missing"),
        ("[", "not JSON"),
        ([], "not a list of zones"),
        (lambda zones: zones[:8], "full grid"),
        (lambda zones: zones[:6], "hists has 9 zones, but the table beside it has 6"),
        ([{"center": [0, 0], "width": 1}], "zone 0 lacks"),
        ([{"center": 0, "width": 1, "height": 1}], "zone 0 lacks"),
        ([{"center": [0, 0], "width": 1, "height": 0}], "zone 0 is"),
        ([{"center": [NAN, 0], "width": 1, "height": 1}], "zone 0 is"),
        ([{"center": [90, 0], "width": 1, "height": 1}], "90 degrees"),
    ],
)
def test_a_wrong_zone_table_is_refused(tmp_path, table, said, frame, written, zone_table):
    if table is not None:
        table = table(zone_table()) if callable(table) else table
        (tmp_path / "zone_spec.json").write_text(table if isinstance(table, str) else json.dumps(table))
    with pytest.raises(Refusal, match=said):
        tmf8820_json.stream(written(tmp_path, [frame()]))


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"solid cone\nendsolid cone\n",
        lambda stl: stl(),
        lambda stl: stl(np.zeros((3, 3)))[:-1],
        lambda stl: stl([(NAN, 0, 0)] * 3),
        bytes(80) + b"\xff" * 4,
    ],
)
def test_a_wrong_mesh_is_refused(folder, content, frame, written, stl):
    (folder / "cone.stl").write_bytes(content(stl) if callable(content) else content)
    with pytest.raises(Refusal, match=r"cone\.stl"):
        tmf8820_json.stream(written(folder, [frame(dist_to_plane=...)], "cone.json"))


def test_a_file_that_says_no_place_is_refused(folder, frame, written):
    with pytest.raises(Refusal, match="neither pose nor dist_to_plane"):
        tmf8820_json.stream(written(folder, [frame(dist_to_plane=..., pose=...)]))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=12,
)


@KEPT
@given(
    field=st.sampled_from(["hists", "pose", "dist_to_plane", "distances", "reference_hist", "new"]),
    value=JSON,
    all_frames=st.booleans(),
)
def test_any_json_in_any_field_is_read_or_refused(folder, field, value, all_frames, frame, written):
    frames = [frame(n, **({field: value} if n == 1 or all_frames else {})) for n in range(3)]
    with contextlib.suppress(Refusal):
        tmf8820_json.stream(written(folder, frames)).collect()


@KEPT
@given(table=JSON)
def test_any_json_as_zone_table_is_read_or_refused(folder, table, frame, written, zone_table):
    (folder / "zone_spec.json").write_text(json.dumps([*zone_table()[:8], table]))
    with contextlib.suppress(Refusal):
        tmf8820_json.stream(written(folder, [frame()])).collect()
