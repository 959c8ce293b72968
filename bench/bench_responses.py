"""Eq. 2 and 3 from stacked arrays against a loop over one file a capture, as the published script works."""

import numpy as np
import pytest

from calibrate.responses import responses
from calibrate.window import Window, choose_window

CAPTURES, ZONES, BINS = 3600, (3, 3), 128
FIRST, LAST = 15, 35


@pytest.fixture(scope="module")
def scan():
    rng = np.random.default_rng(0)
    shape = (CAPTURES, ZONES[0] * ZONES[1], BINS)
    background = rng.poisson(200, shape).astype(np.int32)
    patch = rng.poisson(200, shape).astype(np.int32)
    patch[:, :, 20:26] += rng.poisson(1e5 * rng.random(shape[:2])[:, :, None], (*shape[:2], 6)).astype(np.int32)
    return patch, background


@pytest.fixture(scope="module")
def folders(scan, tmp_path_factory):
    folder = tmp_path_factory.mktemp("captures")
    for name, counts in zip(("patch", "background"), scan, strict=True):
        (folder / name).mkdir()
        for k, histogram in enumerate(counts):
            np.save(folder / name / f"{k:04d}.npy", histogram.reshape(*ZONES, BINS))
    return folder


def loop_over_files(folder):
    """One capture at a time from two files: load, subtract, clip, maximum."""
    found = np.empty((*ZONES, CAPTURES), np.float32)
    for k in range(CAPTURES):
        patch = np.load(folder / "patch" / f"{k:04d}.npy")[:, :, FIRST : LAST + 1]
        background = np.load(folder / "background" / f"{k:04d}.npy")[:, :, FIRST : LAST + 1]
        found[:, :, k] = np.clip(patch - background, 0, None).max(axis=2)
    return found / found.max(axis=2, keepdims=True)


def loop_over_captures(patch, background):
    """The same with all captures in memory: what is left of the loop without the files."""
    found = np.empty((ZONES[0] * ZONES[1], CAPTURES), np.float32)
    for k in range(CAPTURES):
        difference = patch[k, :, FIRST : LAST + 1] - background[k, :, FIRST : LAST + 1]
        found[:, k] = np.clip(difference, 0, None).max(axis=1)
    return found / found.max(axis=1, keepdims=True)


def from_stacked_arrays(patch, background):
    found = responses(patch, background, Window(FIRST, LAST))
    return found.value / found.value.max(axis=1, keepdims=True), found.sigma


@pytest.mark.benchmark(group="responses of 3600 x 9 x 128")
def test_stacked_with_errors(benchmark, scan):
    benchmark.pedantic(from_stacked_arrays, scan, rounds=30, warmup_rounds=3)


@pytest.mark.benchmark(group="responses of 3600 x 9 x 128")
def test_loop_over_files(benchmark, folders, scan):
    found = benchmark.pedantic(loop_over_files, (folders,), rounds=5, warmup_rounds=1)
    np.testing.assert_allclose(found.reshape(9, -1), from_stacked_arrays(*scan)[0], rtol=1e-6)


@pytest.mark.benchmark(group="responses of 3600 x 9 x 128")
def test_loop_over_captures(benchmark, scan):
    benchmark.pedantic(loop_over_captures, scan, rounds=5, warmup_rounds=1)


@pytest.mark.benchmark(group="window of 3600 x 9 x 128")
def test_choose_window(benchmark, scan):
    benchmark.pedantic(choose_window, scan, rounds=10, warmup_rounds=1)
