"""RGB-D frames as Open3D's reconstruction system keeps them: color/, depth/, a camera .json, trajectory.log."""

import json
from pathlib import Path

import numpy as np

from physics.json_values import an_object, numbers
from physics.scene.rgbd_frames import paired, views
from physics.scene.view import Views
from recordings.refusal import Refusal
from recordings.relations import check_pinhole
from recordings.untrusted import reading

DEPTH_PER_METRE = 1000
CAMERA = {"width": True, "height": True, "intrinsic_matrix": True}


def reads(folder: Path) -> bool:
    """Whether the folder is laid out so."""
    return all((folder / name).exists() for name in ("color", "depth", "trajectory.log"))


def open_views(folder: Path) -> Views:
    """The frames of the folder."""
    cameras = sorted(folder.glob("*.json"))
    if len(cameras) != 1:
        raise Refusal(f"{folder}: has {len(cameras)} .json files, expected one with the camera's intrinsic_matrix")
    with reading(cameras[0], "camera file"):
        said = an_object(json.loads(cameras[0].read_text(encoding="utf-8")), CAMERA, "camera")
        # Column by column.
        intrinsics = numbers(said["intrinsic_matrix"], "intrinsic_matrix", 9).reshape(3, 3).T
        check_pinhole(intrinsics)
    poses = read_log(folder / "trajectory.log")
    pairs = paired(folder / "color", folder / "depth")
    meta = {"scene": folder.name, "scene_form": "Open3D RGB-D", "reflectance": "guessed from colour"}
    return Views(intrinsics, views(pairs, DEPTH_PER_METRE, poses), len(pairs), meta=meta)


def read_log(path: Path) -> np.ndarray:
    """(F, 4, 4) poses, world from camera: for each a line of three numbers, then the matrix in four lines."""
    with reading(path, "trajectory"):
        rows = [line.split() for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
        lengths = [len(row) for row in rows]
        if not rows or lengths != [3, 4, 4, 4, 4] * (len(rows) // 5):
            raise Refusal("expected for each pose a line of 3 numbers, then 4 lines of 4")
        return np.array([rows[i + 1 : i + 5] for i in range(0, len(rows), 5)], float)
