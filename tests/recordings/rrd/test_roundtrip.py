"""What is written as .rrd comes back to the bit, for this project's reader and for the rerun library's own."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from hypothesis import given, settings
from hypothesis import strategies as st
from rerun.chunk import RrdReader

from recordings.encoded import EncodedFrames
from recordings.files import load, save
from recordings.rrd.reader import load_rrd
from recordings.rrd.writer import RrdWriter
from recordings.stream import Stream

RERUN = Path(sys.executable).with_name("rerun")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("rrd")


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_npz_to_rrd_to_npz_loses_nothing(folder, recordings_of_any_kind, data):
    fields = data.draw(recordings_of_any_kind)
    np.savez(folder / "a.npz", **fields)
    save(load(folder / "a.npz"), folder / "b.rrd")
    save(load(folder / "b.rrd"), folder / "c.npz")
    with np.load(folder / "a.npz") as first, np.load(folder / "c.npz") as last:
        assert set(first) == set(last)
        for name in first:
            one, two = first[name], last[name]
            assert (one.dtype, one.shape, one.tobytes()) == (two.dtype, two.shape, two.tobytes()), name


def rows(path, entity, component):
    """Rows of a component by frame (None where static), read by the rerun library."""
    found = {}
    for chunk in RrdReader(path).stream():
        batch = chunk.to_record_batch()
        if chunk.entity_path == f"/{entity}" and component in batch.schema.names:
            frames = [None] if chunk.is_static else batch["frame"].to_pylist()
            found.update(zip(frames, batch[component].to_pylist(), strict=True))
    return found


def test_the_rerun_library_reads_the_same_numbers(tmp_path, make):
    recording = make(frames=70, grid=(2, 3))
    save(recording, tmp_path / "a.rrd")
    for p in range(6):
        seen = rows(tmp_path / "a.rrd", f"lidar/zone/{p // 3}_{p % 3}", "BarChart:values")
        assert [seen[f][0]["buffer"] for f in range(70)] == recording.counts[:, p].tolist()
    depth = rows(tmp_path / "a.rrd", "camera/depth", "DepthImage:buffer")
    assert bytes(depth[69][0]) == recording.depth_m[69].tobytes()
    pose = rows(tmp_path / "a.rrd", "recording", "Recording:camera_pose")
    assert np.array_equal(pose[33], recording.camera_pose[33].ravel())
    assert rows(tmp_path / "a.rrd", "recording", "Recording:irf")[None] == recording.irf.tolist()
    assert rows(tmp_path / "a.rrd", "recording/meta", "TextDocument:text")[None] == [recording.meta_json]


def test_the_viewer_has_camera_pose_and_time(tmp_path, make):
    recording = make()
    save(recording, tmp_path / "a.rrd")
    matrix = rows(tmp_path / "a.rrd", "camera", "Pinhole:image_from_camera")[None]
    assert np.allclose(np.reshape(matrix, (3, 3)).T - recording.intrinsics, [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
    moved = rows(tmp_path / "a.rrd", "camera", "Transform3D:translation")
    assert np.allclose([moved[f][0] for f in range(5)], recording.camera_pose[:, :3, 3])
    times = [
        chunk.to_record_batch()["time"].to_numpy(zero_copy_only=False)
        for chunk in RrdReader(tmp_path / "a.rrd").stream()
        if chunk.entity_path == "/recording" and not chunk.is_static
    ]
    assert np.allclose(times[0].astype(float) / 1e9, recording.timestamp_s, rtol=0, atol=1e-6)


def rerun(*arguments, **more):
    return subprocess.run([RERUN, "rrd", *map(str, arguments)], capture_output=True, check=False, **more)


def test_rerun_verifies_the_file_and_what_it_rewrites_is_read(tmp_path, make, same):
    recording = make(frames=150)
    save(recording, tmp_path / "a.rrd")
    assert rerun("verify", tmp_path / "a.rrd").returncode == 0
    (tmp_path / "b.rrd").write_bytes(rerun("optimize", tmp_path / "a.rrd").stdout)
    same(recording, load(tmp_path / "b.rrd"))


def test_camera_bytes_are_kept_as_they_are(tmp_path, make, jpeg):
    recording = make()
    blobs = [jpeg(image) for image in recording.rgb]
    object.__setattr__(recording, "rgb", EncodedFrames.of(blobs))
    save(recording, tmp_path / "a.rrd")
    kept = load(tmp_path / "a.rrd").rgb
    assert [kept.encoded(i) for i in range(5)] == blobs
    assert [bytes(row[0]) for row in rows(tmp_path / "a.rrd", "camera/rgb", "EncodedImage:blob").values()] == blobs


def test_what_a_viewer_shows_besides_is_ignored(tmp_path, make, same):
    recording = make(frames=3)
    passing = Stream.of(recording)
    blueprint = rrb.Blueprint(rrb.BarChartView(origin="lidar/zone/0_0"), collapse_panels=True)
    with RrdWriter(tmp_path / "a.rrd", passing.static, blueprint) as writer:
        writer.recording.log("lidar/zone/0_0", rr.BarChart([1, 2, 3]))
        writer.recording.log("camera/rgb/patch", rr.Points2D([[1, 2]]), static=True)
        for frame in passing.frames:
            writer.append(frame)
        writer.recording.set_time("frame", sequence=7)
        writer.recording.log("report", rr.TextLog("seen"))
    assert len(RrdReader(tmp_path / "a.rrd").blueprints()) == 1
    same(recording, load_rrd(tmp_path / "a.rrd"))


def test_chunks_may_come_in_any_order(tmp_path, make, same):
    recording = make(frames=130)
    save(recording, tmp_path / "a.rrd")
    chunks = RrdReader(tmp_path / "a.rrd").stream().to_chunks()
    order = np.random.default_rng(3).permutation(len(chunks))
    stream = rr.RecordingStream("difflidar", make_default=False, make_thread_default=False)
    stream.save(tmp_path / "b.rrd")
    stream.send_chunks([chunks[i] for i in order])
    stream.disconnect()
    same(recording, load(tmp_path / "b.rrd"))


def test_large_images_stay_in_the_file_until_they_are_asked_for(tmp_path, make, same, monkeypatch):
    monkeypatch.setattr("recordings.rrd.reader.EAGER_BYTES", 100)
    recording = make(frames=9)
    save(recording, tmp_path / "a.rrd")
    kept = load(tmp_path / "a.rrd")
    assert not isinstance(kept.depth_m, np.ndarray)
    assert np.array_equal(kept.depth_m[8], recording.depth_m[8], equal_nan=True)
    same(recording, kept)
    save(kept, tmp_path / "b.rrd")
    same(recording, load(tmp_path / "b.rrd"))


MEMORY = """
import sys
import numpy as np
from recordings.files import load
from recordings.rrd.writer import RrdWriter

path, noise = sys.argv[1], np.random.default_rng(0)
static = dict(zone_grid=[1, 1], bin_width_s=1e-10, time_zero_s=0.0)
with RrdWriter(path, static) as writer:
    for i in range(260):
        depth = noise.random((480, 848), np.float32)
        writer.append(dict(counts=np.ones((1, 4), "u4"), timestamp_s=float(i), depth_m=depth))
for i, frame in enumerate(load(path).depth_m):
    assert frame.shape == (480, 848)
assert i == 259
print(open("/proc/self/status").read().split("VmHWM:")[1].split()[0])
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the size of a process is asked from Linux")
def test_a_recording_larger_than_memory_allows_is_written_and_read_frame_by_frame(tmp_path):
    """423 MB of depth pass through a process that is never larger than 350 MB, libraries included."""
    done = subprocess.run(
        [sys.executable, "-c", MEMORY, tmp_path / "a.rrd"], capture_output=True, text=True, check=True
    )
    assert int(done.stdout) < 350_000
