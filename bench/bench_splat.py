"""The direct splat of nine maps on 848 × 480, against numpy and OpenCV; depths from nine histograms."""

import cv2
import numpy as np
import pytest

from fusion.depths import zone_depths
from fusion.peaks import peak_ranges
from fusion.range_response import range_response
from fusion.sight import sight
from fusion.splat import splat_ranges
from physics.presets import preset
from recordings.maps import ResponseMaps

SHAPE = (480, 848)
INTRINSICS = np.array([[612.0, 0, 423.5], [0, 612, 239.5], [0, 0, 1]])
RANGES, DEVIATIONS = np.linspace(0.8, 2.4, 9), np.full(9, 0.1)
LEAST_FRAMES_PER_S = 300


@pytest.fixture(scope="module")
def maps():
    """Nine bells side by side; as in published maps, about three eighths of all pixels are heard by a zone."""
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(2, 845, 80), np.linspace(2, 477, 45)))
    centres = [(a, b) for b in (100, 240, 380) for a in (270, 424, 578)]
    bells = np.stack([np.exp(-(((x - a) / 100) ** 2) - ((y - b) / 90) ** 2) for a, b in centres])
    return ResponseMaps(1e4 * bells.reshape(3, 3, -1), x, y, np.arange(x.size).astype(str))


@pytest.fixture(scope="module", params=[0.0, 0.02], ids=["at the camera", "beside it"])
def where(maps, request):
    mount = np.eye(4)
    mount[0, 3] = -request.param
    made = sight(maps, SHAPE, INTRINSICS, mount)
    splat_ranges(made, RANGES, DEVIATIONS)
    return made


def in_numpy(where):
    """Zone by zone: depth, sigma, confidence, and the zone that says most."""
    maps = where.heard
    total = np.zeros(SHAPE, np.float32)
    once, twice = np.zeros_like(total), np.zeros_like(total)
    for weight, r, s in zip(maps, RANGES, DEVIATIONS, strict=True):
        total += weight
        once += weight * np.float32(r)
        twice += weight * np.float32(r * r + s * s)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = once / total
        sigma = np.sqrt(np.maximum(twice / total - mean * mean, 0))
    return mean / where.ray_length, sigma / where.ray_length, np.minimum(total, 1), maps.argmax(axis=0)


def in_opencv(where):
    """Depth alone: nine times `addWeighted`, from maps that sum to 1 already."""
    share = where.heard / np.maximum(where.heard.sum(axis=0), 1e-12)
    out = np.zeros(SHAPE, np.float32)

    def work():
        out[:] = 0
        for weight, r in zip(share, RANGES, strict=True):
            cv2.addWeighted(out, 1, weight, r, 0, out)
        return cv2.divide(out, where.ray_length)

    return work


@pytest.mark.benchmark(group="nine maps splatted on 848 x 480")
def test_splat(benchmark, where):
    depth, sigma, confidence, _ = benchmark.pedantic(
        splat_ranges, (where, RANGES, DEVIATIONS), rounds=200, warmup_rounds=10
    )
    print(f"\n{1 / benchmark.stats['min']:.0f} frames/s, {1 / benchmark.stats['median']:.0f} in the median")
    if not where.baseline_m.any():
        for one, other in zip((depth, sigma, confidence), in_numpy(where), strict=False):
            np.testing.assert_allclose(one, other, atol=2e-3)
    assert 1 / benchmark.stats["min"] >= LEAST_FRAMES_PER_S


@pytest.mark.benchmark(group="nine maps splatted on 848 x 480")
def test_numpy_zone_by_zone(benchmark, where):
    benchmark.pedantic(in_numpy, (where,), rounds=20, warmup_rounds=2)


@pytest.mark.benchmark(group="nine maps splatted on 848 x 480")
def test_opencv_depth_alone(benchmark, where):
    benchmark.pedantic(in_opencv(where), rounds=50, warmup_rounds=5)


@pytest.fixture(scope="module")
def histograms():
    """Of nine zones with two surfaces each."""
    response = range_response(preset("tmf8828-3x3-wide-long"))
    light = np.zeros((1, 9, len(response.range_m)))
    light[..., 40], light[..., 70] = 3000, 1000
    counts = np.random.default_rng(0).poisson(response.linear(light, response.flat[None]))[0]
    zone_depths(counts, response)
    return counts, response


@pytest.mark.benchmark(group="depths of 9 x 128")
def test_depths(benchmark, histograms):
    benchmark.pedantic(zone_depths, histograms, rounds=100, warmup_rounds=10)


@pytest.mark.benchmark(group="depths of 9 x 128")
def test_strongest_peak(benchmark, histograms):
    counts, response = histograms
    benchmark.pedantic(peak_ranges, (counts, response.sensor), rounds=100, warmup_rounds=10)
