"""Patch centres of a scan: ours, circles found in whole frames, and the published recipe, by speed and by error."""

import cv2
import numpy as np
import pytest

from calibrate.patch_track import find_patches
from calibrate.plan import ScanPlan
from calibrate.simulated.bench import Bench
from calibrate.simulated.frames import FrameRenderer, encode_jpeg
from recordings.encoded import EncodedFrames

PLAN = ScanPlan(40, 30)
RADIUS, TOLERANCE, HALF = 17.75, 8.0, 90


@pytest.fixture(scope="module")
def scan():
    """JPEG frames of 848 × 480 with centres down to 5 px from the border, and the true centres."""
    bench = Bench(corners_px=(12.0, 464.0, 838.0, 14.0))
    arm, still, moving = np.random.default_rng(0).spawn(3)
    positions = bench.patch_positions(PLAN, arm)
    renderer = FrameRenderer(bench, still)
    blobs = [encode_jpeg(renderer.render(position, k, moving)) for k, position in enumerate(positions)]
    return blobs, bench.project(positions)


def circles_in_whole_frames(frames):
    """The strongest circle of about the right radius in each frame."""
    centres = np.full((len(frames), 2), np.nan)
    for k, frame in enumerate(frames):
        grey = cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)
        low, high = int(RADIUS - TOLERANCE), int(RADIUS + TOLERANCE) + 1
        found = cv2.HoughCircles(grey, cv2.HOUGH_GRADIENT, 1.1, 30, None, 140, 22, low, high)
        if found is not None:
            centres[k] = found.reshape(-1, found.shape[-1])[0, :2]
    return centres


def published_recipe(frames, corners):
    """Region around a bilinear grid from four clicked corners; CLAHE, bilateral, Canny, Hough, best scored circle."""
    u, v = (PLAN.cells / (PLAN.columns - 1, PLAN.rows - 1)).T[..., None]
    seeds = (1 - v) * ((1 - u) * corners[0] + u * corners[1]) + v * ((1 - u) * corners[2] + u * corners[3])
    around = 2 * np.pi * np.arange(360) / 360
    centres = seeds.copy()
    for k, frame in enumerate(frames):
        left, top = np.maximum(seeds[k].round().astype(int) - HALF, 0)
        crop = frame[top : int(seeds[k, 1]) + HALF + 1, left : int(seeds[k, 0]) + HALF + 1]
        grey = cv2.createCLAHE(2.0, (8, 8)).apply(cv2.cvtColor(crop, cv2.COLOR_RGB2GRAY))
        grey = cv2.bilateralFilter(grey, 7, 50, 50)
        middle = np.median(grey)
        edges = cv2.Canny(grey, 0.66 * middle, min(1.33 * middle, 255))
        edges = cv2.dilate(edges, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3)))
        apart = max(10, min(grey.shape) / 2)
        found = cv2.HoughCircles(grey, cv2.HOUGH_GRADIENT, 1.1, apart, None, 140, 22, 10, 26)
        near = cv2.dilate(edges, np.ones((3, 3), np.uint8)) > 0
        best = -np.inf
        for x, y, radius in [] if found is None else found.reshape(-1, found.shape[-1])[:, :3]:
            column = (x + radius * np.cos(around)).round().astype(int)
            row = (y + radius * np.sin(around)).round().astype(int)
            inside = (column >= 0) & (row >= 0) & (column < near.shape[1]) & (row < near.shape[0])
            support = near[row[inside], column[inside]].sum() / 360
            distance = np.hypot(*(seeds[k] - (left + x, top + y)))
            score = support - 0.06 * abs(radius - RADIUS) - 0.0025 * distance
            if score > best:
                best, centres[k] = score, (left + x, top + y)
    return centres


def report(benchmark, centres, truth):
    """Frames a second, frames without a centre, and errors in px: median, 95 %, 99 %, largest, and at the border."""
    error = np.hypot(*(centres - truth).T)
    border = np.minimum(truth, (847, 479) - truth).min(axis=1) < RADIUS
    found = np.isfinite(error)
    benchmark.extra_info |= {
        "frames_per_s": round(len(error) / benchmark.stats.stats.mean, 1),
        "not_found": int((~found).sum()),
        "error_px": np.quantile(error[found], [0.5, 0.95, 0.99, 1]).round(3).tolist(),
        "border_error_px": np.quantile(error[found & border], [0.5, 0.95, 1]).round(3).tolist(),
    }
    print(benchmark.name, benchmark.extra_info)
    return error


@pytest.mark.benchmark(group="patch centres of 1200 frames")
def test_find_patches(benchmark, scan):
    blobs, truth = scan
    track = benchmark.pedantic(find_patches, (EncodedFrames.of(blobs), PLAN), rounds=3, warmup_rounds=1)
    error = report(benchmark, np.column_stack([track.x_px, track.y_px]), truth)
    assert np.nanmedian(error) < 0.1
    assert np.nanmax(error) < 1.5


@pytest.mark.benchmark(group="patch centres of 1200 frames")
def test_find_patches_without_a_plan(benchmark, scan):
    blobs, truth = scan
    track = benchmark.pedantic(find_patches, (EncodedFrames.of(blobs),), rounds=1)
    report(benchmark, np.column_stack([track.x_px, track.y_px]), truth)


@pytest.mark.benchmark(group="patch centres of 1200 frames")
def test_circles_in_whole_frames(benchmark, scan):
    blobs, truth = scan
    report(benchmark, benchmark.pedantic(circles_in_whole_frames, (EncodedFrames.of(blobs),), rounds=1), truth)


@pytest.mark.benchmark(group="patch centres of 1200 frames")
def test_published_recipe(benchmark, scan):
    blobs, truth = scan
    at = {tuple(cell): k for k, cell in enumerate(PLAN.cells)}
    last = PLAN.columns - 1, PLAN.rows - 1
    corners = truth[[at[0, 0], at[last[0], 0], at[0, last[1]], at[last]]]
    report(benchmark, benchmark.pedantic(published_recipe, (EncodedFrames.of(blobs), corners), rounds=1), truth)
