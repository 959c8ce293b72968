"""A simulated scan gives back its truth by the published formula, and obeys counting statistics and parallax."""

import json

import cv2
import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from calibrate.plan import ScanPlan
from calibrate.simulated.bench import Bench
from calibrate.simulated.frames import Mishaps
from calibrate.simulated_scan import simulate_scan
from physics.optics import tmf882x_optics
from recordings.refusal import Refusal

PLAN = ScanPlan(40, 23)


def scan(plan=PLAN, seed=3, **options):
    return simulate_scan(plan, rng=np.random.default_rng(seed), **({"with_images": False} | options))


def counts(stream):
    return np.stack([frame["counts"] for frame in stream.frames]).astype(np.int64)


def published_response(simulated, window):
    """R_p(u_k) = max over the window of [patch - background], floored at 0 (Behari & Raskar 2026, Eq. 2)."""
    first, last = window
    difference = counts(simulated.patch) - counts(simulated.background)
    return np.maximum(difference[:, :, first : last + 1].max(axis=2), 0).T


def cosine(a, b):
    return (a * b).sum(axis=1) / np.sqrt((a * a).sum(axis=1) * (b * b).sum(axis=1))


@pytest.mark.parametrize(("mode", "window"), [("long", (15, 35)), ("short", (45, 75))])
def test_the_published_formula_finds_the_truth(mode, window):
    simulated = scan(mode=mode)
    response = published_response(simulated, window)
    assert (cosine(response, simulated.truth.blurred) > 0.995).all()
    assert response.max() > (5e5 if mode == "long" else 8e4)


def test_truths_differ_by_the_blur_of_the_patch():
    truth = scan().truth
    assert (cosine(truth.points, truth.blurred) < 0.995).all()
    assert (cosine(truth.points, truth.blurred) > 0.9).all()
    # Blurring moves light about; over the whole grid it neither makes nor loses any.
    assert truth.blurred.sum(axis=1) == pytest.approx(truth.points.sum(axis=1), rel=0.02)


def test_photons_are_those_of_the_truth_within_counting_error():
    simulated = scan(gain_noise=0.0, ambient_per_ns=0.0)
    lit, dark = counts(simulated.patch).sum(axis=2), counts(simulated.background).sum(axis=2)
    pull = (lit - dark - simulated.truth.blurred.T) / np.sqrt(lit + dark)
    assert abs(pull.mean()) < 4 / np.sqrt(pull.size)
    assert pull.std() == pytest.approx(1, abs=0.03)


def test_gain_noise_is_one_factor_per_frame():
    simulated = scan(ScanPlan(1, 1, repeats=400), gain_noise=0.01, signal=5.0)
    total = counts(simulated.patch).sum(axis=2).astype(float)
    assert total[:, 4].std() / total[:, 4].mean() == pytest.approx(0.01, rel=0.15)
    assert np.corrcoef(total[:, 4], total[:, 1])[0, 1] > 0.9


def test_passes_are_independent_draws_of_the_same_background():
    simulated = scan(signal=0.0, gain_noise=0.0)
    lit, dark = counts(simulated.patch), counts(simulated.background)
    assert not np.array_equal(lit, dark)
    pull = (lit - dark) / np.sqrt(np.maximum(lit + dark, 1))
    assert pull.std() == pytest.approx(1, abs=0.01)
    assert abs(np.corrcoef(pull[:, 4].ravel(), pull[:, 5].ravel())[0, 1]) < 0.02


def test_same_generator_same_scan_in_whatever_order_it_is_read():
    first, again = scan(ScanPlan(6, 5), with_images=True), scan(ScanPlan(6, 5), with_images=True)
    dark = counts(first.background)
    lit = list(first.patch.frames)
    lit_again = list(again.patch.frames)
    assert np.array_equal(dark, counts(again.background))
    assert all(np.array_equal(a["counts"], b["counts"]) for a, b in zip(lit, lit_again, strict=True))
    assert all(a["rgb"] == b["rgb"] for a, b in zip(lit, lit_again, strict=True))
    other = scan(ScanPlan(6, 5), seed=4)
    assert not np.array_equal(dark, counts(other.background))


def test_repeats_rest_and_frames_before_the_grid_wait():
    simulated = scan(ScanPlan(4, 3, repeats=3, first=2), gain_noise=0.0)
    assert simulated.patch.count == simulated.background.count == 38
    total = counts(simulated.patch).sum(axis=2).astype(float)
    cells = np.concatenate([[0, 0], np.repeat(np.arange(12), 3)])
    expected = counts(simulated.background).sum(axis=2) + simulated.truth.blurred[:, cells].T
    assert np.abs((total - expected) / np.sqrt(2 * expected)).max() < 6


def test_a_missing_patch_sends_no_light():
    gone = frozenset({5, 7})
    simulated = scan(ScanPlan(5, 5), mishaps=Mishaps(missing=gone), gain_noise=0.0)
    lit, dark = counts(simulated.patch).sum(axis=(1, 2)), counts(simulated.background).sum(axis=(1, 2))
    patch = (lit - dark) / np.sqrt(lit + dark)
    assert all(abs(patch[frame]) < 5 for frame in gone)
    assert patch[12] > 100


def test_frames_are_jpeg_of_the_patch_where_the_truth_says():
    simulated = scan(ScanPlan(5, 3), with_images=True)
    for frame, (x, y) in zip(simulated.patch.frames, simulated.truth.centres_px.round().astype(int), strict=True):
        image = cv2.imdecode(np.frombuffer(frame["rgb"], np.uint8), cv2.IMREAD_GRAYSCALE)
        assert image.shape == (480, 848)
        assert image[max(y - 4, 0) : y + 5, max(x - 4, 0) : x + 5].min() > 120
    assert "rgb" not in next(simulated.background.frames)


def test_both_passes_are_recordings():
    simulated = scan(ScanPlan(4, 3), with_images=True)
    lit, dark = simulated.patch.collect(), simulated.background.collect()
    assert lit.counts.shape == dark.counts.shape == (12, 9, 128)
    assert lit.counts.dtype == np.uint32
    assert dark.timestamp_s[0] > lit.timestamp_s[-1]
    assert lit.rgb.shape == (12, 480, 848, 3)
    assert ScanPlan.from_meta(lit.meta) == ScanPlan(4, 3)
    assert lit.meta["patch_depth_m"] == 0.6
    assert json.loads(dark.meta_json)["scan_pass"] == "background"


def test_other_zone_layouts():
    simulated = scan(ScanPlan(12, 8), optics=tmf882x_optics(7), mode="short")
    assert simulated.patch.static["zone_grid"].tolist() == [4, 4]
    assert next(simulated.patch.frames)["counts"].shape == (16, 128)


def centroid_px(truth):
    # Squared, so that the pedestal of stray light, which reaches beyond the image, has no weight.
    bright = np.square(truth.points)
    return bright @ truth.centres_px / bright.sum(axis=1, keepdims=True)


def test_the_footprint_moves_with_range_as_the_baseline_says():
    """Parallax: the LiDAR, in the camera's plane, sees one direction at f b (1/Z1 - 1/Z2) pixels' distance."""
    bench = Bench(tilt_deg=(0, 0), roll_deg=0, distortion=0, jitter_m=0, lidar_position_m=(0.06, 0.02, 0))
    near, far = (scan(ScanPlan(120, 68), bench=bench, patch_range_m=z).truth for z in (0.5, 0.8))
    expected = 612 * np.array([0.06, 0.02]) * (1 / 0.5 - 1 / 0.8)
    # Only the middle row of zones: the others are cut by the image's border.
    moved = (centroid_px(near) - centroid_px(far))[3:6]
    assert moved == pytest.approx(np.tile(expected, (3, 1)), abs=0.5)
    # Patch and range: 1/16 at twice the distance, here (0.5 / 0.8)^4.
    brightness = far.blurred[4].max() / near.blurred[4].max()
    assert brightness == pytest.approx((0.5 / 0.8) ** 4, rel=0.15)


def test_zones_lie_where_the_published_maps_have_them(published_maps):
    """Each simulated zone resembles the published zone of the same number most: rows, columns and mirror agree."""
    name = "spad_calib_3x3_longrange_bins15_35.npz"
    published = np.load(published_maps / name)["responses"].reshape(9, -1)
    simulated = scan(ScanPlan(80, 45)).truth.blurred
    units = [maps / np.linalg.norm(maps, axis=1, keepdims=True) for maps in (simulated, published)]
    likeness = units[0] @ units[1].T
    assert linear_sum_assignment(-likeness)[1].tolist() == list(range(9))
    assert np.diag(likeness).min() > 0.75
    assert (likeness - np.eye(9)).max() < 0.5


@pytest.mark.parametrize(
    "wrong", [{"signal": -1.0}, {"gain_noise": np.nan}, {"ambient_per_ns": np.inf}, {"laser_cycles": 0}]
)
def test_numbers_that_make_no_scan_are_refused(wrong):
    with pytest.raises(Refusal, match=f"simulated scan: {next(iter(wrong))} is"):
        scan(**wrong)
