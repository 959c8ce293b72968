"""Triangle meshes, met by rays through Open3D."""

from pathlib import Path

import numpy as np

from recordings.refusal import Refusal

SUFFIXES = (".stl", ".ply", ".obj", ".off", ".glb", ".gltf")


class Mesh:
    """A mesh in the world as a surface; see `physics.scene.surfaces.Surface`."""

    def __init__(self, vertices: np.ndarray, triangles: np.ndarray) -> None:
        import open3d

        self._scene = open3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(
            np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(triangles, np.uint32)
        )

    @classmethod
    def read(cls, path: str | Path, pose: np.ndarray | None = None) -> "Mesh":
        """The mesh in a file that Open3D reads, metres, placed by `pose` (4, 4), world from mesh."""
        import open3d

        path = Path(path)
        if path.suffix.lower() not in SUFFIXES:
            raise Refusal(f"{path}: is no mesh by its name, expected one of {', '.join(SUFFIXES)}")
        with open(path, "rb"):
            pass  # What the operating system says of a missing file, Open3D would only print.
        with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
            mesh = open3d.io.read_triangle_mesh(str(path))
        vertices, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
        if len(triangles) == 0 or not np.isfinite(vertices).all():
            raise Refusal(f"{path}: holds {len(triangles)} triangles that can be read, expected a mesh of finite ones")
        if pose is not None:
            vertices = vertices @ pose[:3, :3].T + pose[:3, 3]
        return cls(vertices, triangles)

    def hit(self, origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lengths (N,), inf where the mesh is missed, and unit normals (N, 3)."""
        rays = np.concatenate([np.broadcast_to(origin, directions.shape), directions], axis=-1)
        found = self._scene.cast_rays(rays.astype(np.float32))
        return found["t_hit"].numpy().astype(float), found["primitive_normals"].numpy().astype(float)
