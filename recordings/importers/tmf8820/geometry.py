"""What a sensor at a known pose sees of a mesh: depth and incidence, by casting rays."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from recordings.refusal import Refusal

# A binary STL is a header of 80 bytes, the number of triangles in 4, and 50 bytes a triangle.
STL_HEADER, STL_TRIANGLE = 84, 50


def mesh_beside(path: Path) -> Path:
    """The .stl that belongs to a recording: named like it, or like it and more, or the only one there."""
    meshes = sorted(mesh for mesh in path.parent.iterdir() if mesh.suffix.lower() == ".stl")
    for candidates in (
        [mesh for mesh in meshes if mesh.stem == path.stem],
        [mesh for mesh in meshes if mesh.stem.startswith(path.stem)],
        meshes,
    ):
        if len(candidates) == 1:
            return candidates[0]
    there = ", ".join(mesh.name for mesh in meshes) or "none"
    expected = f"its mesh {path.stem}*.stl beside it (there: {there})"
    raise Refusal(f"{path}: has poses but no dist_to_plane, expected {expected}")


def read_mesh(path: Path) -> np.ndarray:
    """(N, 3, 3) corners of a mesh's triangles, metres, from a binary STL."""
    content = path.read_bytes()
    triangles = int.from_bytes(content[80:STL_HEADER], "little")
    expected = STL_HEADER + STL_TRIANGLE * triangles
    if not triangles or len(content) != expected:
        raise Refusal(f"{path}: is {len(content)} bytes, expected a binary STL, which would be {expected}")
    layout = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(content, layout, offset=STL_HEADER)["corners"]
    if not np.isfinite(corners).all():
        at = int(np.argwhere(~np.isfinite(corners))[0, 0])
        raise Refusal(f"{path}: triangle {at} has a corner that is not finite, expected metres")
    return corners


def seen(corners: np.ndarray, poses: np.ndarray, rays: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """For each pose, depth along z in metres and cosine of incidence, (H, W) float32; NaN where a ray misses.

    corners: (N, 3, 3) triangles in the world. poses: (F, 4, 4) world from sensor. rays: (H, W, 3) in the
    sensor's frame, of length 1 along z.
    """
    import open3d

    scene = open3d.t.geometry.RaycastingScene()
    vertices = np.ascontiguousarray(corners.reshape(-1, 3), np.float32)
    scene.add_triangles(vertices, np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3))
    length = np.linalg.norm(rays, axis=-1)
    for pose in poses:
        directions = rays @ pose[:3, :3].T
        origins = np.broadcast_to(pose[:3, 3], directions.shape)
        hit = scene.cast_rays(np.concatenate([origins, directions], axis=-1).astype(np.float32))
        depth = hit["t_hit"].numpy()
        cosine = np.abs((hit["primitive_normals"].numpy() * directions).sum(-1)) / length
        yield (
            np.where(np.isfinite(depth), depth, np.nan).astype(np.float32),
            np.where(np.isfinite(depth), cosine, np.nan).astype(np.float32),
        )
