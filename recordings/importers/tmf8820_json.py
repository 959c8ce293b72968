"""Importer of the two published TMF8820 data sets: JSON frames, with a mesh or a plane whose place is known.

Layout after the data of Sifferman et al., "Unlocking the Performance of Proximity Sensors by Utilizing
Transient Histograms" (RA-L 2023), and Mu et al., "Towards 3D Vision with Low-Cost Single-Photon Cameras"
(CVPR 2024). Geometry becomes the depth of a virtual camera at the sensor, the zone table maps over its image.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.constants import speed_of_light

from recordings.head import head
from recordings.importers.tmf8820.frames import Tmf8820Frames, read_frames
from recordings.importers.tmf8820.geometry import mesh_beside, read_mesh, seen
from recordings.importers.tmf8820.ticks import tick_times_s
from recordings.importers.tmf8820.virtual_camera import VirtualCamera, camera_over, coverage
from recordings.importers.tmf8820.zones import read_zones
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal
from recordings.stream import Stream

# Robot-calibrated fit of the RA-L 2023 paper's code, where light from d metres falls into the bin that holds
# 73.484 d + 13.2521, rounded down: so it counts from the start of bin 0.
BINS_PER_METRE = 73.484
ZERO_BINS = 13.2521
BIN_WIDTH_S = 2 / (speed_of_light * BINS_PER_METRE)


def reads(path: Path) -> bool:
    """Whether the file starts as a JSON list of frames with histograms does."""
    began = head(path)
    return began.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"[" and b'"hists"' in began


def stream(path: Path, mesh: Path | None = None, zones_path: Path | None = None) -> Stream:
    """The frames of the file as a stream; `Refusal` names the frame and field, or the neighbour, at fault.

    mesh, zones_path: what else is looked for beside the file.
    """
    frames = read_frames(path)
    zones = read_zones(path, zones_path)
    if frames.counts.shape[1] != len(zones.low):
        zone_count = frames.counts.shape[1]
        raise Refusal(f"{path}: hists has {zone_count} zones, but the table beside it has {len(zones.low)}")
    camera = camera_over(zones)
    times = tick_times_s(frames.reported.get("on_chip", {}).get("tick"))
    views, geometry = scene(path, frames, camera, mesh)
    static = {
        "zone_grid": np.array(zones.grid),
        "bin_width_s": np.array(BIN_WIDTH_S),
        "time_zero_s": np.array(ZERO_BINS * BIN_WIDTH_S),
        "intrinsics": camera.intrinsics,
        "image_size": np.array([camera.size_px, camera.size_px]),
        "lidar_from_camera": np.eye(4),
        "meta_json": json.dumps(described(frames, geometry, times is not None)),
    }
    rows = per_frame(frames, views, np.arange(len(frames.counts), dtype=float) if times is None else times)
    return Stream(static=static, frames=rows, count=len(frames.counts))


def maps(path: Path, zones_path: Path | None = None) -> ResponseMaps:
    """The zone table beside the file as response maps over the virtual image: 1 inside a zone, 0 outside."""
    zones = read_zones(path, zones_path)
    camera = camera_over(zones)
    ys, xs = np.mgrid[: camera.size_px, : camera.size_px].reshape(2, -1)
    meta = {
        "image_size": [camera.size_px, camera.size_px],
        "intrinsics": camera.intrinsics.tolist(),
        "sensor": "TMF8820",
        "provenance": "datasheet rectangles, not measured",
    }
    return ResponseMaps(
        responses=coverage(camera, zones).reshape(*zones.grid, -1).astype(np.float32),
        xs=xs.astype(np.float32),
        ys=ys.astype(np.float32),
        cap_ids=np.array([f"{y:02d}_{x:02d}" for x, y in zip(xs, ys, strict=True)]),
        meta_json=json.dumps(meta),
    )


def scene(
    path: Path, frames: Tmf8820Frames, camera: VirtualCamera, mesh: Path | None = None
) -> tuple[Iterator[Any], str]:
    """What the camera sees in each frame, depth and cosine of incidence, and in words what it looks at."""
    if frames.distance_m is not None:
        return plane(frames.distance_m, camera), "a plane at normal incidence, dist_to_plane away"
    if frames.pose is None:
        raise Refusal(f"{path}: frame 0 has neither pose nor dist_to_plane, expected one that places the scene")
    mesh = mesh_beside(path) if mesh is None else mesh
    return seen(read_mesh(mesh), frames.pose, camera.rays), f"the mesh {mesh.name} seen from pose"


def plane(distance_m: np.ndarray, camera: VirtualCamera) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Depth and cosine of incidence of a plane square to the optical axis at each distance."""
    cosine = (1 / np.linalg.norm(camera.rays, axis=-1)).astype(np.float32)
    for metres in distance_m:
        yield np.full(cosine.shape, metres, np.float32), cosine


def per_frame(frames: Tmf8820Frames, views: Iterator[Any], times_s: np.ndarray) -> Iterator[dict[str, Any]]:
    """The per-frame fields."""
    for i, (depth, cosine) in enumerate(views):
        frame = {"counts": frames.counts[i], "timestamp_s": float(times_s[i])}
        frame |= {"depth_m": depth, "incidence_cosine": cosine}
        yield frame if frames.pose is None else frame | {"camera_pose": frames.pose[i]}


def described(frames: Tmf8820Frames, geometry: str, ticked: bool) -> dict[str, Any]:
    """The recording's metadata: provenance, what is assumed, and everything the sensor reported besides."""
    assumed = [
        f"bin_width_s, time_zero_s: published fit of {BINS_PER_METRE} bins a metre, zero at {ZERO_BINS} bins",
        f"depth_m and incidence_cosine: {geometry}",
    ]
    if not ticked:
        assumed.append("timestamp_s: one frame a second, as the sensor's counter is absent or not valid")
    besides = dict(frames.reported)
    sensor = {name: besides.pop(name) for name in ("on_chip", "reference_counts") if name in besides}
    return {
        "sensor": "TMF8820",
        "mode": "3x3, short range",
        "provenance": "published TMF8820 data set (Sifferman et al. 2023, Mu et al. 2024)",
        "camera": "virtual pinhole at the sensor, x and y along the sensor's own",
        "assumed": assumed,
        **sensor,
        "publisher_fields": besides,
    }
