"""The rig, one file: where sensor, camera and patch are, and how to reach the devices."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from physics.json_values import a_list, a_number, a_text, a_whole_number, an_object, numbers
from recordings.refusal import Refusal
from recordings.untrusted import reading

CAMERAS = ("realsense", "opencv", "rehearsed")
MODES = {"3x3": (3, 3), "4x4": (4, 4), "3x6": (6, 3), "8x8": (8, 8)}
RANGINGS = ("long", "short")


@dataclass(frozen=True)
class LidarSetup:
    """The sensor and its setting.

    port: serial port; "" finds the first that answers. baud: bits per second. mode: zones, columns x rows as the
    datasheet names them. ranging: "long" or "short". kilo_iterations: of 1024 laser shots, 0 takes the firmware's.
    factory_calibration: file of the page the sensor is given at start-up; "" leaves it as it is.
    """

    port: str = ""
    baud: int = 2_000_000
    mode: str = "3x3"
    ranging: str = "long"
    kilo_iterations: int = 0
    factory_calibration: str = ""


@dataclass(frozen=True)
class CameraSetup:
    """The camera and its setting.

    kind: "realsense", "opencv" (any camera that OpenCV opens, RGB only) or "rehearsed". device: serial number, index or
    address; "" takes the first. size: width and height, pixels. exposure_us: 0 leaves it to the camera.
    emitter: whether the infrared projector stays on while the LiDAR integrates. intrinsics: fx, fy, cx, cy in pixels,
    for cameras that do not know their own.
    """

    kind: str = "realsense"
    device: str = ""
    size: tuple[int, int] = (848, 480)
    fps: int = 30
    exposure_us: int = 0
    emitter: bool = False
    intrinsics: tuple[float, ...] = ()


@dataclass(frozen=True)
class ArmSetup:
    """The arm. address: of its controller. model: UR3, UR5, UR10, UR3e, UR5e, UR10e or UR16e.

    tool: (6,) pose of the patch's centre in the flange's frame, metres and rotation vector; z points out of the patch.
    joint_low_deg, joint_high_deg: (6,) limits that every position of the scan must keep.
    """

    address: str = ""
    model: str = "UR10"
    tool: tuple[float, ...] = (0.0,) * 6
    joint_low_deg: tuple[float, ...] = (-360.0,) * 6
    joint_high_deg: tuple[float, ...] = (360.0,) * 6


@dataclass(frozen=True)
class Rig:
    """Where things are, and how to reach them; the camera's frame is x right, y down, z forward, metres.

    lidar_position_m: the LiDAR in the camera's frame, lidar_rotation_deg: its rotation about x, y and z.
    patch_radius_m: of the retroreflective disc. patch_distance_m: of the plane it is moved in, along the optical axis.
    mount: measures of the printed parts that differ from the usual ones, millimetres by name.
    control: socket of a rehearsal, which stands in for the person who handles the patch; "" in a laboratory.
    """

    name: str = "rig"
    lidar_position_m: tuple[float, float, float] = (0.053, 0.024, -0.02)
    lidar_rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    patch_radius_m: float = 0.0174
    patch_distance_m: float = 0.6
    lidar: LidarSetup = LidarSetup()
    camera: CameraSetup = CameraSetup()
    arm: ArmSetup = ArmSetup()
    mount: dict[str, float] = field(default_factory=dict)
    control: str = ""

    @property
    def lidar_from_camera(self) -> np.ndarray:
        """(4, 4) rigid transform."""
        return mounted(self.lidar_position_m, self.lidar_rotation_deg)

    def text(self) -> str:
        """The file of this rig."""
        return json.dumps(asdict(self), indent=2) + "\n"


def mounted(position_m: Sequence[float], rotation_deg: Sequence[float]) -> np.ndarray:
    """(4, 4) LiDAR from camera, of a LiDAR at this position in the camera's frame, turned about its x, y and z."""
    rotation = Rotation.from_euler("xyz", rotation_deg, degrees=True).as_matrix().T
    transform = np.eye(4)
    transform[:3, :3] = rotation
    transform[:3, 3] = -rotation @ position_m
    return transform


def load_rig(path: str | Path) -> Rig:
    """Read rig.json; fields that are left out keep their defaults; `Refusal` names the field at fault."""
    with reading(path, "rig file (.json)"):
        said = json.loads(Path(path).read_text(encoding="utf-8"))
    return rig_from(said, str(path))


def rig_from(said: Any, place: str = "rig") -> Rig:
    """A rig out of JSON values."""
    rig = _filled(Rig, said, place)
    for what, value, known in (
        ("lidar.mode", rig.lidar.mode, tuple(MODES)),
        ("lidar.ranging", rig.lidar.ranging, RANGINGS),
        ("camera.kind", rig.camera.kind, CAMERAS),
    ):
        if value not in known:
            raise Refusal(f"{place}: {what} is {value!r}, expected one of {', '.join(known)}")
    for what, value in (
        ("patch_radius_m", rig.patch_radius_m),
        ("patch_distance_m", rig.patch_distance_m),
        ("lidar.baud", rig.lidar.baud),
        ("camera.fps", rig.camera.fps),
        ("camera.size", min(rig.camera.size)),
    ):
        if not value > 0:
            raise Refusal(f"{place}: {what} is {value}, expected more than 0")
    if rig.camera.intrinsics and len(rig.camera.intrinsics) != 4:
        raise Refusal(f"{place}: camera.intrinsics has {len(rig.camera.intrinsics)} numbers, expected fx, fy, cx, cy")
    return rig


def _filled(kind: type, said: Any, place: str) -> Any:
    """A dataclass of setups, numbers and texts out of a JSON object, each value as its default is."""
    known = fields(kind)
    an_object(said, {f.name: False for f in known}, place)
    default = kind()
    values = {name: _value(getattr(default, name), value, f"{place}.{name}") for name, value in said.items()}
    return kind(**values)


def _value(default: Any, said: Any, place: str) -> Any:
    if hasattr(default, "__dataclass_fields__"):
        return _filled(type(default), said, place)
    if isinstance(default, bool):
        if not isinstance(said, bool):
            raise Refusal(f"{place} is {said!r}, expected true or false")
        return said
    if isinstance(default, dict):
        if not isinstance(said, dict):
            raise Refusal(f"{place} is {said!r}, expected an object of numbers by name")
        return {name: a_number(value, f"{place}.{name}") for name, value in said.items()}
    if isinstance(default, tuple):
        if default and isinstance(default[0], int):
            whole = a_list(said, place, len(default))
            return tuple(a_whole_number(n, f"{place}[{i}]") for i, n in enumerate(whole))
        return tuple(numbers(said, place, len(default) or None).tolist())
    if isinstance(default, str):
        return a_text(said, place)
    return a_whole_number(said, place) if isinstance(default, int) else a_number(said, place)
