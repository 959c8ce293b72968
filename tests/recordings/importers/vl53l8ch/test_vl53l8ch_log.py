"""Logs of the VL53L8CH as the published captures' firmware prints them."""

import contextlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from recordings import files
from recordings.importers import vl53l8ch_log
from recordings.refusal import Refusal


def written(path, bins, ambient, end="\n"):
    """(F, P, T) bins and (F, P) ambient light, thousandfold already."""
    lines = ["started"]
    for n, frame in enumerate(bins):
        lines.append("D")
        for zone, row in enumerate(frame):
            lines.append(" ".join(map(str, [zone, ambient[n][zone], 100 + zone, *row])))
    path.write_bytes((end.join(lines) + end).encode())
    return path


@pytest.fixture
def signal():
    rng = np.random.default_rng(0)
    ambient = rng.integers(500, 900, (3, 16))
    return rng.integers(-400, 5000, (3, 16, 18)), ambient


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_log_is_a_recording_with_the_ambient_light_in_it(tmp_path, signal, end):
    bins, ambient = signal
    recording = files.load(written(tmp_path / "log.txt", bins, ambient, end))
    assert np.array_equal(recording.counts, bins + ambient[:, :, None])
    assert recording.counts.dtype == np.uint32
    assert tuple(recording.zone_grid) == (4, 4)
    assert recording.bin_width_s == pytest.approx(250e-12)
    assert recording.meta["on_chip"]["distance_mm"][0] == [100 + zone for zone in range(16)]
    assert recording.meta["cells_below_zero"]["count"] == 0


def test_what_stays_below_zero_is_counted(tmp_path, signal):
    bins, ambient = signal
    bins[1, 2, 3] = -5000
    recording = files.load(written(tmp_path / "log.txt", bins, ambient))
    assert recording.counts[1, 2, 3] == 0
    assert recording.meta["cells_below_zero"]["count"] == 1


def test_without_the_ambient_light_a_negative_bin_is_refused_with_its_line(tmp_path, signal):
    bins, ambient = signal
    path = written(tmp_path / "log.txt", np.abs(bins), ambient)
    assert np.array_equal(vl53l8ch_log.stream(path, add_ambient=False).collect().counts, np.abs(bins))
    bins = np.abs(bins)
    bins[1, 2, 3] = -7
    path = written(path, bins, ambient)
    # A line before the first frame, 17 of that, then D and two zones.
    with pytest.raises(Refusal, match="line 22: bin 3 is -7"):
        vl53l8ch_log.stream(path, add_ambient=False)


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda lines: lines.pop(22), "an aggregate is missing"),
        (lambda lines: lines.insert(22, lines[22]), "an aggregate is missing"),
        (lambda lines: lines.insert(22, b"hello"), "no row of whole numbers"),
        (lambda lines: lines.__setitem__(22, lines[22][:-20]), "lines or bins are missing"),
        (lambda lines: lines.__setitem__(34, b""), "lines or bins are missing"),
        (lambda lines: lines.__setitem__(22, lines[22] + b".5"), "no row of whole numbers"),
    ],
)
def test_a_damaged_frame_is_left_out_and_counted(tmp_path, signal, damage, reason):
    bins, ambient = signal
    path = written(tmp_path / "log.txt", bins, ambient)
    lines = path.read_bytes().split(b"\n")
    damage(lines)
    path.write_bytes(b"\n".join(lines))
    recording = files.load(path)
    assert np.array_equal(recording.counts, (bins + ambient[:, :, None])[[0, 2]])
    assert reason in str(recording.meta["lost"])


def test_aggregates_that_make_no_square_are_one_row(tmp_path, signal):
    bins, ambient = signal
    assert tuple(files.load(written(tmp_path / "log.txt", bins[:, :6], ambient)).zone_grid) == (1, 6)


def test_a_log_without_a_whole_frame_is_refused(tmp_path):
    path = tmp_path / "log.txt"
    path.write_bytes(b"D\n0 1 2 3 4\nhello\n")
    with pytest.raises(Refusal, match="no whole frame, line 1: a line is no row"):
        files.load(path)


@pytest.mark.parametrize("content", [b"", b"D\n", b"D\nhello\n", b"0 1 2 3\n", b"\xff" * 50, b"D\n1 2 3 4\n"])
def test_other_files_are_left_to_others(tmp_path, content):
    path = tmp_path / "log.txt"
    path.write_bytes(content)
    assert not vl53l8ch_log.reads(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(junk=st.lists(st.binary(max_size=20) | st.sampled_from([b"D", b"0 1 2 3", b"0 99999999999 1 1"]), max_size=9))
def test_any_lines_are_read_or_refused(tmp_path, junk):
    path = tmp_path / "log.txt"
    path.write_bytes(b"D\n0 1 2 3\n" + b"\n".join(junk))
    with contextlib.suppress(Refusal):
        files.load(path)
