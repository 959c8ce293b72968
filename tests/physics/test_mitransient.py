"""The nominal model and the second bounce against mitransient, a transient path tracer on Mitsuba 3."""

import numpy as np
import pytest
from scipy.constants import speed_of_light
from scipy.spatial.transform import Rotation

from physics.clock import Clock
from physics.effects.multipath import effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse
from physics.scene.cast import Thing, look
from physics.scene.material import Material
from physics.scene.surfaces import Box, Plane
from recordings.maps import ResponseMaps

from .path_tracer import path_tracer

pytestmark = pytest.mark.slow
WIDTH_M, BINS = 0.06, 60


@pytest.fixture(scope="module")
def mitsuba():
    return path_tracer()


def pinhole(shape):
    focal = 0.72 * shape[1]
    return np.array([[focal, 0, (shape[1] - 1) / 2], [0, focal, (shape[0] - 1) / 2], [0, 0, 1]])


def traced(mitsuba, shape, shapes, bounces, samples, sensor):
    """(P, T) of a point source of intensity 1 beside the camera: radiance times π in each zone, by path length."""
    height, width = shape
    film = {"type": "transient_hdr_film", "width": width, "height": height, "rfilter": {"type": "box"}}
    camera = {
        "type": "perspective",
        "fov": float(np.degrees(2 * np.arctan(0.5 / 0.72))),
        "fov_axis": "x",
        "near_clip": 1e-3,
        "to_world": mitsuba.ScalarTransform4f().look_at([0, 0, 0], [0, 0, 1], [0, -1, 0]),
        "film": {**film, "temporal_bins": BINS, "bin_width_opl": WIDTH_M, "start_opl": 0.0},
    }
    scene = mitsuba.load_dict(
        {
            "type": "scene",
            "integrator": {
                "type": "transient_path",
                "max_depth": bounces + 1,
                "camera_unwarp": False,
                "temporal_filter": "box",
            },
            "sensor": camera,
            "source": {"type": "point", "position": [0, 0, 0], "intensity": {"type": "spectrum", "value": 1.0}},
            **shapes,
        }
    )
    _, transient = mitsuba.render(scene, spp=samples, seed=1)
    image = np.pi * np.array(transient)[..., 0].astype(float)
    return np.einsum("phw,hwt->pt", sensor[0].weights, image)


def matt(reflectance):
    diffuse = {"type": "diffuse", "reflectance": {"type": "spectrum", "value": reflectance}}
    return {"type": "twosided", "material": diffuse}


def sensor_of(shape):
    """One zone that sees everything alike and one that sees more to the right; bins as the path tracer's."""
    x, y = (a.ravel() for a in np.meshgrid([-50.0, 900.0], [-50.0, 530.0]))
    maps = ResponseMaps(np.stack([np.ones(4), (x + 50) / 950])[None], x, y, np.arange(4).astype(str))
    step = WIDTH_M / speed_of_light / 64
    pulse = ImpulseResponse(np.arange(-1, 2) * step, np.array([0, 1.0, 0]))
    return footprints(maps, shape), Clock(WIDTH_M / speed_of_light, BINS, np.zeros(2), pulse)


def apart(found, traced):
    """How far the light that came by any time is apart, by the total; in the zone where it is most."""
    return float((np.abs(np.cumsum(found - traced, axis=1)).max(axis=1) / traced.sum(axis=1)).max())


def test_a_slanted_wall_with_and_without_a_box_before_it(mitsuba):
    shape = (120, 212)
    transform, turned = mitsuba.ScalarTransform4f, Rotation.from_euler("y", 30, degrees=True)
    wall = {
        "type": "rectangle",
        "to_world": transform().translate([0, 0, 1.2]).rotate([0, 1, 0], 20).scale([9, 9, 1]),
        "bsdf": matt(0.5),
    }
    box = {
        "type": "cube",
        "to_world": transform().translate([0.15, 0.05, 0.7]).rotate([0, 1, 0], 30).scale([0.1, 0.12, 0.08]),
        "bsdf": matt(0.8),
    }
    normal = Rotation.from_euler("y", 20, degrees=True).apply([0, 0, -1.0])
    things = [
        Thing(Plane(np.array([0, 0, 1.2]), normal), Material(0.5)),
        Thing(Box(np.array([0.15, 0.05, 0.7]), np.array([0.2, 0.24, 0.16]), turned.as_matrix()), Material(0.8)),
    ]
    matrix, sensor = pinhole(shape), sensor_of(shape)
    v, u = np.mgrid[: shape[0], : shape[1]]
    rays = np.stack([u, v, np.ones(shape)], axis=-1) @ np.linalg.inv(matrix).T
    for seen, shapes in ((things[:1], {"wall": wall}), (things, {"wall": wall, "box": box})):
        view = look(seen, rays, np.eye(4), 0.0)
        light = direct_light(view.depth_m[None], matrix, view.reflectance[None], view.incidence_cosine[None])
        found = ForwardModel(light, *sensor).expected()[0]
        # A column of pixels, one in 212, comes whole before the edge of a bin or after it.
        assert apart(found, traced(mitsuba, shape, shapes, 1, 64, sensor)) < 1e-2


def test_the_second_bounce_of_two_plates(mitsuba):
    """Plates at right angles, all of them in view, as the source lights all around it."""
    shape, transform = (120, 212), mitsuba.ScalarTransform4f
    wall = transform().translate([-0.05, 0, 1]).scale([0.35, 0.2, 1])
    side = transform().translate([0.3, 0, 0.8]).rotate([0, 1, 0], 90).scale([0.2, 0.2, 1])
    shapes = {
        "wall": {"type": "rectangle", "to_world": wall, "bsdf": matt(0.8)},
        "side": {"type": "rectangle", "to_world": side, "bsdf": matt(0.5)},
    }
    matrix, sensor = pinhole(shape), sensor_of(shape)
    v, u = np.mgrid[: shape[0], : shape[1]]
    x, y = (u - matrix[0, 2]) / matrix[0, 0], (v - matrix[1, 2]) / matrix[1, 1]
    on_side = x > 0.3
    depth = np.where(on_side, 0.3 / np.where(on_side, x, 1), 1.0)
    depth[(np.abs(y * depth) > 0.2) | (x * depth < -0.4) | (depth < 0.6)] = np.nan
    model = ForwardModel(direct_light(depth[None], matrix, np.where(on_side, 0.5, 0.8)[None]), *sensor)
    found = model.expected(1, [effect.at(between=1, sensor=0, outside=0)]) - model.expected()
    twice, once = (traced(mitsuba, shape, shapes, bounces, 256, sensor) for bounces in (2, 1))
    # Patches are a tenth off at most; two of a hundred when every pixel is one.
    assert apart(found[0], twice - once) < 0.1
