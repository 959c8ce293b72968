"""Patch centres in 848 x 480 frames against Hough circles on whole frames and against the published recipe."""

import cv2
import numpy as np
import pytest

from calibrate.patch_track import find_patches
from calibrate.plan import ScanPlan
from calibrate.simulated_scan import simulate_scan

PLAN = ScanPlan(40, 23)
SOME = range(0, PLAN.count, 10)  # of the frames, for the peers, which look at one at a time
EXPECTED_PX, TOLERANCE_PX, HALF_PX = 17.75, 8, 90


@pytest.fixture(scope="module")
def scan():
    simulated = simulate_scan(PLAN, rng=np.random.default_rng(0))
    return simulated.patch.collect().rgb, simulated.truth.centres_px


def whole_frames(frames):
    """Hough circles on each whole frame, the strongest one taken."""
    found = np.full((len(SOME), 2), np.nan)
    for i, k in enumerate(SOME):
        grey = cv2.medianBlur(cv2.cvtColor(frames[k], cv2.COLOR_RGB2GRAY), 5)
        circles = cv2.HoughCircles(grey, cv2.HOUGH_GRADIENT, 1.1, 20, param1=140, param2=22, minRadius=10, maxRadius=26)
        if circles is not None:
            found[i] = circles[0, 0, :2]
    return found


def published_recipe(frames, seeds):
    """Crop about a seed within a few pixels, CLAHE, bilateral filter, Hough circles, best by radius and distance.

    The seeds stand in for the four clicked corners; the recipe's own edge support needs a second pass, left out here.
    """
    found = np.full((len(SOME), 2), np.nan)
    for i, k in enumerate(SOME):
        x, y = np.rint(seeds[k]).astype(int)
        left, top = max(x - HALF_PX, 0), max(y - HALF_PX, 0)
        grey = cv2.cvtColor(frames[k][top : y + HALF_PX, left : x + HALF_PX], cv2.COLOR_RGB2GRAY)
        grey = cv2.bilateralFilter(cv2.createCLAHE(2.0, (8, 8)).apply(grey), 7, 50, 50)
        circles = cv2.HoughCircles(grey, cv2.HOUGH_GRADIENT, 1.1, 10, param1=140, param2=22, minRadius=10, maxRadius=26)
        if circles is not None:
            off = np.hypot(circles[0, :, 0] + left - seeds[k, 0], circles[0, :, 1] + top - seeds[k, 1])
            score = -0.06 * np.abs(circles[0, :, 2] - EXPECTED_PX) - 0.0025 * off
            found[i] = circles[0, score.argmax(), :2] + (left, top)
    return found


def report(name, found, truth, frames, benchmark):
    off = np.hypot(*(found - truth).T)
    known = ~np.isnan(off)
    rate = frames / benchmark.stats.stats.median
    print(
        f"\n{name}: {rate:.0f} frames/s, {known.sum()} of {len(off)} found, "
        f"error median {np.median(off[known]):.3f} px, 99 % {np.quantile(off[known], 0.99):.2f} px"
    )


@pytest.mark.benchmark(group="patch centres, frames of 848 x 480 with decoding")
def test_find_patches(benchmark, scan):
    frames, truth = scan
    track = benchmark.pedantic(find_patches, (frames, PLAN), rounds=3, warmup_rounds=1)
    report("here", np.stack([track.x_px, track.y_px], axis=1), truth, len(frames), benchmark)


@pytest.mark.benchmark(group="patch centres, frames of 848 x 480 with decoding")
def test_hough_on_whole_frames(benchmark, scan):
    frames, truth = scan
    found = benchmark.pedantic(whole_frames, (frames,), rounds=1)
    report("Hough circles on whole frames", found, truth[list(SOME)], len(SOME), benchmark)


@pytest.mark.benchmark(group="patch centres, frames of 848 x 480 with decoding")
def test_published_recipe(benchmark, scan):
    frames, truth = scan
    seeds = truth + np.random.default_rng(0).uniform(-4, 4, truth.shape)
    found = benchmark.pedantic(published_recipe, (frames, seeds), rounds=1)
    report("published recipe", found, truth[list(SOME)], len(SOME), benchmark)
