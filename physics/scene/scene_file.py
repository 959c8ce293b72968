"""A scene in words: scene.json with materials, surfaces, and the path of the sensor among them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from physics.json_values import a_list, a_number, a_text, a_whole_number, an_object, numbers
from physics.scene.camera import camera_of, pinhole
from physics.scene.cast import Thing, cast
from physics.scene.material import Material
from physics.scene.mesh import Mesh
from physics.scene.surfaces import Box, Corner, Plane, Sphere, Surface
from physics.scene.trajectory import Trajectory, looking_at, pose_of
from physics.scene.view import Views
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal
from recordings.untrusted import reading

FORMAT = "difflidar-scene/1"
MOST_PIXELS, MOST_FRAMES = 1 << 14, 1 << 20
SCENE = {"format": True, "camera": False, "materials": False, "surfaces": True, "trajectory": True}
CAMERA = {"width": True, "height": True, "horizontal_deg": True}
MATERIAL = {"reflectance": True, "specular": False, "shininess": False, "colour": False}
TRAJECTORY = {"frames": True, "poses": True}
POSE = {"time_s": True, "position_m": True, "look_at_m": False, "quaternion_xyzw": False}
KINDS = {
    "plane": {"point_m": True, "normal": True},
    "sphere": {"centre_m": True, "radius_m": True},
    "box": {"centre_m": True, "size_m": True, "rotation_deg": False},
    "corner": {"apex_m": True, "rotation_deg": False},
    "mesh": {"file": True, "position_m": False, "rotation_deg": False},
}


def open_scene_file(path: Path, maps: ResponseMaps) -> Views:
    """The views of a scene file; lengths in metres, the world's y axis points down."""
    with reading(path, "scene file"):
        said = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(said, dict) and said.get("format") != FORMAT:
            raise Refusal(f"format is {said.get('format')!r}, expected {FORMAT!r}")
        said = an_object(said, SCENE, "scene")
        intrinsics, size = _camera(said["camera"]) if "camera" in said else camera_of(maps)
        named = said.get("materials", {})
        materials = {n: _material(m, n) for n, m in an_object(named, dict.fromkeys(named), "materials").items()}
        surfaces = enumerate(a_list(said["surfaces"], "surfaces"))
        things = [_thing(item, f"surfaces[{i}]", materials, path.parent) for i, item in surfaces]
        meta = {"scene": path.name, "scene_form": FORMAT, "materials": named}
        return cast(things, _trajectory(said["trajectory"]), intrinsics, size, meta)


def _camera(said: Any) -> tuple[np.ndarray, tuple[int, int]]:
    known = an_object(said, CAMERA, "camera")
    size = tuple(a_whole_number(known[name], f"camera.{name}") for name in ("width", "height"))
    if min(size) < 2 or max(size) > MOST_PIXELS:
        raise Refusal(f"camera is {size[0]} x {size[1]} pixels, expected 2 to {MOST_PIXELS} each way")
    return pinhole(size, a_number(known["horizontal_deg"], "camera.horizontal_deg")), size


def _material(said: Any, name: str) -> Material:
    place = f"materials.{name}"
    known = an_object(said, MATERIAL, place)
    try:
        given = {key: a_number(value, f"{place}.{key}") for key, value in known.items() if key != "colour"}
        colour = tuple(numbers(known["colour"], f"{place}.colour", 3)) if "colour" in known else None
        return Material(**given, colour=colour)
    except Refusal as wrong:
        raise Refusal(str(wrong) if str(wrong).startswith(place) else f"{place}.{wrong}") from None


def _thing(said: Any, place: str, materials: dict[str, Material], folder: Path) -> Thing:
    kind = said.get("kind") if isinstance(said, dict) else None
    if kind not in KINDS:
        raise Refusal(f"{place}.kind is {kind!r}, expected one of {', '.join(KINDS)}")
    known = an_object(said, {"kind": True, "material": False, **KINDS[kind]}, place)
    name = known.get("material")
    if name is not None and name not in materials:
        raise Refusal(f"{place}.material is {name!r}, expected one of {', '.join(materials) or 'those in materials'}")
    return Thing(_surface(kind, known, place, folder), Material() if name is None else materials[name])


def _surface(kind: str, known: dict[str, Any], place: str, folder: Path) -> Surface:
    def vector(field: str) -> np.ndarray:
        return numbers(known[field], f"{place}.{field}", 3)

    turn = numbers(known.get("rotation_deg", [0, 0, 0]), f"{place}.rotation_deg", 3)
    rotation = Rotation.from_euler("xyz", turn, degrees=True).as_matrix()
    if kind == "plane":
        return Plane(vector("point_m"), _not_zero(vector("normal"), f"{place}.normal"))
    if kind == "sphere":
        radius = a_number(known["radius_m"], f"{place}.radius_m")
        return Sphere(vector("centre_m"), float(_above_zero(np.array([radius]), f"{place}.radius_m")[0]))
    if kind == "box":
        return Box(vector("centre_m"), _above_zero(vector("size_m"), f"{place}.size_m"), rotation)
    if kind == "corner":
        return Corner(vector("apex_m"), rotation)
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = numbers(known.get("position_m", [0, 0, 0]), f"{place}.position_m", 3)
    return Mesh.read(folder / a_text(known["file"], f"{place}.file"), pose)


def _trajectory(said: Any) -> Trajectory:
    known = an_object(said, TRAJECTORY, "trajectory")
    frames = a_whole_number(known["frames"], "trajectory.frames")
    if not 1 <= frames <= MOST_FRAMES:
        raise Refusal(f"trajectory.frames is {frames}, expected 1 to {MOST_FRAMES}")
    times, poses = [], []
    for i, item in enumerate(a_list(known["poses"], "trajectory.poses")):
        place = f"trajectory.poses[{i}]"
        given = an_object(item, POSE, place)
        position = numbers(given["position_m"], f"{place}.position_m", 3)
        if ("look_at_m" in given) == ("quaternion_xyzw" in given):
            raise Refusal(f"{place} has {'both' if 'look_at_m' in given else 'none'} of look_at_m and quaternion_xyzw")
        if "look_at_m" in given:
            poses.append(looking_at(position, numbers(given["look_at_m"], f"{place}.look_at_m", 3), place))
        else:
            poses.append(pose_of(position, numbers(given["quaternion_xyzw"], f"{place}.quaternion_xyzw", 4), place))
        times.append(a_number(given["time_s"], f"{place}.time_s"))
    if not poses:
        raise Refusal("trajectory.poses is empty, expected at least one pose")
    return Trajectory(np.array(times), np.stack(poses)).resampled(frames)


def _above_zero(values: np.ndarray, place: str) -> np.ndarray:
    if not (values > 0).all():
        raise Refusal(f"{place} holds {values.min():g}, expected metres above 0")
    return values


def _not_zero(normal: np.ndarray, place: str) -> np.ndarray:
    if not normal.any():
        raise Refusal(f"{place} is 0, expected a direction")
    return normal
