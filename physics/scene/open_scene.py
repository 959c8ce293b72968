"""A scene by what is found at its path."""

from pathlib import Path

import numpy as np

from physics.scene import mesh, rgbd_open3d, rgbd_slambook
from physics.scene.camera import camera_of
from physics.scene.cast import Thing, cast
from physics.scene.material import Material
from physics.scene.of_recording import open_recording
from physics.scene.scene_file import open_scene_file
from physics.scene.trajectory import Trajectory, read_trajectory
from physics.scene.view import Views
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

RGBD = (rgbd_open3d, rgbd_slambook)
SNIFFED_BYTES = 1 << 16


def open_scene(path: str | Path, maps: ResponseMaps, poses: str | Path | None = None) -> Views:
    """Views of an RGB-D folder, a mesh, a scene.json, or a recording with depth, in whichever form it is known.

    poses: where a mesh is seen from, a file of poses (`read_trajectory`); from the world's origin along z where None.
    Scenes without a camera are seen through one over the field of `maps`.
    """
    path = Path(path)
    is_mesh = path.suffix.lower() in mesh.SUFFIXES
    if poses is not None and not is_mesh:
        raise Refusal(f"{poses}: poses go with a mesh, but {path} brings its own")
    if path.is_dir():
        for reader in RGBD:
            if reader.reads(path):
                return reader.open_views(path)
        raise Refusal(f"{path}: no RGB-D folder that is known, expected color, depth, and trajectory.log or pose.txt")
    if is_mesh:
        trajectory = Trajectory(np.zeros(1), np.eye(4)[None]) if poses is None else read_trajectory(poses)
        intrinsics, size = camera_of(maps)
        things = [Thing(mesh.Mesh.read(path), Material())]
        return cast(things, trajectory, intrinsics, size, {"scene": path.name, "scene_form": "mesh"})
    if path.suffix.lower() == ".json" and _starts_as_object(path):
        return open_scene_file(path, maps)
    return open_recording(path)


def _starts_as_object(path: Path) -> bool:
    """Whether a JSON file holds an object: published frames are a list."""
    with path.open("rb") as file:
        return file.read(SNIFFED_BYTES).removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{"
