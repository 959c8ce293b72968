"""A whole recording, fused into a folder: every frame, then all of them in one volume."""

from pathlib import Path
from typing import Any

import numpy as np

from fusion.fuse import fuse
from fusion.fused import FusedFrame
from fusion.odometry import Odometry
from fusion.range_response import RangeResponse
from fusion.save import save_frame, save_summary
from fusion.sight import Sight
from fusion.volume import Volume
from fusion.zone_view import DEAD, SATURATED, ZoneDepths
from recordings.progress import Progress, silent
from recordings.stream import Stream

# A zone that more likely sees nothing than something.
NOTHING = 0.5


def fuse_into(
    folder: Path,
    passing: Stream,
    sight: Sight,
    response: RangeResponse,
    method: str,
    *,
    alone: bool = False,
    voxel_m: float = 0.04,
    names: dict[str, str] | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Write every frame of a recording into `folder`, mesh.ply and cloud.ply of all, and summary.json; what it says.

    Poses are those recorded, else by odometry where there is colour; frames whose pose cannot be told are not in the
    volume. alone: whether each frame is taken by itself. names: what to keep in the summary besides.
    Raises `Refusal` at the first frame that cannot be.
    """
    volume, odometry = Volume(voxel_m), Odometry()
    tally = np.zeros((3, sight.zones), int)
    frames = []
    for number, (frame, seen) in enumerate(
        progress(fuse(passing, sight, response, method, alone=alone), passing.count, "fusing frames")
    ):
        tally += _states(seen)
        frames.append(save_frame(folder, number, frame, seen))
        pose = _pose(frame, odometry)
        frames[-1]["pose"] = None if pose is None else pose.tolist()
        if pose is not None:
            volume.add(frame, pose)
    if volume.frames:
        _save_volume(folder, volume)
    recorded = frame.pose is not None
    said = {
        **(names or {}),
        "sensor": response.sensor.name,
        "mode": response.sensor.mode,
        "method": method,
        "alone": alone,
        "zone_grid": [int(n) for n in sight.zone_grid],
        "image_size": [int(n) for n in sight.shape[::-1]],
        "intrinsics": np.asarray(sight.intrinsics, float).tolist(),
        "poses": "recorded" if recorded else "odometry" if volume.frames else None,
        "sentences": [*_of_zones(tally, len(frames)), *_of_volume(volume, len(frames), recorded)],
        "frames": frames,
    }
    save_summary(folder, said)
    return said


def _pose(frame: FusedFrame, odometry: Odometry) -> np.ndarray | None:
    if frame.pose is not None:
        return frame.pose
    return None if frame.rgb is None or not frame.known.any() else odometry.push(frame)


def _states(seen: ZoneDepths) -> np.ndarray:
    """(3, P) which zones were dead, saturated, or more likely saw nothing than something."""
    return np.stack([seen.state == DEAD, seen.state == SATURATED, np.nan_to_num(seen.nothing) > NOTHING])


def _of_zones(tally: np.ndarray, frames: int) -> list[str]:
    """What is worth saying of zones that did not speak."""
    was = ("dead", "saturated", "empty: nothing was there")
    return [
        f"zone {zone} was {state} in {count} of {frames} frames"
        for state, counts in zip(was, tally, strict=True)
        for zone, count in enumerate(counts)
        if count
    ]


def _of_volume(volume: Volume, frames: int, recorded: bool) -> list[str]:
    if not volume.frames:
        return ["no frame has a pose and depth, so there is no mesh"]
    how = "recorded poses" if recorded else "poses by odometry"
    return [f"mesh.ply and cloud.ply hold {volume.frames} of {frames} frames, by {how}"]


def _save_volume(folder: Path, volume: Volume) -> None:
    import open3d

    for name, write, made in (
        ("mesh.ply", open3d.t.io.write_triangle_mesh, volume.mesh),
        ("cloud.ply", open3d.t.io.write_point_cloud, volume.cloud),
    ):
        # It warns of colours that interpolation took a hair beyond white.
        with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
            written = write(str(folder / name), made())
        if not written:
            raise OSError(None, "could not be written", str(folder / name))
