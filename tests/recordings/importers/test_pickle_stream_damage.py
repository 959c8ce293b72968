"""Capture files that are cut, damaged, long or strange."""

import contextlib
import tracemalloc

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from recordings.importers import pickle_stream
from recordings.refusal import Refusal

KEPT = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60, deadline=None)


@KEPT
@given(cut=st.floats(0, 1, exclude_max=True))
def test_whatever_is_whole_of_a_cut_file_is_kept(capture_file, frames, cut):
    file = capture_file(iterations=range(4))
    written = file.path.read_bytes()
    length = int(cut * len(written))
    file.path.write_bytes(written[:length])
    whole = sum(end <= length for end in file.starts[2:])
    if not whole:
        with pytest.raises(Refusal, match="no capture"):
            pickle_stream.stream(file.path)
        return
    stream, read, meta = frames(file.path)
    assert stream.count == len(read) == whole
    for n, frame in enumerate(read):
        file.assert_same_frame(frame, n)
    assert ("truncated" in meta) == (length not in file.starts)
    if "truncated" in meta:
        assert f"record {whole + 1} at byte {file.starts[whole + 1]}" in meta["truncated"]


@KEPT
@given(at=st.floats(0, 1, exclude_max=True), new=st.binary(min_size=1, max_size=12))
def test_damaged_bytes_are_refused_or_read_but_nothing_else(capture_file, at, new):
    file = capture_file(iterations=range(2))
    written = bytearray(file.path.read_bytes())
    # Past the metadata most bytes are pixels, so half of the damage goes into the first kilobyte.
    place = int(at * 2 * 1024) if at < 0.5 else int((at - 0.5) * 2 * len(written))
    written[place : place + len(new)] = new
    file.path.write_bytes(written)
    with contextlib.suppress(Refusal):
        for frame in pickle_stream.stream(file.path).frames:
            assert frame["counts"].ndim == 2


@given(content=st.binary(max_size=200))
def test_any_bytes_are_refused_or_read(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("bytes") / "any.pkl"
    path.write_bytes(b"\x80\x04" + content)
    assert pickle_stream.reads(path)
    with pytest.raises(Refusal):
        pickle_stream.stream(path)


def test_what_is_no_pickle_is_not_claimed(tmp_path):
    (tmp_path / "a.txt").write_text("hello")
    (tmp_path / "empty").touch()
    for path in (tmp_path, tmp_path / "absent", tmp_path / "a.txt", tmp_path / "empty"):
        assert not pickle_stream.reads(path)


def test_a_long_scan_is_read_in_little_memory(capture_file):
    grow = np.zeros((500, 600, 3), np.uint8)

    def enlarge(n, record):
        record["realsense_data"] = {"aligned_rgb_image": grow}

    file = capture_file(iterations=range(60), edit=enlarge)
    assert file.path.stat().st_size > 50e6
    file.records.clear()
    tracemalloc.start()
    try:
        read = sum(1 for _ in pickle_stream.stream(file.path).frames)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert read == 60
    assert peak < 8e6


NAMES = ["range_mode", "robot_grid_points", "y_steps", "realsense_intrinsics", "repeats_per_point", "x"]
NUMBERS = st.integers() | st.floats() | st.complex_numbers()


@KEPT
@given(
    metadata=st.dictionaries(
        st.sampled_from(NAMES) | st.integers() | st.tuples(st.integers()),
        st.recursive(
            st.none() | NUMBERS | st.text() | st.binary(),
            lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text() | st.integers(), inner, max_size=3),
            max_leaves=8,
        ),
        max_size=5,
    )
)
def test_any_metadata_are_kept_as_json(capture_file, frames, metadata):
    _, read, meta = frames(capture_file(iterations=range(1), metadata=metadata).path)
    assert len(read) == 1
    assert len(meta.get("publisher_metadata", {})) <= len(metadata)


def test_integers_too_long_for_text_are_kept(capture_file, frames):
    long = 1 << 20_000
    metadata = {"seed": long, long: 1, "range_mode": [long], "repeats_per_point": long, (long,): {long: 2}}
    _, read, meta = frames(capture_file(metadata=metadata).path)
    assert meta["publisher_metadata"]["seed"] == hex(long)
    assert len(read) == 13
