"""What one would do otherwise, in the orientation of the maps."""

import numpy as np
import pytest

from fusion.quality.alternatives import alternatives, guided_filter
from fusion.sight import Sight

SHAPE = (90, 120)
K = np.array([[100.0, 0, 59.5], [0, 100, 44.5], [0, 0, 1]])
RGB = np.full((*SHAPE, 3), 128, np.uint8)


def rig(mirrored=False):
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    columns = (95, 60, 25) if mirrored else (25, 60, 95)
    bells = [np.exp(-(((u - x) / 9) ** 2) - ((v - y) / 9) ** 2) for y in (19, 45, 71) for x in columns]
    return Sight(np.stack(bells).astype(np.float32), K, (3, 3), np.zeros(3), np.inf)


@pytest.mark.parametrize("mirrored", [False, True])
def test_each_zone_has_its_range_where_it_looks(mirrored):
    where = rig(mirrored)
    range_m = np.arange(1.0, 10.0)
    found = alternatives(where, range_m, RGB)
    for p, weight in enumerate(where.weights):
        v, u = np.unravel_index(weight.argmax(), SHAPE)
        for name in ("nearest zone", "datasheet rectangles", "bilinear"):
            assert found[name][v, u] * where.ray_length[v, u] == pytest.approx(range_m[p], abs=0.03)


def test_the_rectangle_in_the_middle_is_a_third_of_the_datasheets_field():
    found = alternatives(rig(), np.array([1, 1, 1, 1, 5, 1, 1, 1, 1.0]), RGB)["datasheet rectangles"]
    # tan(20.5°)·200/3 and tan(26°)·200/3 pixels.
    middle = found > 3
    assert middle.any(axis=0).sum() == pytest.approx(24.9, abs=1)
    assert middle.any(axis=1).sum() == pytest.approx(32.5, abs=1)


def test_bilinear_is_linear_between_zones():
    found = alternatives(rig(), np.tile([1.0, 2.0, 3.0], 3), RGB)
    across = found["bilinear"][45] * rig().ray_length[45]
    assert across[60 + 17] == pytest.approx(2 + 17 / 35, abs=0.01)


def test_a_zone_without_a_range_takes_its_neighbours():
    range_m = np.full(9, 2.0)
    range_m[4] = np.nan
    assert all(np.isfinite(image).all() for image in alternatives(rig(), range_m, RGB).values())


def test_guided_filter_keeps_an_edge_that_grey_has_too():
    rgb = RGB.copy()
    rgb[:, 60:] = 250
    step = np.where(np.arange(120) < 60, 1.0, 2.0) * np.ones((90, 1))
    sharp, blurred = guided_filter(step, rgb), guided_filter(step, RGB)
    assert np.abs(sharp - step).mean() < 0.2 * np.abs(blurred - step).mean()
    np.testing.assert_allclose(guided_filter(np.full(SHAPE, 1.7), rgb), 1.7, atol=1e-6)
