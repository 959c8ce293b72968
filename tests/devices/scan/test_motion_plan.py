"""Plans of a scan: where the tool goes, against arithmetic by hand, and what makes no plan."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from devices.scan.motion_plan import MotionPlan, load_plan, plan_from
from recordings.refusal import Refusal

LEVEL = (0.0, np.pi / 2, 0.0)
CORNERS = {
    "lower_left": [0.7, -0.4, 0.2, *LEVEL],
    "upper_left": [0.7, -0.4, 0.6, *LEVEL],
    "upper_right": [0.6, 0.4, 0.6, *LEVEL],
}


def test_corners_and_middle_by_hand():
    plan = plan_from(CORNERS | {"columns": 5, "rows": 3})
    poses = plan.poses(np.array([0, 4, 10, 14, 7]))
    np.testing.assert_allclose(
        poses[:, :3], [[0.7, -0.4, 0.2], [0.6, 0.4, 0.2], [0.7, -0.4, 0.6], [0.6, 0.4, 0.6], [0.65, 0, 0.4]], atol=1e-12
    )
    np.testing.assert_allclose(poses[:, 3:], np.tile(LEVEL, (5, 1)), atol=1e-12)
    assert plan.middle == 7


@given(
    turns=st.lists(st.tuples(*[st.floats(-0.01, 0.01)] * 3), min_size=3, max_size=3),
    columns=st.integers(2, 9),
    rows=st.integers(2, 9),
)
def test_between_corners_that_are_slightly_turned_the_tool_turns_evenly(turns, columns, rows):
    level = Rotation.from_rotvec(LEVEL)
    corners = {}
    for (name, pose), turn in zip(CORNERS.items(), turns, strict=True):
        corners[name] = [*pose[:3], *(Rotation.from_rotvec(turn) * level).as_rotvec()]
    plan = plan_from(corners | {"columns": columns, "rows": rows})
    poses = plan.poses(np.arange(plan.size)).reshape(rows, columns, 6)
    for (row, column), name in {(0, 0): "lower_left", (-1, 0): "upper_left", (-1, -1): "upper_right"}.items():
        np.testing.assert_allclose(poses[row, column, :3], corners[name][:3], atol=1e-12)
        off = Rotation.from_rotvec(poses[row, column, 3:]) * Rotation.from_rotvec(corners[name][3:]).inv()
        assert off.magnitude() < 1e-9
    steps = [
        (Rotation.from_rotvec(b[3:]) * Rotation.from_rotvec(a[3:]).inv()).magnitude()
        for row in poses
        for a, b in pairwise(row)
    ]
    assert np.ptp(steps) < 1e-6
    assert max(steps) <= 0.04 / (columns - 1)


def test_a_plan_survives_its_file(tmp_path):
    plan = plan_from(CORNERS | {"columns": 7, "order": "adaptive", "speed_m_s": 0.1})
    (tmp_path / "plan.json").write_text(plan.text())
    assert load_plan(tmp_path / "plan.json") == plan


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"lower_left": None}, "lacks lower_left"),
        ({"columns": 0}, "columns is 0, expected 1 to"),
        ({"columns": 2.5}, "columns is 2.5, expected a whole number"),
        ({"rows": "many"}, "rows is the text 'many', expected a finite number"),
        ({"columns": 2000, "rows": 2000}, "2000 x 2000 positions"),
        ({"order": "spiral"}, "order is 'spiral', expected one of snake, raster, adaptive"),
        ({"passes": "both"}, "passes is 'both', expected one of separate"),
        ({"speed_m_s": 3}, "speed_m_s is 3.0, expected 0.001 to 1"),
        ({"upper_left": [0, 0, 0]}, "upper_left is a list of 3, expected a list of 6"),
        ({"upper_right": [0.7, -0.4, 0.9, *LEVEL]}, "lie on one line"),
        ({"upper_right": [0.6, 0.4, 0.6, 0, np.pi / 2 + 0.1, 0]}, "upper_right: the tool is turned by 5.7 degrees"),
        ({"colums": 3}, "unknown field 'colums'"),
    ],
)
def test_what_is_no_plan_is_refused_by_its_field(change, sentence):
    said = {name: value for name, value in (CORNERS | change).items() if value is not None}
    with pytest.raises(Refusal, match=sentence):
        plan_from(said)


def test_a_file_that_is_no_json_is_refused_by_its_name(tmp_path):
    (tmp_path / "plan.json").write_text("{columns: 3}")
    with pytest.raises(Refusal, match=r"plan.json: damaged scan plan"):
        load_plan(tmp_path / "plan.json")


def test_defaults_alone_are_no_plan():
    with pytest.raises(Refusal):
        plan_from(json.loads(MotionPlan().text()))
