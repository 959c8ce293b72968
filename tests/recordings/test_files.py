import os
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import recordings.importers
from recordings.files import holds_maps, load, maps_of, save, stream
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.stream import Stream

IMPORTER = """
from recordings.maps import ResponseMaps
from recordings.stream import Stream
import numpy as np

def reads(path):
    return path.suffix == ".counts"

def stream(path):
    static = dict(zone_grid=[1, 1], bin_width_s=1e-10, time_zero_s=0.0)
    bins = np.array([[int(n) for n in path.read_text().split()]], "u4")
    return Stream(static, iter([dict(counts=bins, timestamp_s=0.0)]), 1)

def maps(path):
    return ResponseMaps(np.ones((1, 1, 1)), [0.0], [0.0], np.array(["a"]))
"""


@pytest.fixture
def importer(tmp_path, monkeypatch):
    folder = tmp_path / "more"
    folder.mkdir()
    (folder / "counts_text.py").write_text(IMPORTER)
    monkeypatch.setattr(recordings.importers, "__path__", [*recordings.importers.__path__, str(folder)])
    yield
    sys.modules.pop("recordings.importers.counts_text", None)


@pytest.mark.usefixtures("importer")
def test_a_new_reader_is_one_new_file(tmp_path):
    (tmp_path / "a.counts").write_text("1 2 3")
    assert load(tmp_path / "a.counts").counts.tolist() == [[[1, 2, 3]]]
    assert len(list(stream(tmp_path / "a.counts").frames)) == 1
    assert maps_of(tmp_path / "a.counts").zone_grid == (1, 1)


@pytest.mark.parametrize("suffix", [".rrd", ".npz"])
def test_saved_loaded_and_streamed(tmp_path, make, same, suffix):
    recording = make()
    path = tmp_path / f"a{suffix}"
    save(recording, path)
    same(recording, load(path))
    passing = stream(path)
    assert passing.count == 5
    same(recording, passing.collect())
    assert maps_of(path) is None
    assert not holds_maps(path)


def test_a_copy_onto_itself_loses_nothing(tmp_path, make, same):
    recording = make()
    for path in (tmp_path / "a.rrd", tmp_path / "a.npz"):
        save(recording, path)
        save(stream(path), path)
        same(recording, load(path))


@pytest.mark.parametrize("name", ["a.rrd", "a.npz"])
def test_a_stream_that_breaks_leaves_nothing(tmp_path, make, name):
    (tmp_path / name).write_text("what was there before")
    passing = Stream.of(make())
    frames = ({**f, "timestamp_s": 0.0} if i > 2 else f for i, f in enumerate(passing.frames))
    with pytest.raises(Refusal, match=r"timestamp_s\[3\]"):
        save(Stream(passing.static, frames), tmp_path / name)
    assert os.listdir(tmp_path) == [name]
    assert (tmp_path / name).read_text() == "what was there before"


@pytest.mark.parametrize("name", ["a.rrd", "a.npz"])
def test_no_frames_leave_nothing(tmp_path, make, name):
    with pytest.raises(Refusal, match="no frame"):
        save(Stream(Stream.of(make()).static, iter([])), tmp_path / name)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["a.mp4", "a", "a.rrd.gz"])
def test_other_names_are_refused(tmp_path, make, name):
    with pytest.raises(Refusal, match=r"ends in \.rrd or \.npz"):
        save(make(), tmp_path / name)


def test_a_file_must_be_what_its_name_says(tmp_path, make):
    save(make(), tmp_path / "a.npz")
    (tmp_path / "a.npz").rename(tmp_path / "a.rrd")
    with pytest.raises(Refusal, match=r"holds a file of kind \.npz, expected \.rrd by its name"):
        load(tmp_path / "a.rrd")


def test_a_form_of_ours_is_known_by_its_bytes(tmp_path, make, same):
    recording = make()
    for suffix in (".rrd", ".npz"):
        save(recording, tmp_path / f"a{suffix}")
        (tmp_path / f"a{suffix}").rename(tmp_path / "scan.of-today")
        same(recording, load(tmp_path / "scan.of-today"))


def test_an_interrupted_recording_names_the_way_out(tmp_path):
    (tmp_path / "a.rrd.partial").write_bytes(b"RRF2")
    for name in ("a.rrd", "a.rrd.partial"):
        with pytest.raises(Refusal, match=r"interrupted; `difflidar repair .*a\.rrd\.partial"):
            load(tmp_path / name)


def test_a_missing_file_is_missing(tmp_path):
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "a.rrd")


@settings(max_examples=60, deadline=None)
@given(content=st.binary(max_size=300), name=st.sampled_from(["a.rrd", "a.npz", "a.json", "a.pkl", "a"]))
def test_any_bytes_under_any_name_are_refused(tmp_path_factory, content, name):
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(content)
    for read in (load, lambda path: stream(path).collect()):
        with pytest.raises(Refusal):
            read(path)


def test_the_conformance_recording_round_trips(shared_data, tmp_path, same):
    with np.load(shared_data / "conformance" / "recording.npz") as arrays:
        first = Recording(**{n: str(arrays[n]) if n == "meta_json" else arrays[n] for n in arrays})
    save(stream(shared_data / "conformance" / "recording.npz"), tmp_path / "a.rrd")
    save(stream(tmp_path / "a.rrd"), tmp_path / "b.npz")
    same(first, load(tmp_path / "b.npz"))
