"""What `difflidar view` shows of a folder that `difflidar fuse` wrote."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fusion.save import SUMMARY, load_frames, load_summary
from recordings.refusal import Refusal
from viewers.session_frame import SessionFrame, SessionRig

HOW_TO_READ = (
    "**Camera**: lines run round what each zone contributes most to in the first frame.",
    "**Depth** is along the camera's axis, blue near, red far; the uncertainty is its standard error. "
    "Hover for values in metres.",
    "Histograms are in the recording: `difflidar view RECORDING --calibration MAPS` shows them, too.",
)


def is_fused(path: Path) -> bool:
    """Whether a path is a folder of fused frames."""
    return path.is_dir() and (path / SUMMARY).is_file()


def open_fused(path: Path) -> tuple[SessionRig, Iterator[SessionFrame], int]:
    """The rig of a folder, its frames as they are read, and how many there are."""
    said = load_summary(path)
    entries, grid = said.get("frames"), said.get("zone_grid")
    if not isinstance(entries, list) or not entries:
        raise Refusal(f"{path / SUMMARY}: lists no frames, expected at least one")
    if not (isinstance(grid, list) and len(grid) == 2 and all(isinstance(n, int) and n > 0 for n in grid)):
        raise Refusal(f"{path / SUMMARY}: zone_grid is {grid!r}, expected rows and columns")
    poses = [_pose(entry) for entry in entries]
    first, _ = next(load_frames(path), (None, None))
    if first is None:
        raise Refusal(f"{path / 'frames'}: holds no frame, expected those that {SUMMARY} lists")
    sentences = [str(sentence) for sentence in said.get("sentences", [])]
    rig = SessionRig(
        (grid[0], grid[1]),
        footprints=(first.zones == np.arange(grid[0] * grid[1])[:, None, None]).astype(np.float32),
        title=path.resolve().name,
        sentences=(f"{len(entries)} frames, fused by the method *{said.get('method')}*.", *sentences, *HOW_TO_READ),
        first_pose=next((pose for pose in poses if pose is not None), None),
    )
    return rig, _frames(path, poses), len(entries)


def _frames(path: Path, poses: list[np.ndarray | None]) -> Iterator[SessionFrame]:
    for number, (fused, zones) in enumerate(load_frames(path)):
        if number >= len(poses):
            raise Refusal(f"{path / SUMMARY}: lists {len(poses)} frames, expected all that are in frames/")
        counts = zones.get("surface_counts")
        share = None if counts is None else counts / np.maximum(np.nansum(counts, axis=-1, keepdims=True), 1e-12)
        yield SessionFrame(
            fused.timestamp_s,
            surface_m=zones.get("surface_m"),
            surface_share=share,
            fused=fused,
            pose=fused.pose if fused.pose is not None else poses[number],
        )


def _pose(entry: Any) -> np.ndarray | None:
    """(4, 4) world from camera, recorded or by odometry; None where it could not be told."""
    said = entry.get("pose") if isinstance(entry, dict) else None
    if said is None:
        return None
    pose = np.asarray(said, float)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise Refusal(f"{SUMMARY}: a pose has shape {pose.shape}, expected finite (4, 4)")
    return pose
