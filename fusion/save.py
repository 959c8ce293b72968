"""A folder of fused frames: depth as pictures and as numbers, clouds, and what was found on the whole."""

import json
import os
import shutil
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from fusion.cloud import cloud
from fusion.fused import FusedFrame
from fusion.zone_view import ZoneDepths
from recordings.encoded import decoded, encode
from recordings.npz_members import members
from recordings.refusal import Refusal
from recordings.untrusted import reading

FORMAT = "difflidar-fused/1"
SUMMARY = "summary.json"
FOLDERS = ("color", "depth", "frames", "clouds")
IMAGES = ("depth_m", "sigma_m", "confidence", "zones", "intrinsics")
SURFACES = ("surface_m", "surface_counts", "surface_sigma_m", "surface_spread_m", "nothing", "state")
MOST_MM = 65535


@contextmanager
def folder_aside(out: str | Path) -> Iterator[Path]:
    """Yield a new folder beside `out`; it takes that name when the block ends without error, whole or not at all.

    An empty folder, or one that was written by this before, is replaced; anything else at `out` is refused.
    """
    out = Path(out).absolute()
    expect_folder_for(out)
    aside = out.with_name(f".{out.name}.{os.getpid()}.aside")
    before = out.with_name(f".{out.name}.{os.getpid()}.before")
    try:
        aside.mkdir()
        yield aside
        if out.exists():
            os.replace(out, before)
        os.replace(aside, out)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
        shutil.rmtree(before, ignore_errors=True)


def expect_folder_for(out: Path) -> None:
    """Refuse, before any work, a place where no folder of results can be."""
    if not out.absolute().parent.is_dir():
        raise Refusal(f"{out}: the folder {out.absolute().parent} does not exist")
    if not os.access(out.absolute().parent, os.W_OK):
        raise Refusal(f"{out}: no permission to write into {out.absolute().parent}")
    if out.is_file():
        raise Refusal(f"{out}: is a file, expected a folder, or a name for one")
    if out.is_dir() and any(out.iterdir()) and not (out / SUMMARY).exists():
        raise Refusal(f"{out}: holds other files, expected a new or empty folder, or one of earlier results")


def save_frame(folder: Path, number: int, frame: FusedFrame, seen: ZoneDepths | None = None) -> dict[str, Any]:
    """Write one frame under its number; what the summary says of it.

    color/: as PNG, where there is an image. depth/: 16-bit PNG in millimetres, 0 where unknown. frames/: .npz of all
    numbers, surfaces of the zones among them. clouds/: PLY, in the camera's frame.
    """
    import open3d

    for name in FOLDERS:
        if name != "color" or frame.rgb is not None:
            (folder / name).mkdir(exist_ok=True)
    stem = f"{number:06d}"
    if frame.rgb is not None:
        (folder / "color" / f"{stem}.png").write_bytes(encode(frame.rgb))
    millimetres = np.clip(np.nan_to_num(frame.depth_m) * 1000 + 0.5, 0, MOST_MM).astype(np.uint16)
    _, picture = cv2.imencode(".png", millimetres)
    (folder / "depth" / f"{stem}.png").write_bytes(picture.tobytes())
    numbers = {name: getattr(frame, name) for name in IMAGES} | {"timestamp_s": np.float64(frame.timestamp_s)}
    if frame.pose is not None:
        numbers["pose"] = frame.pose
    if seen is not None:
        numbers |= {name: getattr(seen, name) for name in SURFACES}
    np.savez_compressed(folder / "frames" / f"{stem}.npz", **numbers)
    points = cloud(frame)
    place = folder / "clouds" / f"{stem}.ply"
    if len(points) and not open3d.t.io.write_point_cloud(str(place), points.open3d()):
        raise OSError(None, "the cloud could not be written", str(place))
    known = frame.known
    return {
        "timestamp_s": float(frame.timestamp_s),
        "points": len(points),
        "known": float(known.mean()),
        "depth_m": _middle(frame.depth_m[known]),
        "sigma_m": _middle(frame.sigma_m[known]),
    }


def save_summary(folder: Path, said: dict[str, Any]) -> None:
    """Write what holds for all frames; `said` must be plain values."""
    text = json.dumps({"format": FORMAT} | said, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / SUMMARY).write_text(text + "\n", encoding="utf-8")


def load_summary(folder: str | Path) -> dict[str, Any]:
    """What `save_summary` wrote; refuses a folder without."""
    place = Path(folder) / SUMMARY
    if not place.is_file():
        raise Refusal(f"{folder}: holds no {SUMMARY}, expected a folder that `difflidar fuse` wrote")
    with reading(place, "summary of fused frames"):
        said = json.loads(place.read_text(encoding="utf-8"))
        if not isinstance(said, dict) or said.get("format") != FORMAT:
            raise Refusal(f"expected format {FORMAT!r}")
    return said


def load_frames(folder: str | Path) -> Iterator[tuple[FusedFrame, dict[str, np.ndarray]]]:
    """The frames in a folder, in order, each with the arrays of what its zones saw (`SURFACES`)."""
    method = str(load_summary(folder).get("method"))
    for place in sorted((Path(folder) / "frames").glob("*.npz")):
        with reading(place, "fused frame"), zipfile.ZipFile(place) as archive:
            there = {name: member.whole(archive) for name, member in members(archive).items()}
            if missing := [name for name in (*IMAGES, "timestamp_s") if name not in there]:
                raise Refusal(f"{missing[0]} is missing, expected {', '.join(IMAGES)}")
            colour = Path(folder) / "color" / f"{place.stem}.png"
            rgb = decoded(colour.read_bytes(), there["depth_m"].shape, colour.name) if colour.exists() else None
            images = {name: there[name] for name in IMAGES}
            yield (
                FusedFrame(float(there["timestamp_s"]), **images, rgb=rgb, pose=there.get("pose"), method=method),
                {name: there[name] for name in SURFACES if name in there},
            )


def _middle(values: np.ndarray) -> float | None:
    return float(np.median(values)) if values.size else None
