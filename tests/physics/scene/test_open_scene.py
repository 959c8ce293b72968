"""Scenes of every form, and what is said of those that are wrong."""

import json

import cv2
import numpy as np
import pytest

from physics.scene.camera import camera_of
from physics.scene.open_scene import open_scene
from recordings.files import load
from recordings.refusal import Refusal

ROOM = {
    "format": "difflidar-scene/1",
    "camera": {"width": 24, "height": 16, "horizontal_deg": 60},
    "materials": {"wall": {"reflectance": 0.7}, "metal": {"reflectance": 0.5, "specular": 0.5, "shininess": 80}},
    "surfaces": [
        {"kind": "box", "centre_m": [0, 0, 0], "size_m": [4, 2.5, 5], "material": "wall"},
        {"kind": "sphere", "centre_m": [0, 0, 1.5], "radius_m": 0.3, "material": "metal"},
    ],
    "trajectory": {
        "frames": 3,
        "poses": [
            {"time_s": 0, "position_m": [0, 0, 0], "look_at_m": [0, 0, 1]},
            {"time_s": 2, "position_m": [0, 0, 0.5], "quaternion_xyzw": [0, 0, 0, 1]},
        ],
    },
}


@pytest.fixture
def write(tmp_path):
    def write(said, name="scene.json"):
        path = tmp_path / name
        path.write_text(said if isinstance(said, str) else json.dumps(said))
        return path

    return write


def test_a_room_with_a_ball(write, maps):
    scene = open_scene(write(ROOM), maps)
    views = list(scene.views)
    assert len(views) == scene.count == 3
    assert [view.timestamp_s for view in views] == [0, 1, 2]
    middle = [view.depth_m[8, 12] for view in views]  # Half a pixel off the axis.
    np.testing.assert_allclose(middle, [1.2, 0.95, 0.7], atol=0.004)
    assert views[0].depth_m[0, 0] == pytest.approx(2.5, abs=1e-5)  # The far wall.
    assert views[0].incidence_cosine[8, 12] > 0.98
    assert views[0].gloss[8, 12] > 1.5
    assert views[0].gloss[0, 0] == 1
    assert set(np.unique(views[0].reflectance)) == {np.float32(0.5), np.float32(0.7)}


def swapped(**changes):
    return {**ROOM, **changes}


SPHERE = {"kind": "sphere", "centre_m": [0, 0, 1], "radius_m": 0.3}


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        (swapped(format="x/1"), "format is 'x/1', expected 'difflidar-scene/1'"),
        (swapped(sky=1), "unknown field 'sky'"),
        (swapped(surfaces=[{"kind": "torus"}]), r"surfaces\[0\].kind is 'torus', expected one of plane"),
        (swapped(surfaces=[SPHERE | {"radius_m": -1}]), r"surfaces\[0\].radius_m holds -1, expected metres above 0"),
        (swapped(surfaces=[SPHERE | {"material": "gold"}]), r"surfaces\[0\].material is 'gold', expected one of wall"),
        (swapped(surfaces=[SPHERE | {"centre_m": [0, 1]}]), r"centre_m is a list of 2, expected a list of 3"),
        (swapped(surfaces=[{"kind": "plane", "point_m": [0, 0, 1], "normal": [0, 0, 0]}]), "normal is 0"),
        (swapped(surfaces=[{"kind": "mesh", "file": "none.txt"}]), "is no mesh by its name"),
        (swapped(materials={"wall": {"reflectance": 1.2}}), "materials.wall.reflectance is 1.2, expected 0 to 1"),
        (swapped(camera={"width": 1, "height": 5, "horizontal_deg": 60}), "camera is 1 x 5 pixels"),
        (swapped(camera={"width": 9, "height": 5, "horizontal_deg": 180}), "horizontal_deg is 180"),
        (swapped(trajectory={"frames": 1e12, "poses": []}), "trajectory.frames is 1000000000000, expected 1 to"),
        (swapped(trajectory={"frames": 0, "poses": []}), "trajectory.frames is 0"),
        (swapped(trajectory={"frames": 2, "poses": []}), "trajectory.poses is empty"),
        (
            swapped(trajectory={"frames": 2, "poses": [{"time_s": 0, "position_m": [0, 0, 0]}]}),
            r"poses\[0\] has none of look_at_m and quaternion_xyzw",
        ),
        ("{", "damaged scene file"),
    ],
)
def test_scene_files_that_are_wrong(said, sentence, write, maps):
    path = write(said)
    with pytest.raises(Refusal, match=sentence) as refusal:
        open_scene(path, maps)
    assert str(path) in str(refusal.value)


def test_a_mesh_seen_along_poses(write, maps, tmp_path):
    import open3d

    mesh = open3d.geometry.TriangleMesh.create_box(2, 2, 0.1).translate([-1, -1, 1])
    open3d.io.write_triangle_mesh(str(tmp_path / "board.ply"), mesh)
    poses = write("0 0 0 0 0 0 0 1\n1 0 0 0.25 0 0 0 1\n", "poses.txt")
    scene = open_scene(tmp_path / "board.ply", maps, poses)
    middle = [view.depth_m[30, 53] for view in scene.views]
    np.testing.assert_allclose(middle, [1, 0.75], rtol=1e-5)
    (one,) = open_scene(tmp_path / "board.ply", maps).views
    assert one.depth_m.shape == (60, 106)
    with pytest.raises(Refusal, match="poses go with a mesh"):
        open_scene(write(ROOM), maps, poses)
    write("solid nothing", "empty.stl")
    with pytest.raises(Refusal, match="holds 0 triangles"):
        open_scene(tmp_path / "empty.stl", maps)
    with pytest.raises(FileNotFoundError):
        open_scene(tmp_path / "absent.stl", maps)


def test_the_camera_of_the_maps(maps):
    from dataclasses import replace

    matrix = [[612.0, 0, 423.5], [0, 612, 239.5], [0, 0, 1]]
    intrinsics, size = camera_of(replace(maps, meta_json=json.dumps({"intrinsics": matrix})))
    assert size == (106, 60)
    np.testing.assert_allclose(intrinsics, [[76.5, 0, 52.5], [0, 76.5, 29.5], [0, 0, 1]], atol=1e-9)


@pytest.mark.parametrize(
    ("folder", "focal", "far", "apart"),
    [("rgbd_open3d", (525, 525), 6, 0.006), ("rgbd_slambook2", (518, 519), 10, 0.06)],
)
def test_published_rgbd_folders(shared_data, maps, folder, focal, far, apart):
    scene = open_scene(shared_data / folder, maps)
    views = list(scene.views)
    assert len(views) == scene.count == 5
    assert (scene.intrinsics[0, 0], scene.intrinsics[1, 1]) == focal
    for view in views:
        assert view.depth_m.shape == (480, 640)
        assert np.nanmin(view.depth_m) > 0.3
        assert np.nanmax(view.depth_m) < far
        assert np.isnan(view.depth_m).mean() < 0.5
        np.testing.assert_allclose(view.camera_pose[:3, :3] @ view.camera_pose[:3, :3].T, np.eye(3), atol=1e-4)
    # Poses and depth fit: what one frame sees, seen from the next, lies on what that one sees.
    assert closeness(scene.intrinsics, views[1], views[2]) < apart


def closeness(intrinsics, here, there):
    """Median distance in metres between points of one view and the surface that the other sees along their rays."""
    v, u = np.mgrid[:480:7, :640:7]
    ray = np.stack(
        [(u - intrinsics[0, 2]) / intrinsics[0, 0], (v - intrinsics[1, 2]) / intrinsics[1, 1], 1 + 0 * u], -1
    )
    points = (here.depth_m[v, u][..., None] * ray).reshape(-1, 3)
    world = points @ here.camera_pose[:3, :3].T + here.camera_pose[:3, 3]
    seen = (world - there.camera_pose[:3, 3]) @ there.camera_pose[:3, :3]
    pixel = np.rint(seen @ intrinsics.T / seen[:, 2:])[:, :2]
    inside = (pixel >= 0).all(axis=1) & (pixel < [640, 480]).all(axis=1)
    column, row = pixel[inside].astype(int).T
    return np.nanmedian(np.abs(there.depth_m[row, column] - seen[inside, 2]))


def slambook(folder, poses="0 0 0 0 0 0 1\n", depth=None):
    for name in ("color", "depth"):
        (folder / name).mkdir()
    cv2.imwrite(str(folder / "color" / "1.png"), np.zeros((4, 5, 3), np.uint8))
    cv2.imwrite(str(folder / "depth" / "1.pgm"), np.full((4, 5), 1500, np.uint16) if depth is None else depth)
    (folder / "pose.txt").write_text(poses)
    return folder


def test_rgbd_folders_that_are_wrong(tmp_path, maps):
    def fault(**changes):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        with pytest.raises(Refusal) as refusal:
            list(open_scene(slambook(folder, **changes), maps).views)
        return str(refusal.value)

    assert "has 2 poses, expected 1" in fault(poses="0 0 0 0 0 0 1\n0 0 0 0 0 0 1\n")
    assert "line 1 has 6 numbers" in fault(poses="0 0 0 0 0 1\n")
    assert "uint8 in 2 axes, expected a grey image of 16 bits" in fault(depth=np.ones((4, 5), np.uint8))
    assert "expected those of 1.pgm" in fault(depth=np.ones((4, 6), np.uint16))
    with pytest.raises(Refusal, match="no RGB-D folder that is known"):
        open_scene(tmp_path, maps)
    (tmp_path / "sound").mkdir()
    folder = slambook(tmp_path / "sound")
    (view,) = open_scene(folder, maps).views
    assert view.depth_m[0, 0] == 1.5
    (folder / "color" / "2.png").write_bytes(b"")
    with pytest.raises(Refusal, match="a colour and a depth image of every name, '2' has not both"):
        open_scene(folder, maps)


def test_a_recording_is_a_scene(shared_data, maps):
    path = shared_data / "conformance" / "recording.npz"
    scene, seen = open_scene(path, maps), load(path)
    views = list(scene.views)
    assert len(views) == 24
    np.testing.assert_array_equal(views[3].depth_m, seen.depth_m[3])
    np.testing.assert_array_equal(views[3].incidence_cosine, seen.incidence_cosine[3])
    assert views[3].timestamp_s == seen.timestamp_s[3]


def test_a_recording_without_a_camera_is_no_scene(tmp_path, maps):
    from recordings.files import save
    from recordings.recording import Recording

    save(
        Recording(np.ones((1, 4, 8), np.uint32), np.array([2, 2]), np.array(1e-9), np.array(0.0), np.zeros(1)),
        tmp_path / "bare.npz",
    )
    with pytest.raises(Refusal, match="intrinsics is missing"):
        open_scene(tmp_path / "bare.npz", maps)
