"""What is made of a scan's metadata."""

import numpy as np
import pytest

from recordings.importers.capture.metadata import pinhole, range_mode, scan_plan

WHOLE = list(range(13))


def test_the_grid_is_read_off_the_positions_of_the_arm(published_metadata):
    plan = {"columns": 4, "rows": 3, "order": "snake", "first": 1, "repeats": 1, "lost": []}
    assert scan_plan(published_metadata, WHOLE) == plan
    # A scan that broke off, or began late, ran over the same grid.
    assert scan_plan(published_metadata, WHOLE[1:7]) == plan | {"lost": [0, 7, 8, 9, 10, 11, 12]}


def test_repeats_multiply_the_iterations(published_metadata):
    twice = published_metadata | {"repeats_per_point": 2}
    assert scan_plan(twice, list(range(25)))["repeats"] == 2
    assert scan_plan(twice, list(range(26))) is None


def test_an_iteration_that_is_there_twice_leaves_no_plan(published_metadata):
    assert scan_plan(published_metadata, sorted([*WHOLE, 5])) is None


@pytest.mark.parametrize("last", [11, 13, 3600])
def test_a_scan_that_may_be_shifted_or_is_longer_than_its_grid_has_no_plan(published_metadata, last):
    assert scan_plan(published_metadata, list(range(last + 1))) is None


def test_the_published_grid_is_assumed_for_its_own_length_only():
    plan = scan_plan({}, [0, *range(2, 3601)])
    assert plan == {"columns": 80, "rows": 45, "order": "snake", "first": 1, "repeats": 1, "lost": [1]}
    assert scan_plan({}, list(range(3600))) is None


def test_steps_named_in_the_metadata_are_used():
    plan = scan_plan({"Y_STEPS": 6, "Z_STEPS": 2}, WHOLE)
    assert (plan["columns"], plan["rows"]) == (6, 2)
    assert scan_plan({"Y_STEPS": 999_999, "Z_STEPS": 999_999}, WHOLE) is None
    assert scan_plan({"Y_STEPS": 0, "Z_STEPS": 2}, WHOLE) is None


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((5, 2)),
        np.zeros((12,)),
        np.zeros((0, 3)),
        np.arange(36.0).reshape(12, 3),
        np.arange(36).reshape(12, 3),
    ],
)
def test_positions_that_are_no_snake_give_no_plan(points):
    assert scan_plan({"robot_grid_points": points}, WHOLE) is None


def test_a_raster_is_not_taken_for_a_snake(published_metadata):
    points = published_metadata["robot_grid_points"].copy()
    points[4:8] = points[4:8][::-1]
    assert scan_plan({"robot_grid_points": points}, WHOLE) is None


@pytest.mark.parametrize(
    ("said", "mode"),
    [
        ("LONG", "LONG"),
        ("short", "SHORT"),
        ("RangeMode.SHORT", "SHORT"),
        ("macro", None),
        (7, None),
        (None, None),
    ],
)
def test_range_mode(said, mode):
    assert range_mode({"range_mode": said}) == mode


@pytest.mark.parametrize(
    "said",
    [None, "colour", {}, {"fx": 1, "fy": 1, "ppx": 0}, {"fx": 1, "fy": 1, "ppx": 0, "ppy": float("nan")}]
    + [{"fx": fx, "fy": 1, "ppx": 0, "ppy": 0} for fx in (0, -1, "1", True, 10**400)],
)
def test_a_camera_that_is_not_well_described_is_left_out(said):
    assert pinhole({"realsense_intrinsics": said}, 480, 848) is None
    assert pinhole({"realsense_intrinsics": {"color": said}}, 480, 848) is None
