"""The nominal model against mitransient, a transient path tracer: how many times as fast, for histograms as near."""

import time

import numpy as np
import pytest
from scipy.constants import speed_of_light
from scipy.spatial.transform import Rotation

from physics.clock import Clock
from physics.footprint import footprints
from physics.geometry import pixel_rays
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse
from physics.scene.cast import Thing, look
from physics.scene.material import Material
from physics.scene.surfaces import Box, Plane
from recordings.maps import ResponseMaps
from tests.physics.path_tracer import path_tracer

SHAPE, BINS, WIDTH_M = (60, 106), 128, 0.03
# Steps of the pulse to a bin, and its standard deviation in bins: what a sensor records is never sharper.
STEPS, SIGMA_BINS = 8, 1.3
MOST_SAMPLES, REFERENCE_SAMPLES = 256, 2048
# What light came by any time may differ by so much of a zone's total: a column of pixels is 0.0094 of it.
TOLERANCE = 0.02
FRAMES, ROUNDS = 96, 40


@pytest.fixture(scope="module")
def mitsuba():
    return path_tracer()


def traced_scene(mitsuba, box):
    transform = mitsuba.ScalarTransform4f

    def matt(reflectance):
        diffuse = {"type": "diffuse", "reflectance": {"type": "spectrum", "value": reflectance}}
        return {"type": "twosided", "material": diffuse}

    wall = transform().translate([0, 0, 1.2]).rotate([0, 1, 0], 20).scale([9, 9, 1])
    cube = transform().translate([0.15, 0.05, 0.7]).rotate([0, 1, 0], 30).scale([0.1, 0.12, 0.08])
    film = {"type": "transient_hdr_film", "width": SHAPE[1], "height": SHAPE[0], "rfilter": {"type": "box"}}
    camera = {
        "type": "perspective",
        "fov": float(np.degrees(2 * np.arctan(0.5 / 0.72))),
        "fov_axis": "x",
        "near_clip": 1e-3,
        "to_world": transform().look_at([0, 0, 0], [0, 0, 1], [0, -1, 0]),
        "film": {**film, "temporal_bins": BINS * STEPS, "bin_width_opl": WIDTH_M / STEPS, "start_opl": 0.0},
    }
    path = {"type": "transient_path", "max_depth": 2, "camera_unwarp": False, "temporal_filter": "box"}
    scene = {
        "type": "scene",
        "integrator": path,
        "sensor": camera,
        "source": {"type": "point", "position": [0, 0, 0], "intensity": {"type": "spectrum", "value": np.pi}},
        "wall": {"type": "rectangle", "to_world": wall, "bsdf": matt(0.5)},
    }
    if box:
        scene["box"] = {"type": "cube", "to_world": cube, "bsdf": matt(0.8)}
    return mitsuba.load_dict(scene)


def things(box):
    wall, cube = (Rotation.from_euler("y", angle, degrees=True) for angle in (20, 30))
    seen = [Thing(Plane(np.array([0, 0, 1.2]), wall.apply([0, 0, -1.0])), Material(0.5))]
    if box:
        size = np.array([0.2, 0.24, 0.16])
        seen.append(Thing(Box(np.array([0.15, 0.05, 0.7]), size, cube.as_matrix()), Material(0.8)))
    return seen


def in_turn(works, rounds):
    """(rounds, works, 2) seconds by the clock, and of the processor, all cores together.

    All are timed in every round, so that whoever else is at work is so for all of them.
    """
    taken = np.empty((rounds + 1, len(works), 2))
    for row in taken:
        for cell, work in zip(row, works, strict=True):
            start = np.array([time.perf_counter(), time.process_time()])
            work()
            cell[:] = np.array([time.perf_counter(), time.process_time()]) - start
    return taken[1:]  # The first warms up.


@pytest.mark.parametrize("box", [False, True], ids=["wall", "wall and box"])
def test_times_at_equal_error(mitsuba, box):
    """Frames of 9 zones: the fewest samples a pixel with which the path tracer is as near as we are, or nearer.

    It renders frame by frame. We are given depth images, as the nominal model is, one and many; and once the surfaces.
    """
    rng = np.random.default_rng(0)
    x, y = rng.uniform([0, 0], [848, 480], (400, 2)).T
    maps = ResponseMaps(rng.random((3, 3, 400)) + 0.01, x, y, np.arange(400).astype(str))
    step = WIDTH_M / speed_of_light / STEPS
    steps = np.arange(-6 * STEPS, 6 * STEPS + 1)
    bell = np.exp(-((steps / STEPS / SIGMA_BINS) ** 2) / 2)
    pulse = ImpulseResponse(steps * step, bell / bell.sum())
    where, when = footprints(maps, SHAPE), Clock(WIDTH_M / speed_of_light, BINS, np.zeros(9), pulse)
    focal = 0.72 * SHAPE[1]
    matrix = np.array([[focal, 0, (SHAPE[1] - 1) / 2], [0, focal, (SHAPE[0] - 1) / 2], [0, 0, 1]])
    rays, surfaces, scene = pixel_rays(matrix, SHAPE), things(box), traced_scene(mitsuba, box)
    weights = where.weights.reshape(9, -1).astype(np.float32)

    def cast():
        view = look(surfaces, rays, np.eye(4), 0.0)
        return view.depth_m[None], matrix, view.reflectance[None], view.incidence_cosine[None]

    def ours(images):
        return ForwardModel(direct_light(*images), where, when).expected()[0]

    def traced(samples, seed=1):
        image = np.array(mitsuba.render(scene, spp=samples, seed=seed)[1])
        return weights @ image.reshape(-1, BINS * STEPS)

    def recorded(fine):
        """Histograms (9, bins) of light by steps, through the pulse; left out of the path tracer's time."""
        spread = np.stack([np.convolve(zone, pulse.probability, "same") for zone in fine])
        return spread.reshape(9, BINS, STEPS).sum(axis=2)

    truth, images = recorded(traced(REFERENCE_SAMPLES, seed=2)), cast()

    def error(found):
        return float((np.abs(np.cumsum(found - truth, axis=1)).max(axis=1) / truth.sum(axis=1)).max())

    own = error(ours(images))
    samples = 1
    while samples < MOST_SAMPLES and error(recorded(traced(samples))) > own:
        samples *= 2
    many = tuple(a if a is matrix else np.repeat(a, FRAMES, axis=0) for a in images)
    kinds = {
        "one frame": (lambda: ours(images), 1),
        f"each of {FRAMES} frames": (lambda: ours(many), FRAMES),
        "one frame with rays cast": (lambda: ours(cast()), 1),
    }
    taken = in_turn([lambda: traced(samples), *(work for work, _ in kinds.values())], ROUNDS)
    taken[:, 1:] /= np.array([frames for _, frames in kinds.values()])[:, None]
    theirs, middle = taken[:, 0], np.median(taken, axis=0)
    print(
        f"\nmitransient, {samples} samples a pixel: {1e3 * middle[0, 0]:.1f} ms a frame, at best "
        f"{1e3 * theirs[:, 0].min():.1f}, error {error(recorded(traced(samples))):.4f} of a zone's light; "
        f"ours, error {own:.4f}"
    )
    for i, kind in enumerate(kinds, 1):
        clock, processor = (np.quantile(theirs[:, j] / taken[:, i, j], (0, 0.5, 1)) for j in (0, 1))
        print(
            f"  {kind} {1e3 * middle[i, 0]:.2f} ms, at best {1e3 * taken[:, i, 0].min():.2f}: "
            f"{clock[1]:.0f} times as fast ({clock[0]:.0f} to {clock[2]:.0f}), "
            f"by processor time {processor[1]:.0f} ({processor[0]:.0f} to {processor[2]:.0f})"
        )
    assert own < TOLERANCE
    assert middle[0, 0] > middle[1, 0]
