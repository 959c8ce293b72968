"""One frame, a rig from its recording, and a whole recording into a folder."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from fusion.depths import zone_depths
from fusion.fuse import METHODS, fuse, fuse_frame
from fusion.fused import NO_ZONE, FusedFrame
from fusion.rig import open_rig
from fusion.save import folder_aside, load_frames, load_summary
from fusion.session import fuse_into
from physics.scene.view import View, Views
from physics.simulate import simulate
from recordings.encoded import encode
from recordings.files import save
from recordings.refusal import Refusal
from recordings.stream import Stream

INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])


def recorded(rig, count=3, depth=0.7, **without):
    """A wall, seen from places a little apart."""
    rgb = np.random.default_rng(0).integers(0, 255, (24, 32, 3)).astype(np.uint8)

    def views():
        for i in range(count):
            pose = np.eye(4)
            pose[0, 3] = 0.01 * i
            more = {"rgb": rgb, "camera_pose": pose, "reflectance": np.full((24, 32), 0.5, np.float32)}
            wall = np.full((24, 32), depth, np.float32)
            yield View(0.1 * i, wall, **{n: v for n, v in more.items() if n not in without})

    scene = Views(INTRINSICS, views(), count)
    return simulate(scene, rig.maps, rig.sensor, np.random.default_rng(1), peak=2000)[0].collect()


@pytest.fixture(scope="module")
def recording(rig):
    return recorded(rig)


@pytest.mark.parametrize("method", METHODS)
def test_a_wall_comes_out_where_it_is(rig, recording, method):
    fused = fuse_frame(recording.counts[0], recording.rgb[0], rig.sight, rig.response, method, timestamp_s=4.0)
    assert (fused.method, fused.timestamp_s, fused.pose) == (method, 4.0, None)
    heard = (rig.sight.normalised > 0.3).any(axis=0)
    assert np.abs(fused.depth_m[heard] - 0.7).max() < (0.05 if method == "splat" else 0.1)
    assert (fused.zones[heard] != NO_ZONE).all()
    assert fused.confidence[heard].min() > 0.2
    assert (fused.zones[~fused.known] == NO_ZONE).all()
    np.testing.assert_array_equal(fused.rgb, recording.rgb[0])


@pytest.mark.parametrize("method", METHODS)
def test_dead_zones_and_missing_pictures(rig, recording, method):
    counts = recording.counts[0].copy()
    counts[0] = 0
    fused = fuse_frame(counts, None, rig.sight, rig.response, method)
    assert fused.rgb is None
    assert fused.known.any()
    assert not (fused.zones == 0).any()
    nothing = fuse_frame(np.zeros_like(counts), None, rig.sight, rig.response, method)
    assert not nothing.known.any()
    assert not nothing.confidence.any()


def test_pictures_may_be_encoded_and_depths_known(rig, recording):
    seen = zone_depths(recording.counts[0], rig.response)
    given = fuse_frame(recording.counts[0], encode(recording.rgb[0]), rig.sight, rig.response, "splat", depths=seen)
    found = fuse_frame(recording.counts[0], recording.rgb[0], rig.sight, rig.response, "splat")
    np.testing.assert_array_equal(given.depth_m, found.depth_m)
    np.testing.assert_array_equal(given.rgb, found.rgb)


@pytest.mark.slow
def test_images_that_no_depth_explains_tell_nothing(rig, recording, tmp_path):
    """The same picture from another place: nothing moved, as if all of it were infinitely far."""
    save(recording, tmp_path / "r.npz")
    together, alone = (
        [frame.depth_m for frame, _ in fuse(*open_rig(tmp_path / "r.npz", rig.maps), alone=alone)]
        for alone in (False, True)
    )
    for one, other in zip(together, alone, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.1)


def test_what_does_not_fit_is_refused(rig, recording):
    counts, rgb = recording.counts[0], recording.rgb[0]
    with pytest.raises(Refusal, match="method 'guess' is unknown, expected splat or unmix"):
        fuse_frame(counts, rgb, rig.sight, rig.response, "guess")
    with pytest.raises(Refusal, match=r"rgb holds uint8 of shape \(5, 5, 3\)"):
        fuse_frame(counts, rgb[:5, :5], rig.sight, rig.response)
    with pytest.raises(Refusal, match=r"counts have shape \(3, 48\)"):
        fuse_frame(counts[:3], rgb, rig.sight, rig.response)
    with pytest.raises(Refusal, match=r"sigma_m has shape \(2, 3\), expected \(3, 2\)"):
        FusedFrame(0.0, *np.zeros((1, 3, 2)), np.zeros((2, 3)), *np.zeros((2, 3, 2)), None, INTRINSICS, None, "splat")
    with pytest.raises(Refusal, match="depth_m has shape"):
        FusedFrame(0.0, np.zeros(3), *np.zeros((3, 3)), None, INTRINSICS, None, "splat")


def test_a_recording_says_what_rig_made_it(rig, recording, tmp_path):
    save(recording, tmp_path / "r.npz")
    passing, sight, response = open_rig(tmp_path / "r.npz", rig.maps)
    assert passing.count == 3
    assert sight.shape == (24, 32)
    assert sight.calibration_range_m == 0.8
    np.testing.assert_allclose(response.counts, rig.response.counts, atol=1e-9)
    assert [frame.timestamp_s for frame, _ in fuse(passing, sight, response, "splat")] == [0.0, 0.1, 0.2]


def test_without_a_camera_the_grid_is_that_of_the_maps(rig, recording, tmp_path):
    bare = dict.fromkeys(("rgb", "depth_m", "reflectance", "incidence_cosine", "intrinsics", "image_size"))
    save(replace(recording, **bare), tmp_path / "r.npz")
    passing, sight, response = open_rig(tmp_path / "r.npz", rig.maps)
    assert sight.shape == (6, 8)
    frame, _ = next(fuse(passing, sight, response, "splat"))
    assert frame.rgb is None
    assert np.nanmedian(frame.depth_m) == pytest.approx(0.7, abs=0.05)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"irf": None, "irf_time_s": None}, "irf is missing"),
        ({"bin_width_s": 1e-9}, "expected the same range mode"),
    ],
)
def test_recordings_of_another_sensor_are_refused(rig, recording, tmp_path, change, sentence):
    from physics.sensor_file import save_sensor

    save_sensor(rig.sensor, tmp_path / "sensor.json")
    save(replace(recording, **change), tmp_path / "r.npz")
    named = None if "irf" in change else str(tmp_path / "sensor.json")
    with pytest.raises(Refusal, match=sentence):
        open_rig(tmp_path / "r.npz", rig.maps, named)


def test_maps_of_other_zones_are_refused(rig, recording, tmp_path):
    save(recording, tmp_path / "r.npz")
    three = replace(rig.maps, responses=rig.maps.responses.reshape(1, 4, -1))
    with pytest.raises(Refusal, match="response maps have 1 x 4 zones but the recording 2 x 2"):
        open_rig(tmp_path / "r.npz", three)


def test_a_folder_holds_all_that_was_found(rig, recording, tmp_path):
    counts = recording.counts.copy()
    counts[:, 3] = 0
    passing = Stream.of(replace(recording, counts=counts))
    with folder_aside(tmp_path / "out") as folder:
        said = fuse_into(folder, passing, rig.sight, rig.response, "splat", names={"recording": "r.npz"})
    assert load_summary(tmp_path / "out") == {"format": "difflidar-fused/1"} | said
    assert "zone 3 was dead in 3 of 3 frames" in said["sentences"]
    assert said["poses"] == "recorded"
    assert "mesh.ply and cloud.ply hold 3 of 3 frames, by recorded poses" in said["sentences"]
    assert (tmp_path / "out" / "mesh.ply").exists()
    again = list(load_frames(tmp_path / "out"))
    passing = Stream.of(replace(recording, counts=counts))
    for (one, zones), (other, seen) in zip(again, fuse(passing, rig.sight, rig.response, "splat"), strict=True):
        for name in ("depth_m", "sigma_m", "confidence", "zones", "rgb", "pose", "intrinsics"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert (one.timestamp_s, one.method) == (other.timestamp_s, other.method)
        np.testing.assert_array_equal(zones["surface_m"], seen.surface_m)
    picture = cv2.imread(str(tmp_path / "out" / "depth" / "000001.png"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_allclose(picture / 1000, np.nan_to_num(again[1][0].depth_m), atol=5.1e-4)
    points = said["frames"][1]["points"]
    assert points == again[1][0].known.sum()
    head = (tmp_path / "out" / "clouds" / "000001.ply").read_bytes()[:300]
    assert f"element vertex {points}".encode() in head


def test_frames_that_see_nothing_have_no_cloud_and_no_mesh(rig, recording, tmp_path):
    dark = replace(recording, counts=np.zeros_like(recording.counts), rgb=None, camera_pose=None)
    with folder_aside(tmp_path / "out") as folder:
        said = fuse_into(folder, Stream.of(dark), rig.sight, rig.response, "splat")
    assert said["frames"][0]["depth_m"] is None
    assert "no frame has a pose and depth, so there is no mesh" in said["sentences"]
    assert not (tmp_path / "out" / "mesh.ply").exists()


def test_a_folder_is_there_whole_or_not_at_all(tmp_path):
    out = tmp_path / "out"
    with pytest.raises(ValueError, match="half"), folder_aside(out) as folder:  # noqa: PT012
        (folder / "a").write_text("half")
        raise ValueError("half")
    assert list(tmp_path.iterdir()) == []
    for text in ("first", "second"):
        with folder_aside(out) as folder:
            (folder / "summary.json").write_text(json.dumps(text))
            (folder / text).write_text("")
    assert sorted(p.name for p in out.iterdir()) == ["second", "summary.json"]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_folders_of_other_things_are_refused(tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "me.jpg").write_text("")
    (tmp_path / "file").write_text("")
    for name, sentence in (
        ("photos", "holds other files"),
        ("file", "is a file"),
        ("no/where", "does not exist"),
    ):
        with pytest.raises(Refusal, match=sentence), folder_aside(tmp_path / name):
            pass
    with pytest.raises(Refusal, match="holds no summary"):
        load_summary(tmp_path / "photos")
    (tmp_path / "photos" / "summary.json").write_text("[]")
    with pytest.raises(Refusal, match="expected format"):
        load_summary(tmp_path / "photos")
