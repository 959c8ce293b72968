"""A rig drawn at random for a sealed recording: scene, maps, sensor."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from physics.geometry import pixel_rays
from physics.optics import tmf882x_optics
from physics.pulse_shape import PulseShape, Tail
from physics.scene.camera import pinhole
from physics.scene.cast import Thing, look
from physics.scene.material import Material
from physics.scene.surfaces import Box, Plane, Sphere
from physics.scene.view import View, Views
from physics.sensor import SensorModel
from recordings.maps import ResponseMaps

SIZE = (106, 60)
FULL_SIZE = (848, 480)
HORIZONTAL_DEG = 69.4
FRAME_S = 1 / 15


@dataclass(frozen=True, eq=False)
class Rig:
    """views: what there is to see. maps: where zones look. sensor: how they count. peak: counts in the fullest bin."""

    views: Views
    maps: ResponseMaps
    sensor: SensorModel
    peak: float


def draw_rig(rng: np.random.Generator, frames: int) -> Rig:
    """A scene in which things and the sensor move, a TMF8828 with its own texture, a pulse and a brightness."""
    width = rng.uniform(0.1e-9, 0.4e-9)
    core = rng.uniform(0.7, 1.6, 2) * width
    pulse = PulseShape(core[0], core[1], (Tail(rng.uniform(1, 4) * width, rng.uniform(0.05, 0.3)),))
    sensor = SensorModel(
        name="drawn", mode="drawn", zone_grid=(3, 3), bins=128, bin_width_s=width,
        time_zero_s=rng.uniform(10, 18) * width, pulse=pulse, laser_cycles=int(10 ** rng.uniform(5.3, 6.5)),
        background_counts=rng.uniform(1, 25, 9),
    )  # fmt: skip
    reach = 0.8 * (128 - 25) * width * 1.5e8
    return Rig(draw_views(rng, frames, min(reach, 4.0)), draw_maps(rng), sensor, float(10 ** rng.uniform(3, 4)))


def draw_maps(rng: np.random.Generator) -> ResponseMaps:
    """Maps of a TMF8828 in its wide 3 × 3 mode on a scan of 48 × 27 points, as precise as files hold them.

    In a grid both diagonals of a cell are as good for reading it; rounding decides, and would choose others.
    """
    x, y = np.float32(np.meshgrid(np.linspace(20, 828, 48), np.linspace(15, 465, 27)))
    matrix = pinhole(FULL_SIZE, HORIZONTAL_DEG)
    rays = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=-1) @ np.linalg.inv(matrix).T
    response = np.float32(1e5 * tmf882x_optics(6, rng).response(rays))
    meta = '{"image_size": [848, 480]}'
    return ResponseMaps(response.reshape(3, 3, -1), x.ravel(), y.ravel(), np.arange(x.size).astype(str), meta)


def draw_views(rng: np.random.Generator, frames: int, reach: float) -> Views:
    """Walls, a box and perhaps a sphere, seen by a sensor that sways; nothing farther than `reach` metres."""
    matrix = pinhole(SIZE, HORIZONTAL_DEG)
    rays = pixel_rays(matrix, (SIZE[1], SIZE[0]))
    wall = rng.uniform(0.5, 0.8) * reach
    tilt = rng.uniform(-0.35, 0.35, 2)
    walls = [Thing(Plane(np.array([0, 0, wall]), np.array([tilt[0], tilt[1], -1.0])), _material(rng))]
    if rng.random() < 0.5:
        side = rng.choice([-1.0, 1.0])
        walls.append(Thing(Plane(np.array([side * wall * 0.6, 0, 0]), np.array([-side, 0, 0.1])), _material(rng)))
    if rng.random() < 0.4:
        walls.append(Thing(Plane(np.array([0, wall * 0.4, 0]), np.array([0.0, -1, 0])), _material(rng)))
    size = rng.uniform(0.12, 0.35, 3) * wall
    near, turn = rng.uniform(0.3, 0.6) * wall, Rotation.random(random_state=rng).as_matrix()
    box, ball = _material(rng), _material(rng)
    has_ball, radius = rng.random() < 0.4, rng.uniform(0.06, 0.15) * wall
    sway, pace, phase = rng.uniform(0.02, 0.25) * wall, rng.uniform(0.5, 3, 4), rng.uniform(0, 6.28, 4)
    texture = _texture(rng)

    def views():
        for i in range(frames):
            angle = phase + 2 * np.pi * pace * i / frames
            place = np.array([0.8 * near * np.sin(angle[0]) * 0.5, 0.3 * near * np.sin(angle[1]), near])
            things = [*walls, Thing(Box(place, size, turn), box)]
            if has_ball:
                things.append(Thing(Sphere(np.array([-place[0], 0.1 * near, 1.2 * near]), radius), ball))
            pose = np.eye(4)
            pose[:3, :3] = Rotation.from_euler("xy", 0.1 * np.sin(angle[2:])).as_matrix()
            pose[:3, 3] = [0, 0, 0.5 * sway * np.sin(angle[3])]
            view = look(things, rays, pose, i * FRAME_S)
            yield View(
                view.timestamp_s, view.depth_m, view.reflectance * texture, view.incidence_cosine, camera_pose=pose
            )

    return Views(matrix, views(), frames, meta={"calibration_range_m": 0.6})


def _material(rng: np.random.Generator) -> Material:
    """Something matt."""
    return Material(float(rng.uniform(0.2, 1.0)))


def _texture(rng: np.random.Generator) -> np.ndarray:
    """(H, W) smooth factor between 0.5 and 1."""
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] / 12.0
    waves = sum(np.sin(a * u + b * v + c) for a, b, c in rng.uniform(-1, 1, (4, 3)) * [1, 1, 3])
    return (0.75 + 0.06 * waves).astype(np.float32)
