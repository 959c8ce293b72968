"""The SPAD maps against the datasheet's table and angles, worked out by hand."""

import numpy as np
import pytest

from physics.spads import PITCH_X_M, PITCH_Y_M, spad_map
from recordings.refusal import Refusal

# Field of view x, y in degrees, columns and rows of SPADs, zones: as the datasheet prints them.
DATASHEET = {
    1: (32.8, 32.5, 14, 6, (3, 3)),
    6: (41.4, 51.8, 18, 10, (3, 3)),
    7: (41.4, 51.8, 18, 10, (4, 4)),
    10: (32.8, 60.4, 14, 12, (6, 3)),
    13: (32.8, 42.4, 14, 8, (4, 4)),
}


@pytest.mark.parametrize("map_id", DATASHEET)
def test_extent_and_zones(map_id):
    fov_x, fov_y, columns, rows, grid = DATASHEET[map_id]
    spads = spad_map(map_id)
    used = spads.masks.any(axis=0)
    assert used.sum() == columns * rows
    assert spads.zone_grid == grid
    assert len(spads.masks) == grid[0] * grid[1]
    assert (spads.masks.sum(axis=0) <= 1).all(), "a SPAD belongs to one zone"
    x = spads.tan_x[used.any(axis=0)]
    y = spads.tan_y[used.any(axis=1)]
    half_x = (np.ptp(x) + PITCH_X_M / 400e-6) / 2
    half_y = (np.ptp(y) + PITCH_Y_M / 400e-6) / 2
    assert 2 * np.degrees(np.arctan(half_x)) == pytest.approx(fov_x, abs=0.1)
    assert 2 * np.degrees(np.arctan(half_y)) == pytest.approx(fov_y, abs=0.1)
    assert x.mean() == pytest.approx(0, abs=1e-12)
    assert y.mean() == pytest.approx(0, abs=1e-12)


def test_counts_per_zone_of_the_wide_map():
    assert spad_map(6).masks.sum(axis=(1, 2)).tolist() == [21, 20, 21, 18, 20, 18, 21, 20, 21]


def test_combs_of_the_wide_map():
    """Row 5 of the datasheet, columns counted from 1: the outer zones' columns, then the middle zones'."""
    masks = spad_map(6).masks
    comb = {0: [2, 4, 6], 3: [1, 3, 5], 1: [8, 11], 4: [7, 9, 10, 12], 2: [13, 15, 17], 5: [14, 16, 18]}
    for zone, columns in comb.items():
        assert (np.flatnonzero(masks[zone, 4]) + 1).tolist() == columns
    mirrored = {6: 0, 7: 1, 8: 2, 3: 3, 4: 4, 5: 5}
    for below, above in mirrored.items():
        assert (masks[below, 7] == masks[above, 4]).all()


def test_zone_0_looks_up_and_to_the_right_of_the_image():
    spads = spad_map(6)
    rows, columns = np.nonzero(spads.masks[0])
    assert (spads.tan_x[columns] > 0).all()
    assert (spads.tan_y[rows] < 0).all()


def test_unknown_map_is_refused():
    with pytest.raises(Refusal, match="spad_map_id is 14, expected one of 1, 6, 7, 10, 13"):
        spad_map(14)
