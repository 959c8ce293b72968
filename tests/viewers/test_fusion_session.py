import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from rerun.chunk import RrdReader

from recordings.refusal import Refusal
from viewers import viewer
from viewers.fusion_session import live_session, part_path, saved_session

from .fusion_frames import BINS, ZONES, frame, rig

FRAMES = 12


def rows(path):
    """Record batches by entity."""
    found = {}
    for chunk in RrdReader(path).stream():
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def column(batches, ending):
    """All values of the component whose name ends so, in the order of the frames; static ones first."""
    values = []
    for batch in batches:
        name = next((n for n in batch.schema.names if n.endswith(ending)), None)
        if name is not None:
            numbers = batch.column("frame").to_pylist() if "frame" in batch.schema.names else [-1] * batch.num_rows
            values += [(n, v) for n, v in zip(numbers, batch.column(name).to_pylist(), strict=True) if v is not None]
    return [value for _, value in sorted(values, key=lambda pair: pair[0])]


def tensor(value):
    """The numbers of a tensor."""
    return np.array(value[0]["buffer"])


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("session") / "seen.rrd"
    with saved_session(path, rig(has_residuals=True, has_recorded_depth=True), most_points=500) as push:
        for i in range(FRAMES):
            push(frame(i))
    return path


@pytest.fixture(scope="module")
def found(path):
    return rows(path)


def verify(path):
    rerun = Path(sys.executable).with_name("rerun")
    subprocess.run([rerun, "rrd", "verify", path], check=True, capture_output=True)


def test_is_a_sound_file_with_a_blueprint(path):
    verify(path)
    assert RrdReader(path).blueprints()
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_has_one_timeline_in_seconds_and_one_in_frames(found):
    timelines = set()
    for batches in found.values():
        for batch in batches:
            timelines |= {f.name for f in batch.schema if (f.metadata or {}).get(b"rerun:kind") == b"index"}
    assert timelines == {"frame", "time"}


def test_histograms_are_the_counts_by_millimetres(found):
    for p, name in ((0, "0_0"), (ZONES - 1, "1_2")):
        shown = [tensor(v) for v in column(found[f"/lidar/zone/{name}"], "BarChart:values")]
        np.testing.assert_array_equal(shown, [frame(i).counts[p] for i in range(FRAMES)])
        (axis,) = column(found[f"/lidar/zone/{name}"], "BarChart:abscissa")
        np.testing.assert_allclose(tensor(axis), (np.arange(BINS) - 4) * 100, atol=1e-9)


def test_fitted_depths_stand_in_the_histograms(found):
    batches = found["/lidar/zone/0_1/depths"]
    at, height = (column(batches, f"BarChart:{name}") for name in ("abscissa", "values"))
    for i in range(FRAMES):
        np.testing.assert_array_equal(tensor(at[i]), [1234 + i, 0])
        np.testing.assert_array_equal(tensor(height[i]), [frame(i).counts[1].max(), 0])
    strongest = column(found["/depth_of_zone"], "Scalars:scalars")
    np.testing.assert_allclose(strongest, [[1.234 + 0.001 * i] * ZONES for i in range(FRAMES)])


def test_depth_is_that_of_the_pixels(found):
    (first, *_) = column(found["/fused/depth"], "EncodedDepthImage:blob")
    image = cv2.imdecode(np.frombuffer(bytes(first[0]), np.uint8), cv2.IMREAD_UNCHANGED)
    assert (image[:3] == 0).all()
    assert (image[3:] == 2000).all()
    (sigma, *_) = column(found["/fused/sigma"], "EncodedDepthImage:blob")
    assert np.unique(cv2.imdecode(np.frombuffer(bytes(sigma[0]), np.uint8), cv2.IMREAD_UNCHANGED)).tolist() == [0, 200]


def test_the_image_is_compressed_and_in_its_colours(found):
    (first, *_) = column(found["/world/rig/camera/rgb"], "EncodedImage:blob")
    blob = bytes(first[0])
    assert blob.startswith(b"\xff\xd8")
    image = cv2.imdecode(np.frombuffer(blob, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    np.testing.assert_allclose(image.mean(axis=(0, 1)), (200, 100, 50), atol=3)


def test_the_cloud_is_thinned_and_moves_with_the_camera(found):
    clouds = column(found["/world/cloud"], "Points3D:positions")
    assert len(clouds) == FRAMES
    for i in (0, FRAMES - 1):
        points = np.array(clouds[i])
        assert 250 < len(points) <= 500
        np.testing.assert_allclose(points[:, 2], 2.0 - 0.01 * i, atol=1e-6)
        assert points[:, 0].min() == pytest.approx(0.1 * i - 31.5 / 50 * (2 - 0.01 * i), abs=0.1)
    track = [np.ravel(strip[0]) for strip in column(found["/world/trajectory"], "LineStrips3D:strips")]
    np.testing.assert_allclose(track, [[0.1 * i, 0, 0, 0.1 * i + 0.1, 0, 0] for i in range(FRAMES - 1)], atol=1e-6)


def test_residuals_and_the_camera_s_depth_are_there(found):
    assert len(column(found["/residual"], "Tensor:data")) == FRAMES
    assert len(column(found["/recorded_depth"], "EncodedDepthImage:blob")) == FRAMES


def test_a_long_session_is_split_into_files_that_open_alone(tmp_path):
    path, most = tmp_path / "long.rrd", 200_000
    with saved_session(path, rig(), part_bytes=most) as push:
        for i in range(200):
            push(frame(i, expected=None))
    parts = [part_path(path, n) for n in range(1, 1 + len(list(tmp_path.iterdir())))]
    assert len(parts) >= 3
    frames = []
    for part in parts:
        verify(part)
        assert RrdReader(part).blueprints()
        there = rows(part)
        assert there["/about"]
        assert there["/world/rig/camera/footprint/0_0"]
        frames += [n for batch in there["/fused/depth"] for n in batch["frame"].to_pylist()]
        # Frames that are flushed together may go beyond the limit.
        assert part.stat().st_size < 4 * most
    assert sorted(frames) == list(range(200))
    with pytest.raises(Refusal, match=r"part2.rrd is there from another session"), saved_session(path, rig()):
        pass


def test_nothing_is_left_of_a_session_that_fails(tmp_path):
    path = tmp_path / "a.rrd"
    path.write_bytes(b"before")

    def fail_after_three_files():
        with saved_session(path, rig(), part_bytes=1000) as push:
            for i in range(70):
                push(frame(i))
            raise RuntimeError("of the frames")

    with pytest.raises(RuntimeError, match="of the frames"):
        fail_after_three_files()
    assert [p.name for p in tmp_path.iterdir()] == ["a.rrd"]
    assert path.read_bytes() == b"before"


@pytest.mark.parametrize("name", ["a.txt", "none/a.rrd"])
def test_a_place_that_cannot_be_written_to_is_refused(tmp_path, name):
    with pytest.raises(Refusal, match=r"\.rrd|does not exist"), saved_session(tmp_path / name, rig()):
        pass
    assert list(tmp_path.iterdir()) == []


def test_without_display_or_viewer_a_sentence_says_what_to_do(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(viewer, "ADDRESS", "rerun+http://127.0.0.1:1/proxy")
    with pytest.raises(Refusal, match=r"no display .* --save FILE\.rrd"):
        live_session(rig())
    with pytest.raises(Refusal, match="no viewer answers"):
        live_session(rig(), "rerun+http://127.0.0.1:1/proxy")
    with pytest.raises(Refusal, match="no viewer answers"):
        live_session(rig(), "nonsense")


@pytest.mark.parametrize("program", [None, "#!/bin/sh\nexit 1\n"])
def test_a_viewer_that_does_not_start_is_said(monkeypatch, tmp_path, program):
    monkeypatch.setattr(viewer, "ADDRESS", "rerun+http://127.0.0.1:1/proxy")
    monkeypatch.setattr(viewer, "has_display", lambda: True)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setenv("PATH", str(tmp_path / "none"))
    if program is not None:
        (tmp_path / "rerun").write_text(program)
        (tmp_path / "rerun").chmod(0o755)
    with pytest.raises(Refusal, match=r"the viewer .*(not installed|cannot be started).*--save FILE\.rrd"):
        live_session(rig())
