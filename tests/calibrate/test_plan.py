"""The scan's order against the published scans, and against walking the grid by hand."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.plan import ScanPlan
from recordings.refusal import Refusal

plans = st.builds(
    ScanPlan,
    columns=st.integers(1, 12),
    rows=st.integers(1, 12),
    repeats=st.integers(1, 4),
    first=st.integers(0, 3),
    order=st.sampled_from(["snake", "raster"]),
)


def test_snake_by_hand():
    plan = ScanPlan(3, 2, repeats=2, first=1)
    assert plan.cells.tolist() == [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]]
    assert plan.frames.tolist() == [[1, 2], [3, 4], [5, 6], [7, 8], [9, 10], [11, 12]]
    assert plan.count == 13


def test_published_scans_run_in_this_order(published_maps):
    """Columns of the plan sort every row's xs, rows sort the ys from the bottom of the image to its top."""
    name = "spad_calib_3x3_longrange_bins15_35.npz"
    published = np.load(published_maps / name)
    xs, ys = published["xs"].reshape(45, 80), published["ys"].reshape(45, 80)
    plan = ScanPlan(80, 45)
    column, row = plan.cells.T.reshape(2, 45, 80)
    for x, c in zip(xs, column, strict=True):
        assert np.array_equal(np.argsort(x), np.argsort(c))
    assert (np.diff(np.median(ys, axis=1)) < 0).all()
    assert (np.diff(row[:, 0]) == 1).all()


@given(plans)
def test_every_cell_once_and_every_frame_of_the_grid_once(plan):
    assert len({tuple(cell) for cell in plan.cells.tolist()}) == plan.columns * plan.rows
    assert plan.cells.max(axis=0).tolist() == [plan.columns - 1, plan.rows - 1]
    assert plan.frames.shape == (plan.columns * plan.rows, plan.repeats)
    assert plan.frames.ravel().tolist() == list(range(plan.first, plan.count))


@given(plans)
def test_a_snake_never_jumps_and_a_raster_always_ascends(plan):
    steps = np.abs(np.diff(plan.cells, axis=0)).sum(axis=1)
    if plan.order == "snake":
        assert (steps == 1).all()
    else:
        number = plan.cells @ [1, plan.columns]
        assert number.tolist() == sorted(number.tolist())


@given(plans)
def test_meta_round_trip_through_json(plan):
    meta = {"sensor": "TMF8828"} | json.loads(json.dumps(plan.to_meta()))
    assert ScanPlan.from_meta(meta) == plan


def test_numpy_integers_become_plain():
    plan = ScanPlan(np.int64(4), np.uint8(3))
    assert json.dumps(plan.to_meta()) == json.dumps(ScanPlan(4, 3).to_meta())


def test_meta_without_a_plan():
    assert ScanPlan.from_meta({"sensor": "TMF8828"}) is None


@pytest.mark.parametrize(
    ("described", "sentence"),
    [
        (None, "holds None, expected columns, rows"),
        ([80, 45], r"holds \[80, 45\], expected columns, rows"),
        ({"columns": 80}, "lacks 'rows'"),
        ({"columns": 80, "rows": 45, "colour": 1}, "has 'colour'"),
        ({"columns": "80", "rows": 45}, "columns is '80', expected an integer of 1 or more"),
        ({"columns": 80, "rows": 4.5}, "rows is 4.5"),
        ({"columns": 80, "rows": True}, "rows is True"),
        ({"columns": 80, "rows": 45, "order": "spiral"}, "order is 'spiral', expected snake or raster"),
        ({"columns": 80, "rows": 45, "order": ["snake"]}, r"order is \['snake'\]"),
        ({"columns": 10**6, "rows": 10**6}, "expected at most 10000000"),
    ],
)
def test_malformed_meta_is_refused(described, sentence):
    with pytest.raises(Refusal, match=sentence):
        ScanPlan.from_meta({"plan": described})


@pytest.mark.parametrize("numbers", [(0, 5), (5, -1), (5, 5, 0), (5, 5, 1, -1)])
def test_numbers_out_of_range_are_refused(numbers):
    with pytest.raises(Refusal, match="expected an integer of"):
        ScanPlan(*numbers)


@pytest.mark.parametrize(("text", "plan"), [("80x45", (80, 45)), (" 80x45 ", (80, 45)), ("40x23x3", (40, 23, 3))])
def test_parse(text, plan):
    assert ScanPlan.parse(text) == ScanPlan(*plan)


@given(st.text(max_size=12))
def test_parse_refuses_or_agrees(text):
    try:
        plan = ScanPlan.parse(text)
    except Refusal:
        return
    numbers = [int(number) for number in text.split("x")]
    assert (plan.columns, plan.rows) == tuple(numbers[:2])


@pytest.mark.parametrize("text", ["", "80", "80x", "80x45x", "80X45", "-80x45", "0x45", "80x45x3x1", "8 0x45"])
def test_parse_refuses(text):
    with pytest.raises(Refusal, match="scan plan"):
        ScanPlan.parse(text)


@given(st.integers(1, 5), st.integers(1, 4), st.integers(1, 3), st.integers(0, 2), st.data())
def test_lost_frames_take_their_cells_with_them(columns, rows, repeats, first, data):
    whole = ScanPlan(columns, rows, repeats, first)
    lost = data.draw(st.sets(st.integers(0, whole.planned - 1)))
    plan = ScanPlan(columns, rows, repeats, first, lost=tuple(lost))
    kept = [i for i in range(whole.planned) if i not in lost]
    expected = [
        (cell, [kept.index(f) for f in frames])
        for cell, frames in zip(whole.cells.tolist(), whole.frames.tolist(), strict=True)
        if not lost & set(frames)
    ]
    assert plan.cells.tolist() == [cell for cell, _ in expected]
    assert plan.frames.tolist() == [frames for _, frames in expected]
    assert plan.count == len(kept)


@pytest.mark.parametrize("lost", [(99,), (-1,), ("a",), 3])
def test_impossible_losses_are_refused(lost):
    with pytest.raises(Refusal, match="lost"):
        ScanPlan(3, 3, lost=lost)
