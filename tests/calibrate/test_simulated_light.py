"""Light of patch and scene against integrals over their surfaces in other coordinates."""

from dataclasses import replace

import numpy as np
import pytest

from calibrate.simulated import scene
from calibrate.simulated.bench import Bench
from calibrate.simulated.disc import disc_nodes, from_discs
from calibrate.simulated.light import Light
from calibrate.simulated.scene import Scene
from physics.optics import tmf882x_optics
from physics.timing import tmf882x_timing
from recordings.refusal import Refusal

BENCH = Bench()
OPTICS = tmf882x_optics(6, np.random.default_rng(0))
TIMING = tmf882x_timing("long", 9)


def in_lidar(points_m):
    """Points in the LiDAR's frame by the matrix the recording carries, and how far away they are."""
    seen = np.concatenate([points_m, np.ones((*points_m.shape[:-1], 1))], axis=-1) @ BENCH.lidar_from_camera.T
    return seen[..., :3], np.linalg.norm(seen[..., :3], axis=-1)


def test_disc_nodes_integrate_polynomials_exactly():
    """Moments of the unit disc, relative to its area."""
    (x, y), weights = disc_nodes()[0].T, disc_nodes()[1]
    for moment, expected in ((1, 1), (x, 0), (x**2, 1 / 4), (x**2 * y**2, 1 / 24), (y**4, 1 / 8), (x**3, 0)):
        assert (weights * moment).sum() == pytest.approx(expected, abs=1e-12)


def test_disc_against_a_fine_grid():
    centres = np.random.default_rng(1).uniform((-0.2, -0.15, 0.58), (0.3, 0.2, 0.62), (12, 3))
    step = BENCH.patch_radius_m / 60
    x, y = np.meshgrid(*2 * [np.arange(-60, 60) * step + step / 2])
    inside = np.hypot(x, y) < BENCH.patch_radius_m
    offsets = np.column_stack([x[inside], y[inside], np.zeros(inside.sum())])
    seen, range_m = in_lidar(centres[:, None] + offsets)
    expected = (OPTICS.response(seen) * 300 / range_m**4).sum(axis=-1) * step**2
    got = from_discs(OPTICS, BENCH, centres)
    assert got == pytest.approx(expected, abs=2e-3 * expected.max())


def test_cloth_against_an_integral_over_its_surface():
    """Flux in and flux back for square pieces of cloth, the arm being far outside the field."""
    away = np.array([[-30.0, -30.0, 0.6]])
    got = Scene(OPTICS, TIMING, BENCH).photons(away)[0]
    depth = BENCH.patch_range_m + scene.CLOTH_BEHIND_M
    piece = 0.01
    x, y = np.meshgrid(np.arange(-1, 1, piece), np.arange(-1, 1, piece))
    seen, range_m = in_lidar(np.stack([x, y, np.full_like(x, depth)], axis=-1))
    cosine = (depth - BENCH.lidar_position_m[2]) / range_m
    light = OPTICS.response(seen) * (0.06 / np.pi) * cosine**2 * piece**2 / range_m**4
    assert got.sum(axis=1) == pytest.approx(light.sum(axis=(1, 2)), rel=0.03)
    mean_range = (light * range_m).sum(axis=(1, 2)) / light.sum(axis=(1, 2))
    bins = (got * (np.arange(128) + 0.5)).sum(axis=1) / got.sum(axis=1) * TIMING.bin_width_s
    pulse_mean = (TIMING.pulse.time_s * TIMING.pulse.probability).sum()
    assert bins - TIMING.time_zero_s - pulse_mean == pytest.approx(2 * mean_range / 299792458, abs=1e-11)


def test_the_arm_hides_cloth_and_comes_before_it():
    positions = np.array([[0.05, 0.02, 0.6], [-30.0, -30.0, 0.6]])
    here, away = Scene(OPTICS, TIMING, BENCH).photons(positions)
    cloth_bin = int((away.sum(axis=0) * np.arange(128)).sum() / away.sum())
    late, early = slice(cloth_bin - 2, 128), slice(0, cloth_bin - 4)
    assert here[4, late].sum() < 0.9 * away[4, late].sum()
    assert here[4, early].sum() > 10 * away[4, early].sum()


def light_of(**changes) -> Light:
    bench = replace(BENCH, **changes)
    return Light(bench, OPTICS, TIMING, signal=0.5, laser_cycles=1_000_000, ambient_per_ns=1e-4)


def test_photons_of_the_patch_are_kept_in_time():
    light, positions = light_of(), np.array([[0.05, 0.06, 0.6], [0.1, -0.1, 0.61]])
    patch = light.discs(positions).T
    with_patch, without = (light.expected(positions, p, np.ones(2)) for p in (patch, 0 * patch))
    assert (with_patch - without).sum(axis=2) == pytest.approx(patch, rel=1e-6)
    ambient = without[:, :, :5].mean(axis=(0, 2))
    assert ambient == pytest.approx(1e6 * 1e-4 * 0.38 * OPTICS.spads.masks.sum(axis=(1, 2)) / 20, rel=1e-3)


def test_crosstalk_is_that_of_the_factory_calibration():
    nothing = np.array([[-30.0, -30.0, 0.6]])
    light = Light(BENCH, OPTICS, TIMING, signal=0.0, laser_cycles=4_096_000, ambient_per_ns=0.0)
    got = light.expected(nothing, np.zeros((1, 9)), np.ones(1))[0].sum(axis=1)
    assert got == pytest.approx([7465, 3709, 4198, 9668, 6056, 3764, 7144, 3972, 4490], rel=1e-6)


def test_signal_is_stated_for_a_response_of_one():
    """A point patch on the LiDAR's axis through a lens that loses nothing, under a flood without seam."""
    light = light_of()
    along = np.linalg.inv(BENCH.lidar_from_camera) @ [0.03, 0.048, 0.6, 1]
    seen, range_m = in_lidar(along[:3])
    expected = 0.5e6 * OPTICS.response(seen) * (0.6 / range_m) ** 4
    assert light.points(along[None, :3])[:, 0] == pytest.approx(expected, rel=1e-9)


def test_twice_as_far_is_a_sixteenth():
    direction = np.array([0.08, 0.1, 1.0])
    lidar = np.array(BENCH.lidar_position_m)
    near, far = light_of().points(lidar + np.array([[0.5], [1.0]]) * direction).T
    assert near / far == pytest.approx(np.full(9, 16.0))


def test_window_holds_the_patch_and_little_else():
    light, positions = light_of(), np.array([[0.05, 0.06, 0.6], [0.1, -0.1, 0.61]])
    discs = light.discs(positions)
    first, last = light.window(positions, discs)
    clean = light.expected(positions, discs.T, np.ones(2)) - light.expected(positions, 0 * discs.T, np.ones(2))
    held = clean[:, :, first : last + 1].sum(axis=2)
    assert (held > 0.95 * discs.T).all()
    assert last - first < 9


def test_a_patch_beyond_the_histogram_is_refused():
    short = tmf882x_timing("short", 9)
    bench = BENCH.at_range(3.0)
    light = Light(bench, OPTICS, short, signal=0.5, laser_cycles=1000, ambient_per_ns=0.0)
    positions = np.array([[0.0, 0.0, 3.0]])
    with pytest.raises(Refusal, match=r"patch at 3\.0 m returns after the last of 128 bins of short range"):
        light.window(positions, light.discs(positions))
