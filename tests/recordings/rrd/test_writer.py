"""What was handed to the writer survives the end of its process; what could not be written is said."""

import contextlib
import itertools
import os
import resource
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

from recordings.files import load
from recordings.refusal import Refusal
from recordings.rrd.repair import repair
from recordings.rrd.sink import RrdSink
from recordings.rrd.writer import RrdWriter
from recordings.stream import Stream

LIVE = """
import sys
import numpy as np
from recordings.rrd.writer import RrdWriter

path, waits = sys.argv[1], sys.argv[2] == "waits"
writer = RrdWriter(path, dict(zone_grid=[1, 2], bin_width_s=1e-10, time_zero_s=0.0))
for i in range(10**6):
    counts = np.full((2, 16), i, np.uint32)
    writer.append(dict(counts=counts, timestamp_s=i / 30, rgb=np.full((8, 8, 3), i % 256, np.uint8)))
    if waits:
        writer._timer.join()
    elif i % 7 == 0:
        writer.flush()
    if waits or i % 7 == 0:
        print(i, flush=True)
        sys.stdin.readline()
"""


@pytest.mark.parametrize("how", ["flushes", "waits"])
def test_frames_survive_a_kill(tmp_path, how):
    """Frames flushed, or left waiting for the writer's own timer, are read again after SIGKILL."""
    path = tmp_path / "live.rrd"
    live = subprocess.Popen(
        [sys.executable, "-c", LIVE, path, how], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with live:
        for _ in range(3):
            last = int(live.stdout.readline())
            live.stdin.write("\n")
            live.stdin.flush()
        live.send_signal(signal.SIGKILL)
    assert not path.exists()
    found = repair(tmp_path / "live.rrd.partial", tmp_path / "saved.rrd")
    saved = load(tmp_path / "saved.rrd")
    assert found.frames == len(saved.counts) > last
    assert np.array_equal(saved.counts[:, 0, 0], np.arange(found.frames))
    assert np.array_equal(saved.timestamp_s, np.arange(found.frames) / 30)
    assert [image[0, 0, 0] for image in saved.rgb] == [i % 256 for i in range(found.frames)]


def test_the_name_is_taken_only_when_all_is_written(tmp_path, make, same):
    recording = make()
    passing = Stream.of(recording)
    (tmp_path / "a.rrd").write_text("what was there before")
    with RrdWriter(tmp_path / "a.rrd", passing.static) as writer:
        for frame in passing.frames:
            writer.append(frame)
        writer.flush()
        assert (tmp_path / "a.rrd").read_text() == "what was there before"
    assert os.listdir(tmp_path) == ["a.rrd"]
    same(recording, load(tmp_path / "a.rrd"))


def test_an_error_leaves_the_frames_beside(tmp_path, make, same):
    recording = make()
    passing = Stream.of(recording)

    def interrupted(frames):
        with RrdWriter(tmp_path / "a.rrd", passing.static) as writer:
            for frame in frames:
                writer.append(frame)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted(itertools.islice(passing.frames, 3))
    assert os.listdir(tmp_path) == ["a.rrd.partial"]
    with pytest.raises(Refusal, match="is there from a recording that was interrupted"):
        RrdWriter(tmp_path / "a.rrd", passing.static)
    repair(tmp_path / "a.rrd.partial", tmp_path / "a.rrd")
    same(recording, load(tmp_path / "a.rrd"), frames=3)


def test_a_bad_frame_is_refused_and_those_before_are_kept(tmp_path, make):
    passing = Stream.of(make())

    def twice(frame):
        with RrdWriter(tmp_path / "a.rrd", passing.static) as writer:
            writer.append(frame)
            writer.append(frame)

    with pytest.raises(Refusal, match="timestamp_s"):
        twice(next(passing.frames))
    assert repair(tmp_path / "a.rrd.partial", tmp_path / "b.rrd").frames == 1


def test_a_recording_without_frames_is_refused_and_leaves_nothing(tmp_path, make):
    with pytest.raises(Refusal, match="no frame was recorded"), RrdWriter(tmp_path / "a.rrd", Stream.of(make()).static):
        pass
    assert os.listdir(tmp_path) == []


def test_no_folder_is_refused(tmp_path, make):
    with pytest.raises(Refusal, match="does not exist"):
        RrdWriter(tmp_path / "no" / "a.rrd", Stream.of(make()).static)


def test_appending_from_threads_keeps_every_frame(tmp_path, make):
    passing = Stream.of(make(frames=1, there=()))
    frame = next(passing.frames)
    turn = threading.Lock()
    with RrdWriter(tmp_path / "a.rrd", passing.static) as writer:

        def work():
            for _ in range(50):
                with turn:
                    frame["timestamp_s"] = frame["timestamp_s"] + 1
                    writer.append(dict(frame))
                writer.flush()

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(load(tmp_path / "a.rrd").counts) == 200


@contextlib.contextmanager
def small_disk():
    """A disk on which no file can be larger than 100 kB."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_is_an_error_at_once_and_the_frames_before_are_saved(tmp_path):
    counts = np.random.default_rng(0).integers(0, 2**32, (100, 1, 4096), "u4")
    written = []

    def fill():
        static = {"zone_grid": [1, 1], "bin_width_s": 1e-10, "time_zero_s": 0.0}
        with small_disk(), RrdWriter(tmp_path / "a.rrd", static) as writer:
            for i in range(100):
                writer.append({"counts": counts[i], "timestamp_s": float(i)})
                writer.flush()
                written.append(i)

    with pytest.raises(OSError, match="too large"):
        fill()
    assert os.listdir(tmp_path) == ["a.rrd.partial"]
    assert repair(tmp_path / "a.rrd.partial", tmp_path / "b.rrd").frames == len(written) > 2
    assert np.array_equal(load(tmp_path / "b.rrd").counts, counts[: len(written)])


def test_what_is_flushed_is_in_the_file(tmp_path):
    import rerun as rr

    sink = RrdSink(tmp_path / "a.rrd", "test")
    before = 0
    for i in range(20):
        sink.recording.log("text", rr.TextLog("x" * i))
        sink.flush()
        size = (tmp_path / "a.rrd").stat().st_size
        assert size > before
        before = size
    sink.close()
    assert (tmp_path / "a.rrd").stat().st_size > before
