"""Logs of SparkFun's histogram example, printed as its sketch prints them."""

import contextlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from recordings import files
from recordings.importers import sparkfun_log
from recordings.refusal import Refusal


def printed(counts):
    """The sketch's own loop: 5 converters of 256 bins, two channels in each."""
    text = ""
    for number, frame in enumerate(counts, start=1):
        text += f"Histogram Number: {number}\n"
        channel = 0
        for converter in frame.reshape(5, 256):
            text += f"\n#HLONG{channel}"
            channel += 1
            for at, count in enumerate(converter):
                text += str(count)
                if at + 1 == 128:
                    text += f"\n#HLONG{channel}"
                    channel += 1
                elif (at + 1) % 128 != 0:
                    text += ","
        text += "\n"
    return text.encode()


@pytest.fixture
def counts():
    return np.random.default_rng(0).integers(0, 1 << 20, (4, 10, 128))


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_a_log_is_a_recording(tmp_path, counts, end):
    path = tmp_path / "log.txt"
    path.write_bytes(printed(counts).replace(b"\n", end))
    recording = files.load(path)
    assert np.array_equal(recording.counts, counts[:, 1:])
    assert recording.meta["reference_counts"] == counts[:, 0].tolist()
    assert recording.timestamp_s.tolist() == [1, 2, 3, 4]
    assert tuple(recording.zone_grid) == (3, 3)


# Lines of a frame: its header, an empty one and ten channels.
FRAME = 12


@pytest.mark.parametrize(
    ("damage", "kept"),
    [
        (lambda lines: lines.pop(FRAME + 5), [0, 2, 3]),
        (lambda lines: lines.insert(FRAME + 5, lines[FRAME + 5]), [0, 2, 3]),
        (lambda lines: lines.__setitem__(FRAME + 5, lines[FRAME + 5] + b",1"), [0, 2, 3]),
        (lambda lines: lines.__setitem__(FRAME + 5, lines[FRAME + 5].replace(b",", b",x", 1)), [0, 2, 3]),
        (lambda lines: lines.__setitem__(FRAME + 5, lines[FRAME + 5].replace(b",", b",99999999", 1)), [0, 2, 3]),
        (lambda lines: lines.__delitem__(slice(FRAME + 5, 2 * FRAME + 5)), [0, 3]),
    ],
)
def test_a_damaged_frame_is_left_out_and_counted(tmp_path, counts, damage, kept):
    lines = printed(counts).split(b"\n")
    damage(lines)
    path = tmp_path / "log.txt"
    path.write_bytes(b"\n".join(lines))
    recording = files.load(path)
    assert np.array_equal(recording.counts, counts[kept, 1:])
    assert sum(recording.meta["lost"].values()) == 1


def test_a_log_without_a_whole_frame_is_refused(tmp_path):
    path = tmp_path / "log.txt"
    path.write_bytes(b"Histogram Number: 1\n#HLONG01,2\n")
    with pytest.raises(Refusal, match="no whole frame, a line is no channel"):
        files.load(path)


@pytest.mark.parametrize("content", [b"", b"Histogram Number: 1\n", b"#HLONGER\n", b"\xff" * 99])
def test_other_files_are_left_to_others(tmp_path, content):
    path = tmp_path / "log.txt"
    path.write_bytes(content)
    assert not sparkfun_log.reads(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(junk=st.lists(st.binary(max_size=20) | st.sampled_from([b"Histogram Number: 1", b"#HLONG11,2"]), max_size=9))
def test_any_lines_are_read_or_refused(tmp_path, junk):
    path = tmp_path / "log.txt"
    path.write_bytes(b"#HLONG01\n" + b"\n".join(junk))
    with contextlib.suppress(Refusal):
        files.load(path)
