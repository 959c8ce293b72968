"""The nominal model against mitransient, a transient path tracer: how many times as fast, for histograms as near."""

import ctypes.util
import os
import time
from glob import glob

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

SHAPE, BINS, WIDTH_M = (60, 106), 128, 0.03
# Steps of the pulse to a bin, and its standard deviation in bins: what a sensor records is never sharper.
STEPS, SIGMA_BINS = 8, 1.3
MOST_SAMPLES, REFERENCE_SAMPLES = 256, 2048
# What light came by any time may differ by so much of a zone's total: a column of pixels is 0.0094 of it.
TOLERANCE = 0.02
FRAMES = 96


@pytest.fixture(scope="module")
def mitsuba():
    known = [*sorted(glob("/usr/lib/*/libLLVM*19*.so*")), ctypes.util.find_library("LLVM-19")]
    found = os.environ.get("DRJIT_LIBLLVM_PATH") or next(filter(None, known), None)
    if found is None:
        pytest.skip("no LLVM is found, which mitransient runs on: install libllvm19 or set DRJIT_LIBLLVM_PATH")
    os.environ["DRJIT_LIBLLVM_PATH"] = found
    module = pytest.importorskip("mitsuba", reason="mitransient is not installed: pip install .[mitransient]")
    module.set_variant("llvm_ad_mono")
    pytest.importorskip("mitransient", reason="mitransient is not installed: pip install .[mitransient]")
    return module


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


def best(work, rounds):
    """Seconds by the clock, and of the processor: all cores together, whoever else is at work."""
    work()
    times = []
    for _ in range(rounds):
        start = np.array([time.perf_counter(), time.process_time()])
        work()
        times.append(np.array([time.perf_counter(), time.process_time()]) - start)
    return np.min(times, axis=0)


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
    theirs = best(lambda: traced(samples), 40)
    kinds = {
        "one frame": best(lambda: ours(images), 30),
        f"each of {FRAMES} frames": best(lambda: ours(many), 7) / FRAMES,
        "one frame with rays cast": best(lambda: ours(cast()), 15),
    }
    print(
        f"\nmitransient, {samples} samples a pixel: {theirs[0] * 1e3:.1f} ms a frame, error "
        f"{error(recorded(traced(samples))):.4f} of a zone's light; ours, error {own:.4f}"
    )
    for kind, took in kinds.items():
        by_clock, by_processor = theirs / took
        print(f"  {kind} {took[0] * 1e3:.2f} ms: {by_clock:.0f} times as fast, {by_processor:.0f} by processor time")
    assert own < TOLERANCE
    assert theirs[0] > kinds["one frame"][0]
