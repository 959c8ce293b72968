"""The whole way from the files of a scan to maps, against the truth of a simulated one."""

import json
from dataclasses import replace

import numpy as np
import pytest

from calibrate.baseline import estimate_baseline
from calibrate.calibration import calibrate
from calibrate.consistency import compare, cosines
from calibrate.grid import map_images
from calibrate.plan import ScanPlan
from calibrate.simulated.frames import Mishaps
from calibrate.simulated_scan import simulate_scan
from calibrate.space import ScanGeometry, at_depth, rays
from calibrate.summary import summarise
from recordings.maps_file import load_maps, save_maps
from recordings.refusal import Refusal

PLAN = ScanPlan(36, 20, first=1)
MISSING = (5, 200, 201, 650)


@pytest.fixture(scope="module")
def simulated():
    scan = simulate_scan(PLAN, rng=np.random.default_rng(4), mishaps=Mishaps(missing=MISSING))
    return scan.patch.collect(), scan.background.collect(), scan.truth


@pytest.fixture(scope="module")
def result(simulated):
    return calibrate(simulated[0], simulated[1])


def cells_of(result):
    return np.searchsorted(PLAN.frames[:, 0], result.positions.frames[:, 0])


def test_centres(simulated, result):
    found = np.stack([result.maps.xs, result.maps.ys], axis=1)
    error = np.linalg.norm(found - simulated[2].centres_px[cells_of(result)], axis=1)
    assert np.median(error) <= 0.3
    assert np.quantile(error, 0.99) <= 1.5


def test_frames_without_patch_are_left_out_and_told(result):
    assert set(result.positions.left_out) >= {f"{frame:04d}" for frame in MISSING}
    assert len(result.positions.left_out) <= len(MISSING) + 5
    assert not set(result.positions.left_out) & set(result.maps.cap_ids)
    assert any("left out" in sentence for sentence in summarise(result, 0.1).sentences)


def test_maps(simulated, result):
    truth = simulated[2].blurred[:, cells_of(result)]
    assert cosines(result.maps.by_zone.astype(float), truth).min() >= 0.995


def test_window_holds_the_pulse(simulated, result):
    first, last = simulated[2].window
    assert first - 4 <= result.window.first <= first + 2
    assert last - 2 <= result.window.last <= last + 4


def test_errors_are_those_of_photon_counting(simulated):
    """Scatter over fresh draws of the same scan, noise of the laser off."""
    plan = ScanPlan(6, 4)
    draws = []
    for seed in range(40):
        rng = np.random.default_rng(0)
        scan = simulate_scan(plan, rng=rng, with_images=False, gain_noise=0)
        patch, background = scan.patch.collect(), scan.background.collect()
        fresh = np.random.default_rng(seed)
        patch = replace(
            patch,
            counts=fresh.poisson(patch.counts).astype(np.uint32),
            patch_px=scan.truth.centres_px,
        )
        background = replace(background, counts=fresh.poisson(background.counts).astype(np.uint32))
        draws.append(calibrate(patch, background, window=scan.truth.window).found)
    scatter = np.std([d.value for d in draws], axis=0, ddof=1)
    stated = np.mean([d.sigma for d in draws], axis=0)
    bright = np.mean([d.value > 5 * d.noise_limit for d in draws], axis=0) == 1
    assert bright.sum() > 20
    assert np.median(scatter[bright] / stated[bright]) == pytest.approx(1, abs=0.1)


def test_maps_survive_the_published_layout(result, tmp_path):
    save_maps(result.maps, tmp_path / "maps.npz")
    with np.load(tmp_path / "maps.npz") as plain:
        assert {"responses", "xs", "ys", "cap_ids", "meta_json"} <= set(plain)
        assert plain["responses"].shape == (3, 3, len(result.maps.xs))
        meta = json.loads(str(plain["meta_json"]))
    assert (meta["bin_min"], meta["bin_max"]) == (result.window.first, result.window.last)
    assert meta["background_subtracted"] is True
    again = load_maps(tmp_path / "maps.npz")
    assert compare(result.maps, again).cosine.min() == pytest.approx(1)
    np.testing.assert_array_equal(again.flags, result.maps.flags)


def test_map_images_are_the_maps(simulated, result):
    images = map_images(result.kernel, result.maps)
    assert images.shape == (9, 120, 212)
    column, row = (np.clip((v / 4).astype(int), 0, n - 1) for v, n in ((result.maps.xs, 212), (result.maps.ys, 120)))
    sampled = images[:, row, column]
    known = ~np.isnan(sampled[0])
    assert known.mean() > 0.9
    assert cosines(np.nan_to_num(sampled)[:, known], result.maps.by_zone[:, known].astype(float)).min() > 0.98


@pytest.fixture(scope="module")
def two_ranges():
    """Scans at two ranges with the patch's centres as the robot knows them."""

    def scan_at(depth, seed):
        scan = simulate_scan(ScanPlan(60, 34), rng=np.random.default_rng(seed), patch_range_m=depth, with_images=False)
        meta = {"patch_radius_px": float(scan.truth.radius_px.mean()), "patch_depth_m": depth}
        patch = scan.patch.collect()
        patch = replace(patch, patch_px=scan.truth.centres_px, meta_json=json.dumps(patch.meta | meta))
        return calibrate(patch, scan.background.collect()), patch

    return {depth: scan_at(depth, seed) for depth, seed in ((0.5, 1), (0.8, 2))}


def test_the_map_at_another_range_follows(two_ranges):
    (near, _), (far, _) = two_ranges[0.5], two_ranges[0.8]
    moved = at_depth(near.maps, 0.8)
    # Read all three at the positions of the far scan.
    shift = {}
    for name, maps in (("moved", moved), ("unmoved", near.maps)):
        nearest = np.hypot(maps.xs[:, None] - far.maps.xs, maps.ys[:, None] - far.maps.ys).argmin(axis=0)
        shift[name] = cosines(maps.by_zone[:, nearest].astype(float), far.maps.by_zone.astype(float))
    assert shift["moved"].mean() > 0.9
    assert shift["unmoved"].mean() < 0.8
    assert rays(near.maps).directions.shape == (len(near.maps.xs), 3)


def test_baseline_from_two_ranges(two_ranges):
    (near, scan), (far, _) = two_ranges[0.5], two_ranges[0.8]
    radii = near.positions.radius_px, far.positions.radius_px
    found = estimate_baseline(near.maps, far.maps, scan.intrinsics, (0.5, 0.8), radii)
    truth = -scan.lidar_from_camera[:3, :3].T @ scan.lidar_from_camera[:3, 3]
    np.testing.assert_allclose(found.origin_m[:2], truth[:2], atol=1.5e-3)


def test_place_in_space(simulated, result):
    assert result.maps.meta["frame"] == "lidar"
    assert ScanGeometry.of(result.maps).depth_m == pytest.approx(0.6)
    bare = replace(
        simulated[0], intrinsics=None, patch_px=np.full((PLAN.count, 2), 5.0) + np.arange(PLAN.count)[:, None]
    )
    flat = calibrate(bare, simulated[1])
    assert flat.maps.meta["frame"] == "image plane"
    assert any("image-plane maps" in sentence for sentence in summarise(flat, 0.1).sentences)


def broken(simulated, **changes):
    return replace(simulated[0], **changes)


@pytest.mark.parametrize(
    ("case", "says"),
    [
        (lambda s: calibrate(replace(s[0], counts=s[0].counts * 0), s[1]), "all are 0"),
        (
            lambda s: calibrate(s[0], replace(s[1], counts=s[1].counts[:-1], timestamp_s=s[1].timestamp_s[:-1])),
            "same captures",
        ),
        (lambda s: calibrate(s[0], s[0]), "identical"),
        (lambda s: calibrate(s[0], replace(s[1], bin_width_s=s[1].bin_width_s * 2)), "bin_width_s"),
        (lambda s: calibrate(s[0], replace(s[1], zone_grid=np.array([1, 9]))), "zone_grid"),
        (lambda s: calibrate(s[0], s[1], plan=ScanPlan(3, 3)), "scan plan: 9 frames"),
        (lambda s: calibrate(replace(s[0], rgb=None), s[1]), "neither rgb"),
        (lambda s: calibrate(known(s), s[1], window=(100, 128)), "window"),
        (
            lambda s: calibrate(known(s), s[1], patch_depth_m=-1.0),
            "patch distance",
        ),
        (lambda s: calibrate(known(s), s[1], baseline_m=(0.1, np.nan, 0)), "baseline"),
    ],
)
def test_what_cannot_be_calibrated_is_refused(simulated, case, says):
    with pytest.raises(Refusal, match=says):
        case(simulated)


def known(simulated):
    """The scan with its centres given, which need not be looked for."""
    return replace(simulated[0], patch_px=simulated[2].centres_px[np.maximum(np.arange(PLAN.count) - PLAN.first, 0)])
