import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.sparse import sparse_scans, spread_order
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps
from recordings.refusal import Refusal


def smooth_maps(step=8.0):
    x, y = (g.ravel() for g in np.meshgrid(np.arange(0.0, 300, step), np.arange(0.0, 200, step)))
    bumps = [np.exp(-(((x - a) / 60) ** 2) - ((y - 100) / 60) ** 2) for a in (100, 200)]
    return ResponseMaps(1e5 * np.stack(bumps)[None], x, y, np.array([f"{i:04d}" for i in range(len(x))]))


def test_a_smooth_map_needs_few_points():
    found = sparse_scans(smooth_maps(), 10.0, (400, 100, 40))
    assert [scan.points for scan in found] == [400, 100, 40]
    for scan in found[:2]:
        assert (scan.cosine > 0.999).all()
        assert (scan.left_out_cosine > 0.999).all()
        assert (scan.iou > 0.9).all()


def test_published_maps_at_a_quarter_of_the_points(shared_data):
    maps = load_maps(shared_data / "tmf8828_response_maps" / "spad_calib_3x3_longrange_bins15_35.npz")
    half, quarter = sparse_scans(maps, 17.75, (1800, 900))
    assert half.cosine.mean() > 0.997
    assert quarter.cosine.mean() > 0.99
    assert quarter.iou.mean() > 0.92


@given(st.integers(0, 2**32 - 1), st.integers(2, 40))
def test_order_is_farthest_first(seed, count):
    xy = np.random.default_rng(seed).random((40, 2))
    order = spread_order(xy, count)
    assert len(set(order.tolist())) == count
    for i in range(1, count):
        reach = np.linalg.norm(xy[:, None] - xy[order[:i]], axis=2).min(axis=1)
        assert reach[order[i]] == pytest.approx(reach.max())


@pytest.mark.parametrize("points", [5, 10_000])
def test_impossible_numbers_of_points_are_refused(points):
    with pytest.raises(Refusal, match="points"):
        sparse_scans(smooth_maps(), 10.0, (points,))
