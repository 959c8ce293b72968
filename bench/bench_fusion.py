"""Unmixing of nine histograms on 848 × 480, from counts to depth; its linear algebra against SciPy's sparse solver."""

import numpy as np
import pytest
from scipy.sparse import diags
from scipy.sparse.linalg import splu

from fusion.depths import zone_depths
from fusion.edges import guided_field
from fusion.motion import Motion, finer, grey
from fusion.range_response import range_response
from fusion.sight import sight
from fusion.unmix import unmix
from physics.presets import preset
from recordings.maps import ResponseMaps

SHAPE = (480, 848)
INTRINSICS = np.array([[612.0, 0, 423.5], [0, 612, 239.5], [0, 0, 1]])
LEAST_FRAMES_PER_S = 15
SOLUTIONS = 30


@pytest.fixture(scope="module")
def rig():
    """Nine bells side by side, and a sensor."""
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(2, 845, 80), np.linspace(2, 477, 45)))
    centres = [(a, b) for b in (100, 240, 380) for a in (270, 424, 578)]
    bells = np.stack([np.exp(-(((x - a) / 100) ** 2) - ((y - b) / 90) ** 2) for a, b in centres])
    maps = ResponseMaps(1e4 * bells.reshape(3, 3, -1), x, y, np.arange(x.size).astype(str))
    return sight(maps, SHAPE, INTRINSICS), range_response(preset("tmf8828-3x3-wide-long"))


@pytest.fixture(scope="module")
def frame(rig):
    """Counts of two surfaces in every zone, and an image of noise in blocks."""
    rng = np.random.default_rng(0)
    _, response = rig
    light = np.zeros((9, len(response.range_m)))
    for row, (near, far) in zip(light, rng.uniform([0.8, 2.0], [1.6, 4.0], (9, 2)), strict=True):
        row[np.abs(response.range_m - near).argmin()] = 4000
        row[np.abs(response.range_m - far).argmin()] = 2000
    counts = rng.poisson(np.einsum("pb,pbt->pt", light, response.counts) + response.pedestal)
    rgb = rng.integers(0, 255, (30, 53, 3)).repeat(16, 0).repeat(16, 1)[: SHAPE[0], : SHAPE[1]].astype(np.uint8)
    return counts, rgb


@pytest.mark.benchmark(group="unmixing, counts to depth")
@pytest.mark.parametrize("who", ["each frame alone", "with an earlier image"])
def test_frames_per_second(benchmark, rig, frame, who):
    where, response = rig
    counts, rgb = frame
    step = np.eye(4)
    step[0, 3] = 0.05
    # Shifted as what is 1.5 m away is.
    before = np.roll(rgb, round(INTRINSICS[0, 0] * 0.05 / 1.5), axis=1)
    motion = None if who.startswith("each") else Motion(grey(before, finer(where.coarse.shape)), step)
    depth = benchmark(lambda: unmix(where, zone_depths(counts, response), rgb, motion=motion)[0])
    assert np.isfinite(depth).any()
    assert 1 / benchmark.stats.stats.median >= LEAST_FRAMES_PER_S


def as_sparse(field):
    """The same precision as a sparse matrix, rows of the image one after another."""
    height, width = field.shape
    across = np.pad(field.across, ((0, 0), (0, 1))).ravel()
    down = field.down.ravel()
    degree = np.full(height * width, field.ridge)
    degree += across + np.roll(across, 1)
    degree[:-width] += down
    degree[width:] += down
    return diags([degree, -across[:-1], -across[:-1], -down, -down], [0, 1, -1, width, -width], format="csc")


@pytest.mark.benchmark(group="factor and solve")
@pytest.mark.parametrize("who", ["ours, banded", "scipy, SuperLU"])
def test_factor_and_solve(benchmark, rig, frame, who):
    grid = rig[0].coarse
    images = np.random.default_rng(1).normal(size=(SOLUTIONS, *grid.shape))
    made = guided_field(frame[1], grid.shape, 0.05, 0.01, 0.005)

    def ours():
        field = guided_field(frame[1], grid.shape, 0.05, 0.01, 0.005)
        return np.stack([field.solve(image) for image in images])

    def scipys():
        factor = splu(as_sparse(made))
        return np.stack([factor.solve(image.ravel()).reshape(grid.shape) for image in images])

    found = benchmark(ours if who.startswith("ours") else scipys)
    np.testing.assert_allclose(made.ridge * found[0].sum(), images[0].sum(), rtol=1e-6)
