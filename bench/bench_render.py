"""The nominal model: how fast, against numpy doing the same sum and against what memory allows; and how it grows."""

import subprocess
import sys
import time
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from scipy.constants import speed_of_light

from physics.arrivals import arrivals
from physics.clock import Clock
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import tailed_pulse
from recordings.maps import ResponseMaps

SMALL, LARGE, BINS = (60, 106), (480, 848), 128
LIMIT_96_S, LIMIT_LARGE_S, LIMIT_MIB = 0.1, 0.012, 2048
WIDTH_S = 0.26e-9
PULSE = tailed_pulse(0.1e-9, 0.2e-9, 0.3e-9, 0.15, step_s=WIDTH_S / 32)

LONG = """
import sys
import numpy as np
from physics.presets import preset
from physics.scene.view import View, Views
from physics.simulate import simulate
from recordings.files import save
from recordings.maps import ResponseMaps
rng = np.random.default_rng(0)
x, y = rng.uniform([0, 0], [848, 480], (3600, 2)).T
maps = ResponseMaps(rng.random((3, 3, 3600)), x, y, np.arange(3600).astype(str))
depth = (1 + 0.1 * rng.random((60, 106))).astype(np.float32)
views = (View(0.1 * i, depth + np.float32(1e-5 * i)) for i in range(10_000))
scene = Views(np.array([[76.5, 0, 52.5], [0, 76.5, 29.5], [0, 0, 1]]), views, 10_000)
save(simulate(scene, maps, preset("tmf8828-3x3-wide-long"), rng)[0], sys.argv[1])
print(int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0]) / 1024)
"""


def zones(rows, columns):
    """Maps with a response everywhere, as published ones have: every pixel counts for every zone."""
    rng = np.random.default_rng(0)
    x, y = rng.uniform([0, 0], [848, 480], (3600, 2)).T
    return ResponseMaps(rng.random((rows, columns, 3600)) + 0.01, x, y, np.arange(3600).astype(str))


def scene(frames, shape):
    """A slanted wall that comes nearer, with the noise of a depth camera; cosine and reflectance known."""
    rng = np.random.default_rng(1)
    v, u = np.mgrid[: shape[0], : shape[1]] / shape[1]
    wall = 0.8 + 0.3 * u + 0.1 * v
    depth = wall - 0.2 * np.linspace(0, 1, frames)[:, None, None] + rng.normal(0, 0.002, (frames, *shape))
    focal = 0.72 * shape[1]
    intrinsics = np.array([[focal, 0, shape[1] / 2], [0, focal, shape[0] / 2], [0, 0, 1]])
    reflectance, cosine = rng.uniform(0.3, 1, (2, frames, *shape)).astype(np.float32)
    return depth.astype(np.float32), intrinsics, reflectance, cosine


def clock(count):
    return Clock(WIDTH_S, BINS, 3.7e-9 + np.linspace(0, 50e-12, count), PULSE)


def rendered(seen, where, when):
    return ForwardModel(direct_light(*seen), where, when, 10.0).expected(30.0)


def in_numpy(seen, where, when):
    """The same sum with numpy: for each frame the share of every pixel in every bin, then a matrix product."""
    light = direct_light(*seen)
    weights = where.weights.reshape(len(where.weights), -1)
    edges = np.arange(BINS + 1) * WIDTH_S
    out = np.empty((light.frames, len(weights), BINS))
    for f in range(light.frames):
        travel = 2 * light.returns[0].range_m[f].ravel() / speed_of_light
        strength = light.returns[0].strength[f].ravel()
        for p, zero in enumerate(when.time_zero_s):
            out[f, p] = (weights[p] * strength) @ np.diff(when.pulse.cumulative(edges - (zero + travel)[:, None]))
    return 30 * out + 10


def best(work, rounds=7, now=time.perf_counter):
    work()
    times = []
    for _ in range(rounds):
        start = now()
        work()
        times.append(now() - start)
    return min(times)


@pytest.mark.benchmark(group="96 frames of 106 x 60, 9 zones, 128 bins")
def test_96_frames(benchmark):
    seen, where, when = scene(96, SMALL), footprints(zones(3, 3), SMALL), clock(9)
    benchmark.pedantic(rendered, (seen, where, when), rounds=15, warmup_rounds=2)
    few = tuple(a[:2] if a.ndim == 3 else a for a in seen)
    peer = best(lambda: in_numpy(few, where, when), 2) * 48
    np.testing.assert_allclose(rendered(few, where, when), in_numpy(few, where, when), rtol=1e-5)
    print(f"\n{peer / benchmark.stats['min']:.0f} times as fast as the sum in numpy ({peer:.2f} s)")
    assert benchmark.stats["min"] <= LIMIT_96_S


@pytest.mark.benchmark(group="a frame of 848 x 480, 9 zones, 128 bins")
@pytest.mark.parametrize("incidence", ["given", "from depth"])
def test_full_resolution(benchmark, incidence):
    seen, where, when = scene(1, LARGE), footprints(zones(3, 3), LARGE), clock(9)
    _ = where.seen
    seen = seen if incidence == "given" else seen[:3]
    benchmark.pedantic(rendered, (seen, where, when), rounds=30, warmup_rounds=3)
    assert benchmark.stats["min"] <= LIMIT_LARGE_S


@njit(nogil=True)
def triad(a, b, c):
    for i in range(a.size):
        a[i] = b[i] + 3.0 * c[i]


def test_what_binds_the_kernel():
    """The kernel on one core against a pass through the bytes it must read."""
    seen, where, when = scene(1, LARGE), footprints(zones(3, 3), LARGE), clock(9)
    light = direct_light(*seen)
    _ = where.seen
    from physics.knots import splat_knots

    pixels, weights = where.seen[0]
    lattice = when.lattice
    out = np.zeros((1, 9, lattice.size))
    direct = light.returns[0]
    offset = (when.time_zero_s - lattice.first_s)[None] / lattice.step_s
    arguments = (direct.range_m.reshape(1, -1), direct.strength.reshape(1, -1), pixels, weights, offset)
    took = best(lambda: splat_knots(*arguments, 2 / speed_of_light / lattice.step_s, out))
    read = direct.range_m[0].nbytes + direct.strength[0].nbytes + pixels.nbytes + weights.nbytes
    a, b, c = np.ones((3, 10_000_000))
    bandwidth = 3 * a.nbytes / best(lambda: triad(a, b, c))
    updates = 2 * len(pixels) * 9
    print(
        f"\n{took * 1e3:.2f} ms for {read / 1e6:.1f} MB: {took * bandwidth / read:.1f} times the memory bound at "
        f"{bandwidth / 1e9:.1f} GB/s; {took / updates * 1e9:.2f} ns for each of {updates / 1e6:.1f} million additions"
    )


def in_batches(seen, where, when, batches):
    """A long recording, a batch of frames at a time as `simulate` does, so that memory does not grow with it."""
    for _ in range(batches):
        rendered(seen, where, when)


@pytest.mark.parametrize("what", ["frames", "pixels", "zones"])
def test_cost_is_linear(what):
    """Over two decades: the exponent of time over size, whole and by decade, from sizes that fixed costs do not rule.

    Below them, time is that of a call. It is printed, as the time of the smallest size there is. Time is that of the
    processor, all cores together, which does not depend on how many of them help or on who else is at work.
    """
    times = {}
    for size in (0, 1, 10, 100):
        frames, batches, shape, rows = 4, 1, SMALL, 9
        if what == "frames":
            frames, batches = (1, 1) if size == 0 else (25, 4 * size)
        elif what == "pixels":
            frames, shape = 1, (4, 7) if size == 0 else (int(120 * size**0.5), int(212 * size**0.5))
        else:
            rows = 9 * size or 1
        seen, where, when = scene(frames, shape), footprints(zones(rows, 1), shape), clock(rows)
        _ = where.seen, when.lattice
        amount = {"frames": frames * batches, "pixels": shape[0] * shape[1], "zones": rows}[what]
        work = partial(in_batches, seen, where, when, batches)
        times[amount] = best(work, 2 if size == 100 else 4, time.process_time)
    sizes = list(times)[1:]
    steps = [np.log(times[b] / times[a]) / np.log(b / a) for a, b in pairwise(sizes)]
    whole = np.log(times[sizes[-1]] / times[sizes[0]]) / np.log(sizes[-1] / sizes[0])
    print(
        f"\n{what}: "
        + ", ".join(f"{size} -> {took * 1e3:.2f} ms" for size, took in times.items())
        + f"; exponent {whole:.2f} from {sizes[0]} on, by decade "
        + ", ".join(f"{step:.2f}" for step in steps)
    )
    assert max(whole, *steps) < 1.15


def test_ten_thousand_frames_in_bounded_memory(tmp_path):
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", LONG, tmp_path / "long.rrd"], capture_output=True, text=True, check=True
    )
    peak = float(done.stdout)
    print(f"\n10,000 frames to .rrd: {time.perf_counter() - start:.1f} s, peak resident memory {peak:.0f} MiB")
    assert peak < LIMIT_MIB


def test_parts():
    """One frame, by the two steps of the kernel."""
    seen, where, when = scene(96, SMALL), footprints(zones(3, 3), SMALL), clock(9)
    light = direct_light(*seen)
    made = arrivals(light, where, when)
    parts = [best(lambda: direct_light(*seen)), best(lambda: arrivals(light, where, when)), best(made.binned)]
    print("\n96 frames: light {:.1f} ms, arrivals {:.1f} ms, bins {:.1f} ms".format(*(1e3 * t for t in parts)))
