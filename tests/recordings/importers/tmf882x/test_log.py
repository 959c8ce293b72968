"""A log as text becomes a recording; what it does not say is said to be assumed, what was lost is counted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings import files
from recordings.importers import tmf882x_log
from recordings.importers.tmf882x.times import times_s
from recordings.refusal import Refusal

GRIDS = {"3x3": ((3, 3), 1), "4x4": ((4, 4), 2), "3x6": ((6, 3), 2), "8x8": ((8, 8), 8)}
CONF = {
    "3x3": b"#Conf,Period=16ms,KIter=10000 SPAD=6 Pers=0",
    "4x4": b"#Conf,Period=8ms,KIter=2500 SPAD=7 Pers=0",
    "3x6": b"#Conf,Period=16ms,KIter=4000 SPAD=10 Pers=0",
    "8x8": b"TMF8828 state=stopped\n#Conf,Period=132ms,KIter=10 SPAD=15 Pers=0",
}


@pytest.fixture
def log(firmware, tmp_path):
    """Writes a log of measurements, returns its path and their counts."""

    def write(mode, frames=4, before=(), between=(), conf=True, end=b"\n", tick=lambda n: 1 + 500_000 * n):
        (rows, columns), bursts = GRIDS[mode]
        rng = np.random.default_rng(3)
        counts = rng.poisson(900, (frames, rows * columns, 128))
        lines = [*([CONF[mode]] if conf else []), *before]
        for n, one in enumerate(counts):
            lines += firmware.measurement(mode, one, rng.poisson(900, (bursts, 128)), n, tick=tick(n), celsius=n - 2)
            lines += between if n == 1 else ()
        path = tmp_path / "log.txt"
        path.write_bytes(end.join(lines) + end)
        return path, counts

    return write


@pytest.mark.parametrize("mode", GRIDS)
@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_a_log_is_a_recording(log, mode, end):
    path, counts = log(mode, end=end)
    recording = files.load(path)
    assert np.array_equal(recording.counts, counts)
    assert tuple(recording.zone_grid) == GRIDS[mode][0]
    assert recording.bin_width_s == pytest.approx(0.38e-9)
    assert recording.timestamp_s == pytest.approx([0, 0.1, 0.2, 0.3])
    assert recording.meta["temperature_c"] == [-2, -1, 0, 1]
    assert recording.meta["lost"]["dropped"] == 0
    assert recording.meta["mode"] == f"{mode}, long range"
    shots = {"3x3": 10_000, "4x4": 2500, "3x6": 4000, "8x8": 10}[mode] * 1024
    assert recording.laser_cycles == shots


@pytest.mark.parametrize("mode", ["3x3", "4x4", "3x6"])
def test_the_mode_is_told_from_the_lines_where_nothing_says_it(log, mode):
    path, counts = log(mode, conf=False)
    recording = files.load(path)
    assert np.array_equal(recording.counts, counts)
    assert recording.laser_cycles is None


def test_short_range_where_the_firmware_says_so(log):
    path, _ = log("3x3", conf=False, before=[b"Active range: 6E"])
    recording = files.load(path)
    assert recording.bin_width_s == pytest.approx(92.5e-12)
    # Channel 6, by the table of the factory calibration.
    assert recording.time_zero_s[5] == pytest.approx(14.782 * 92.5e-12)
    assert not any("long range" in one for one in recording.meta["assumed"])


def test_each_zone_has_the_time_zero_of_its_channel(log, firmware):
    path, _ = log("8x8", frames=1)
    zeros = files.load(path).time_zero_s
    assert zeros[firmware.place("8x8", 2, 1, 4)] == pytest.approx(15.269 * 0.38e-9)


def test_what_is_lost_is_counted_and_the_rest_kept(log):
    path, counts = log("3x3", frames=6)
    lines = path.read_bytes().split(b"\n")
    del lines[1 + 31 * 2 + 7]
    path.write_bytes(b"\n".join(lines))
    recording = files.load(path)
    assert np.array_equal(recording.counts, counts[[0, 1, 3, 4, 5]])
    assert recording.meta["lost"]["dropped"] == recording.meta["lost"]["missed"] == 1
    assert recording.meta["number"] == [0, 1, 3, 4, 5]
    assert recording.timestamp_s == pytest.approx([0, 0.1, 0.3, 0.4, 0.5])


def test_a_setting_that_changes_amid_measurements_is_refused_with_its_line(log):
    path, _ = log("3x3", between=[b"#Conf,Period=8ms,KIter=2500 SPAD=7 Pers=0"])
    with pytest.raises(Refusal, match=r"line 64: the setting changes to .*spad map 7.*split the log there"):
        files.load(path)


def test_the_settings_before_the_first_measurement_may_change(log):
    path, _ = log("3x3", conf=False, before=[CONF["4x4"], CONF["3x3"]])
    assert files.load(path).meta["spad_map"] == 6


def test_a_log_without_a_whole_measurement_is_refused(log):
    path, _ = log("3x3", frames=1)
    path.write_bytes(b"\n".join(path.read_bytes().split(b"\n")[:20]))
    with pytest.raises(Refusal, match=r"no whole measurement .*line 20: no result line"):
        files.load(path)


def test_results_without_histograms_are_refused(tmp_path, firmware):
    path = tmp_path / "log.txt"
    path.write_bytes(b"\n".join(firmware.result_line(n) for n in range(4)))
    with pytest.raises(Refusal, match=r"no histograms \(4\)"):
        files.load(path)


@pytest.mark.parametrize("content", [b"", b"hello\n", b"\x00" * 100, b"a" * 100_000, b"#Rawhide\n"])
def test_other_files_are_left_to_others(tmp_path, content):
    path = tmp_path / "log.txt"
    path.write_bytes(content)
    assert not tmf882x_log.reads(path)


@given(junk=st.lists(st.binary(max_size=40) | st.sampled_from([b"#Raw,65,0,1", b"#Obj", CONF["3x3"]]), max_size=20))
def test_any_lines_are_read_or_refused(tmp_path_factory, junk):
    path = tmp_path_factory.mktemp("junk") / "log.txt"
    path.write_bytes(b"#Raw,1\n" + b"\n".join(junk))
    with pytest.raises(Refusal, match=r"log\.txt"):
        files.load(path)


def test_a_clock_that_is_sometimes_not_valid_is_filled_in():
    nan = float("nan")
    times, assumed = times_s(np.array([nan, 10.0, nan, 14.0, nan]), np.array([1, 2, 4, 6, 8]))
    assert times == pytest.approx([0, 1, 3, 5, 7])
    assert "(3)" in assumed


@pytest.mark.parametrize(
    "ticks", [[float("nan")] * 3, [1.0, 3.0, 2.0], [1.0, 1.0, 2.0], [float("nan"), 1.0, float("nan")]]
)
def test_a_clock_that_does_not_rise_gives_way_to_numbers(ticks):
    times, assumed = times_s(np.array(ticks), np.array([5, 6, 9]))
    assert times.tolist() == [0, 1, 4]
    assert "one measurement a second" in assumed
