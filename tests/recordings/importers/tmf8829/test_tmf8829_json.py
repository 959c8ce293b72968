"""Logs of the TMF8829 as its makers' tools write them, small."""

import contextlib
import gzip
import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from recordings import files
from recordings.importers import tmf8829_json
from recordings.importers.tmf8829.bins import Bins
from recordings.refusal import Refusal

SPEED = 299_792_458
WIDTH_S, ZERO_S = 0.5e-9, 2.2e-9


def metres_seen(frame, row, column):
    return 0.4 + 0.35 * row + 0.25 * column + 0.1 * frame


def frame_of(number, rows=8, columns=8, bins=256, histograms="mp_histo", results=True):
    """A pulse in each zone, and the distance that the chip found, in quarters of a millimetre."""
    at = (np.arange(bins) + 0.5) * WIDTH_S
    made = {"info": {"frame_number": 100 + 2 * number, "temperature": 30}, histograms: []}
    made["ref_histo"] = [{"bin": [number] * bins}]
    found = []
    for row in range(rows):
        seen = [metres_seen(number, row, column) for column in range(columns)]
        pulses = [np.exp(-0.5 * ((at - ZERO_S - 2 * d / SPEED) / WIDTH_S) ** 2) for d in seen]
        made[histograms].append([{"bin": np.round(10_000 * pulse).astype(int).tolist()} for pulse in pulses])
        found.append([{"noise": 1, "peaks": [{"distance": round(d * 4000), "snr": 9}]} for d in seen])
    return made | ({"results": found} if results else {})


def written(path, frames, **besides):
    content = json.dumps({"configuration": {"period": 33}, "device": {"serial": 7}, "Result_Set": frames, **besides})
    path.write_bytes(gzip.compress(content.encode()) if path.suffix == ".gz" else content.encode())
    return path


@pytest.mark.parametrize("name", ["log.json", "log.json.gz"])
def test_a_log_is_a_recording(tmp_path, name):
    frames = [frame_of(n) for n in range(3)]
    recording = files.load(written(tmp_path / name, frames))
    assert recording.counts.shape == (3, 64, 256)
    assert recording.counts[1, 8 * 2 + 5].tolist() == frames[1]["mp_histo"][2][5]["bin"]
    assert tuple(recording.zone_grid) == (8, 8)
    assert recording.timestamp_s.tolist() == [0, 2, 4]
    assert recording.meta["log"]["device"] == {"serial": 7}
    assert recording.meta["frame_info"][0]["temperature"] == 30


def test_bin_width_and_zero_are_those_of_the_distances(tmp_path):
    recording = files.load(written(tmp_path / "log.json", [frame_of(n) for n in range(3)]))
    assert recording.bin_width_s == pytest.approx(WIDTH_S, rel=0.01)
    assert recording.time_zero_s == pytest.approx(ZERO_S, abs=0.3 * WIDTH_S)
    assert " distances the chip found" in recording.meta["assumed"][0]


def test_zones_in_which_the_chip_chose_another_peak_do_not_matter(tmp_path):
    frames = [frame_of(n) for n in range(3)]
    for frame in frames:
        for row in frame["results"]:
            row[3]["peaks"][0]["distance"] = 20_000
            row[4]["peaks"] = []
    recording = files.load(written(tmp_path / "log.json", frames))
    assert recording.bin_width_s == pytest.approx(WIDTH_S, rel=0.05)


@pytest.mark.parametrize("name", ["mp_hist", "mp_histo_HA", "mp_hist_HA"])
def test_histograms_by_their_other_names(tmp_path, name):
    frames = [frame_of(n, 4, 6, 64, name) for n in range(2)]
    recording = files.load(written(tmp_path / "log.json", frames))
    assert recording.counts.shape == (2, 24, 64)
    assert ("high accuracy" in recording.meta["mode"]) == name.endswith("HA")


def test_of_two_ranges_the_longer_is_taken(tmp_path):
    frames = [frame_of(n) | {"mp_histo_HA": frame_of(9)["mp_histo"]} for n in range(2)]
    recording = files.load(written(tmp_path / "log.json", frames))
    assert recording.counts[0, 0].tolist() == frames[0]["mp_histo"][0][0]["bin"]


def test_frames_without_histograms_are_left_out_and_named(tmp_path):
    frames = [frame_of(0), {"info": {}}, frame_of(2)]
    recording = files.load(written(tmp_path / "log.json", frames))
    assert len(recording.counts) == 2
    assert recording.meta["frames_without_histograms"] == [1]


def test_without_distances_the_width_must_be_given(tmp_path):
    path = written(tmp_path / "log.json", [frame_of(0, results=False)])
    with pytest.raises(Refusal, match="width of a bin is not published"):
        files.load(path)
    recording = tmf8829_json.stream(path, Bins(WIDTH_S, ZERO_S, 0)).collect()
    assert recording.bin_width_s == WIDTH_S


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"mp_histo": [[{"bin": [1, 2]}]]}, r"frame 1: mp_histo has shape \(1, 1, 2\)"),
        ({"mp_histo": [[{"bin": [1, -2] * 128}] * 8] * 8}, r"frame 1: mp_histo\[0, 0, 1\] is -2"),
        ({"mp_histo": [[{"bin": [1.5] * 256}] * 8] * 8}, r"frame 1: mp_histo\[0, 0, 0\] is 1.5"),
        ({"mp_histo": 3}, "frame 1: mp_histo is no array"),
        ({"mp_histo": [[{}]]}, "frame 1: mp_histo is no array"),
    ],
)
def test_a_wrong_frame_is_refused_with_its_place(tmp_path, change, said):
    with pytest.raises(Refusal, match=said):
        files.load(written(tmp_path / "log.json", [frame_of(0), frame_of(1) | change]))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b'{"Result_Set": [', "line 1 column"),
        (b'{"Result_Set": 3}', "no list of frames"),
        (b'{"Result_Set": [3]}', "no list of frames"),
        (b'{"Result_Set": []}', "no frame holds histograms"),
        (gzip.compress(b'{"Result_Set": []}' + b" " * 9000, mtime=0)[:-9], "damaged log"),
    ],
)
def test_a_wrong_log_is_refused(tmp_path, content, said):
    path = tmp_path / "log.json"
    path.write_bytes(content)
    with pytest.raises(Refusal, match=said):
        tmf8829_json.stream(path)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["bin", "peaks", "x"]), inner),
    max_leaves=10,
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(field=st.sampled_from(["mp_histo", "results", "info", "ref_histo"]), value=JSON)
def test_any_json_in_any_field_is_read_or_refused(tmp_path, field, value):
    path = written(tmp_path / "log.json", [frame_of(0, 3, 3, 64), frame_of(1, 3, 3, 64) | {field: value}])
    with contextlib.suppress(Refusal):
        files.load(path)
