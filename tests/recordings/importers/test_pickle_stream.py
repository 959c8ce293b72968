"""The importer of capture files against what was put into them."""

import sys

import numpy as np
import pytest

from recordings.importers import pickle_stream
from recordings.refusal import Refusal


@pytest.mark.parametrize("protocol", [2, 3, 4, 5])
def test_a_published_file_comes_out_as_it_was_written(capture_file, frames, protocol):
    file = capture_file(protocol=protocol)
    assert "cc_hardware" not in sys.modules
    assert pickle_stream.reads(file.path)
    stream, read, meta = frames(file.path)
    assert stream.count == len(read) == 13
    for n, frame in enumerate(read):
        file.assert_same_frame(frame, n)
    assert stream.static["zone_grid"].tolist() == [3, 3]
    assert stream.static["image_size"].tolist() == [20, 12]
    assert stream.static["intrinsics"].tolist() == [[15.0, 0, 9.5], [0, 15.5, 5.75], [0, 0, 1]]
    assert float(stream.static["bin_width_s"]) == 0.38e-9
    assert meta["plan"] == {"columns": 4, "rows": 3, "order": "snake", "first": 1, "repeats": 1, "lost": []}
    assert meta["iter"] == list(range(13))
    assert "missing_iters" not in meta
    assert meta["publisher_metadata"]["robot_grid_points"] == file.metadata["robot_grid_points"].tolist()
    assert meta["arrays_left_out"] == ["realsense_data.raw_depth_image", "realsense_data.raw_rgb_image"]
    assert any("bgr8" in line for line in meta["assumed"])
    assert any("timestamp_s" in line for line in meta["assumed"])


def test_it_collects_into_a_recording(capture_file):
    file = capture_file()
    recording = pickle_stream.stream(file.path).collect()
    assert recording.counts.shape == (13, 9, 128)
    assert recording.timestamp_s.tolist() == list(range(13))
    assert recording.meta["sensor"] == "TMF8828"


def test_names_of_numpy_1_are_read(capture_file, frames):
    file = capture_file(protocol=3)
    written = file.path.read_bytes()
    assert b"cnumpy._core.multiarray\n" in written
    file.path.write_bytes(written.replace(b"cnumpy._core.", b"cnumpy.core."))
    _, read, _ = frames(file.path)
    for n, frame in enumerate(read):
        file.assert_same_frame(frame, n)


def test_a_member_pickled_by_name_is_known(capture_file, frames):
    file = capture_file(protocol=3)
    written = file.path.read_bytes()
    by_name = b"c__builtin__\ngetattr\nccc_hardware.drivers.spads.spad\nSPADDataType\nX\x09\0\0\0HISTOGRAM\x86R"
    at = written.index(b"ccc_hardware")
    end = written.index(b"R", at + len(b"ccc_hardware.drivers.spads.spad\nSPADDataType\n"))
    file.path.write_bytes(written[:at] + by_name + written[end + 1 :])
    _, read, _ = frames(file.path)
    file.assert_same_frame(read[0], 0)


@pytest.mark.parametrize("zones", [(3, 3), (8, 8), (4, 4), (3, 6), (9,), (64,)])
def test_any_layout_of_zones(capture_file, frames, zones):
    file = capture_file(zones=zones, key="histogram", iterations=range(2))
    stream, read, _ = frames(file.path)
    side = {1: (int(np.sqrt(zones[0])),) * 2}.get(len(zones), zones)
    assert tuple(stream.static["zone_grid"]) == side
    np.testing.assert_array_equal(read[1]["counts"], file.histogram(1).reshape(-1, 128))


def test_a_scan_without_a_camera(capture_file, frames):
    file = capture_file(edit=lambda n, record: record.pop("realsense_data"))
    stream, read, _ = frames(file.path)
    assert set(read[0]) == {"counts", "timestamp_s"}
    assert "image_size" not in stream.static
    assert "intrinsics" not in stream.static


def test_a_lost_record_shifts_nothing(capture_file, frames):
    file = capture_file(iterations=[0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 12])
    _, read, meta = frames(file.path)
    assert meta["iter"] == [0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 12]
    assert meta["missing_iters"] == meta["plan"]["lost"] == [3, 11]
    file.assert_same_frame(read[3], 3)


def test_a_record_that_is_there_twice_is_kept_and_listed(capture_file, frames):
    file = capture_file(iterations=[0, 1, 2, 2, 3])
    _, read, meta = frames(file.path)
    assert meta["duplicate_iters"] == [2]
    assert "plan" not in meta
    assert len(read) == 5


def test_records_out_of_order_are_put_in_order(capture_file, frames):
    file = capture_file(iterations=[0, 2, 1, 3])
    _, read, meta = frames(file.path)
    assert meta["iter"] == [0, 1, 2, 3]
    file.assert_same_frame(read[1], 2)


def test_times_are_used_where_records_have_them(capture_file, frames):
    def timed(n, record):
        record["timestamp_s"] = 100.5 + 2 * n

    _, read, meta = frames(capture_file(edit=timed).path)
    assert [frame["timestamp_s"] for frame in read[:3]] == [100.5, 102.5, 104.5]
    assert not any("timestamp_s" in line for line in meta["assumed"])


def test_a_record_unlike_the_others_is_left_out_and_listed(capture_file, frames):
    def spoil(n, record):
        if n == 0:
            record["realsense_data"] = {}
        if n == 4:
            del record["realsense_data"]["aligned_rgb_image"], record["realsense_data"]["raw_rgb_image"]
        if n == 6:
            record.pop(next(key for key in record if key not in ("iter", "realsense_data")))

    _, read, meta = frames(capture_file(edit=spoil).path)
    assert len(read) == 10
    assert meta["missing_iters"] == [0, 4, 6]
    assert set(meta["records_left_out"]) == {"1", "5", "7"}
    assert meta["records_left_out"]["5"] == "has colour: none, expected (12, 20, 3) uint8 as in most records"
    assert "no histogram" in meta["records_left_out"]["7"]


def test_short_range_is_taken_from_the_metadata(capture_file, frames, published_metadata):
    file = capture_file(metadata=published_metadata | {"range_mode": "SHORT"})
    stream, _, meta = frames(file.path)
    assert float(stream.static["bin_width_s"]) == 92.5e-12
    assert meta["range_mode"] == "SHORT"


def test_a_range_mode_nobody_named_is_said_to_be_assumed(capture_file, frames):
    _, _, meta = frames(capture_file(metadata={}).path)
    assert "names none" in meta["assumed"][0]
    assert "range_mode" not in meta


def test_a_camera_of_another_size_gives_no_intrinsics(capture_file, frames, published_metadata):
    config = {"color_width": 848, "color_height": 480}
    stream, _, _ = frames(capture_file(metadata=published_metadata | {"realsense_config": config}).path)
    assert "intrinsics" not in stream.static


def test_negative_counts_are_refused_with_their_place(capture_file, frames):
    def spoil(n, record):
        if n == 2:
            next(v for k, v in record.items() if k not in ("iter", "realsense_data"))[1, 2, 77] = -5

    with pytest.raises(Refusal, match="record 3, zone 5, bin 77 counts -5"):
        frames(capture_file(edit=spoil).path)


def test_a_file_with_no_capture_is_refused(capture_file):
    file = capture_file(iterations=range(0))
    with pytest.raises(Refusal, match=r"no capture with a histogram .* ends after its metadata"):
        pickle_stream.stream(file.path)
