"""RGB-D frames as the book "14 Lectures on Visual SLAM" keeps them: color/N.png, depth/N.pgm, pose.txt."""

from pathlib import Path

import numpy as np

from physics.scene.rgbd_frames import paired, views
from physics.scene.trajectory import pose_of
from physics.scene.view import Views
from recordings.refusal import Refusal
from recordings.untrusted import reading

DEPTH_PER_METRE = 1000
# The files do not carry the camera: these are the numbers of the book's program (slambook2, ch5/rgbd).
INTRINSICS = np.array([[518.0, 0, 325.5], [0, 519.0, 253.5], [0, 0, 1]])


def reads(folder: Path) -> bool:
    """Whether the folder is laid out so."""
    return all((folder / name).exists() for name in ("color", "depth", "pose.txt"))


def open_views(folder: Path) -> Views:
    """The frames of the folder."""
    path, poses = folder / "pose.txt", []
    with reading(path, "list of poses"):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if line.strip():
                values = np.array(line.split(), float)
                if len(values) != 7:
                    raise Refusal(f"line {number} has {len(values)} numbers, expected 7: x y z qx qy qz qw")
                poses.append(pose_of(values[:3], values[3:], f"line {number}"))
    pairs = paired(folder / "color", folder / "depth")
    meta = {"scene": folder.name, "scene_form": "slambook2 RGB-D", "reflectance": "guessed from colour"}
    return Views(INTRINSICS, views(pairs, DEPTH_PER_METRE, np.array(poses)), len(pairs), meta=meta)
