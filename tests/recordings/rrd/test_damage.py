"""Whatever happens to an .rrd: it is read to the bit, or refused in a sentence; repaired to what it was, or refused."""

import contextlib
import struct

import numpy as np
import pytest
import rerun as rr
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.files import load, save
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.rrd.container import HEADER_BYTES
from recordings.rrd.repair import repair
from recordings.rrd.writer import RrdWriter
from recordings.stream import Stream

FRAMES = 12


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("damage")


@pytest.fixture(scope="module")
def recording(make):
    return make(frames=FRAMES, grid=(1, 2), bins=4, size=(2, 2))


@pytest.fixture(scope="module")
def whole(folder, recording):
    """The bytes of a recording written in blocks of three frames, as a live one is."""
    passing = Stream.of(recording)
    with RrdWriter(folder / "whole.rrd", passing.static) as writer:
        for i, frame in enumerate(passing.frames):
            writer.append(frame)
            if i % 3 == 2:
                writer.flush()
    return (folder / "whole.rrd").read_bytes()


def messages(data):
    """Start and end of every message, by the documented layout."""
    found, at = [], HEADER_BYTES
    while at + 16 <= len(data):
        kind, length = struct.unpack_from("<QQ", data, at)
        found.append((at, at + 16 + length))
        at += 16 + length
        if kind == 0:
            break
    return found


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_cut_file_is_repaired_to_a_prefix_or_refused(folder, recording, whole, same, data):
    cut = data.draw(st.integers(0, len(whole) - 1))
    (folder / "cut.rrd").write_bytes(whole[:cut])
    with pytest.raises(Refusal):
        load(folder / "cut.rrd")
    with contextlib.suppress(Refusal):
        found = repair(folder / "cut.rrd", folder / "saved.rrd")
        same(recording, load(folder / "saved.rrd"), frames=found.frames)


def test_every_block_whose_end_is_there_is_saved(folder, recording, whole, same):
    kept = set()
    for _, end in messages(whole):
        (folder / "cut.rrd").write_bytes(whole[:end])
        with contextlib.suppress(Refusal):
            kept.add(repair(folder / "cut.rrd", folder / "saved.rrd").frames)
    assert kept == {3, 6, 9, 12}


def test_a_whole_file_is_copied_without_loss(folder, recording, whole, same):
    found = repair(folder / "whole.rrd", folder / "saved.rrd")
    assert (found.frames, found.incomplete, found.fields, found.damaged_messages, found.cut_bytes) == (12, (), (), 0, 0)
    same(recording, load(folder / "saved.rrd"))


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_damage_is_refused_or_changes_nothing(folder, recording, whole, same, data):
    raw = bytearray(whole)
    for place in data.draw(st.lists(st.integers(0, len(raw) - 1), min_size=1, max_size=3)):
        raw[place] = data.draw(st.integers(0, 255))
    (folder / "bad.rrd").write_bytes(raw)
    with contextlib.suppress(Refusal):
        same(recording, load(folder / "bad.rrd"))


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_repair_of_damage_keeps_only_true_frames(folder, recording, whole, data):
    raw = bytearray(whole)
    start, end = data.draw(st.sampled_from(messages(whole)[:-1]))
    for _ in range(data.draw(st.integers(1, 3))):
        raw[data.draw(st.integers(start, end - 1))] = data.draw(st.integers(0, 255))
    (folder / "bad.rrd").write_bytes(raw)
    with contextlib.suppress(Refusal):
        repair(folder / "bad.rrd", folder / "saved.rrd")
        saved = load(folder / "saved.rrd")
        times = list(recording.timestamp_s)
        for i, time in enumerate(saved.timestamp_s):
            assert np.array_equal(saved.counts[i], recording.counts[times.index(time)])
            assert np.array_equal(saved.rgb[i], recording.rgb[times.index(time)])


def test_a_damaged_block_loses_its_frames_only(folder, recording, whole):
    places = [(a, b) for a, b in messages(whole) if b"lidar/zone/0_1" in whole[a:b]]
    start, end = places[1]
    (folder / "bad.rrd").write_bytes(whole[: start + 200] + bytes(end - start - 200) + whole[end:])
    found = repair(folder / "bad.rrd", folder / "saved.rrd")
    assert (found.frames, found.damaged_messages) == (9, 1)
    assert found.incomplete == (3, 4, 5)
    assert np.array_equal(load(folder / "saved.rrd").counts, np.delete(recording.counts, [3, 4, 5], axis=0))


def test_an_optional_field_that_is_damaged_is_left_out_and_said(folder, fields):
    there = fields(frames=2, there=("irf",))
    save(Recording(**there), folder / "irf.rrd")
    raw = (folder / "irf.rrd").read_bytes()
    (folder / "bad.rrd").write_bytes(raw.replace(there["irf"][3:5].tobytes(), there["irf"][4:6].tobytes(), 1))
    with pytest.raises(Refusal, match="irf does not match its checksum"):
        load(folder / "bad.rrd")
    assert set(repair(folder / "bad.rrd", folder / "saved.rrd").fields) == {"irf", "irf_time_s"}
    assert load(folder / "saved.rrd").irf is None


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=400), st.booleans())
def test_any_bytes_are_refused(folder, noise, named):
    (folder / "noise.rrd").write_bytes((b"RRF2\0\x29\0\0\1\2\0\0" if named else b"") + noise)
    with pytest.raises(Refusal):
        load(folder / "noise.rrd")
    with pytest.raises(Refusal):
        repair(folder / "noise.rrd", folder / "saved.rrd")


def test_a_cut_file_names_the_way_out(folder, whole):
    (folder / "cut.rrd").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(Refusal, match=r"cut\.rrd: is cut off after \d+ bytes.*difflidar repair"):
        load(folder / "cut.rrd")


def test_a_recording_of_another_program_is_refused(folder):
    other = rr.RecordingStream("another", make_default=False, make_thread_default=False)
    other.save(folder / "other.rrd")
    other.log("points", rr.Points3D([[1, 2, 3]]))
    other.disconnect()
    with pytest.raises(Refusal, match="not a recording of difflidar"):
        load(folder / "other.rrd")


def test_a_later_version_is_refused(folder, make, monkeypatch):
    monkeypatch.setattr("recordings.rrd.layout.VERSION", 2)
    save(make(frames=1), folder / "later.rrd")
    monkeypatch.setattr("recordings.rrd.layout.VERSION", 1)
    with pytest.raises(Refusal, match="is of version 2"):
        load(folder / "later.rrd")


def test_out_must_be_another_rrd(folder, whole):
    (folder / "own.rrd").write_bytes(whole)
    with pytest.raises(Refusal, match="is the file to repair"):
        repair(folder / "own.rrd", folder / "own.rrd")
    with pytest.raises(Refusal, match=r"ends in \.rrd"):
        repair(folder / "own.rrd", folder / "own.npz")
