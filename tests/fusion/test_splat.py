"""The fast splat against a loop over pixels, and footprints that a baseline displaces."""

import numpy as np
import pytest

from fusion.sight import sight
from fusion.splat import splat_ranges

INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])


def slow_splat(where, ranges, deviations, shifts):
    """Pixel by pixel, zone by zone."""
    peaks = where.weights.max(axis=(1, 2))
    depth, sigma, confidence = (np.full(where.shape, np.nan) for _ in range(3))
    zones = np.full(where.shape, 255)
    for v, u in np.ndindex(where.shape):
        weight = np.zeros(len(ranges))
        for p, (dx, dy) in enumerate(shifts):
            if np.isfinite(ranges[p]) and 0 <= v - dy < where.shape[0] and 0 <= u - dx < where.shape[1]:
                own = where.weights[p, v - dy, u - dx] / peaks[p]
                weight[p] = own if own >= 0.01 else 0
        confidence[v, u] = min(weight.sum(), 1)
        if weight.sum() > 0:
            share = weight / weight.sum()
            seen = share > 0
            mean = (share[seen] * ranges[seen]).sum()
            variance = (share[seen] * (deviations[seen] ** 2 + (ranges[seen] - mean) ** 2)).sum()
            length = np.linalg.norm([(u - 15.5) / 30, (v - 11.5) / 30, 1])
            depth[v, u], sigma[v, u], zones[v, u] = mean / length, np.sqrt(variance) / length, weight.argmax()
    return depth, sigma, confidence, zones


@pytest.mark.parametrize("ranges", [[1.0, 1.2, 0.6, 0.9], [np.nan, 0.5, np.nan, 1.4]])
@pytest.mark.parametrize("baseline", [(0.0, 0.0), (0.4, -0.3)])
def test_it_is_the_weighted_mean(rig, ranges, baseline):
    mount = np.eye(4)
    mount[:2, 3] = -np.array(baseline)
    where = sight(rig.maps, (24, 32), INTRINSICS, mount)
    ranges, deviations = np.array(ranges), np.array([0.1, 0.02, 0.3, 0.05])
    depths = ranges / where.stretch
    with np.errstate(invalid="ignore"):
        moved = 30 * (1 / depths[:, None] - 1 / 0.8) * np.array(baseline)
    shifts = np.rint(np.nan_to_num(moved)).astype(int)
    found, expected = splat_ranges(where, ranges, deviations), slow_splat(where, ranges, deviations, shifts)
    for one, other in zip(found[:3], expected[:3], strict=True):
        np.testing.assert_allclose(one, other, atol=2e-5)
    np.testing.assert_array_equal(found[3], expected[3])
    assert [one.dtype for one in found] == [np.float32] * 3 + [np.uint8]
    if any(baseline):
        assert np.abs(shifts).max() > 2


def test_zones_that_say_nothing_leave_nothing(rig):
    depth, sigma, confidence, zones = splat_ranges(rig.sight, np.full(4, np.nan), np.full(4, np.nan))
    assert np.isnan(depth).all()
    assert np.isnan(sigma).all()
    assert not confidence.any()
    assert (zones == 255).all()


def test_a_wall_is_a_wall(rig):
    """All zones report the range at which their footprint's pixels lie: depth comes out even."""
    depth, sigma, _, _ = splat_ranges(rig.sight, np.full(4, 1.0), np.zeros(4))
    np.testing.assert_allclose(depth * rig.sight.ray_length, np.where(np.isnan(depth), np.nan, 1.0), rtol=1e-6)
    assert np.nanmax(sigma) < 1e-3
