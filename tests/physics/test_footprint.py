"""Footprints against scipy's griddata, and what moves and changes them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import griddata

from physics.footprint import FootprintField, footprints
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal


def test_maps_are_read_as_griddata_does_and_divided_by_one_number(maps):
    found = footprints(maps, (60, 106)).weights
    v, u = np.mgrid[:60, :106]
    at = ((u + 0.5) * 8 - 0.5, (v + 0.5) * 8 - 0.5)
    read = np.stack([griddata((maps.xs, maps.ys), zone, at, fill_value=0) for zone in maps.by_zone])
    np.testing.assert_allclose(found, read / read.max(), atol=1e-12)
    assert found.max() == 1
    assert found[:, 0].max() == 0  # Above the hull of the scan.


def test_a_full_size_image_of_another_size(maps):
    half = replace(maps, xs=maps.xs / 2, ys=maps.ys / 2, meta_json=json.dumps({"image_size": [424, 240]}))
    # Half the pixels, whose centres are at half the places less a quarter.
    shifted = replace(half, xs=half.xs - 0.25, ys=half.ys - 0.25)
    np.testing.assert_allclose(footprints(shifted, (12, 20)).weights, footprints(maps, (12, 20)).weights, atol=1e-9)


def test_moved_footprints_are_read_elsewhere_on_the_same_scale(maps):
    still = footprints(maps, (48, 80))
    moved = still.moved(848 / 80, 0).weights
    np.testing.assert_allclose(moved[:, :, 1:], still.weights[:, :, :-1], atol=1e-9)


def test_changes_apply_in_order_and_survive_a_move(maps):
    still = footprints(maps, (12, 20))
    twice = still.changed(lambda w: 2 * w).changed(lambda w: w + 1)
    np.testing.assert_allclose(twice.weights, 2 * still.weights + 1)
    np.testing.assert_allclose(twice.moved(50, 0).weights, 2 * still.moved(50, 0).weights + 1)


def test_only_pixels_that_some_zone_sees_are_kept(maps):
    made = footprints(maps, (60, 106))
    ((pixels, weights),) = made.seen
    assert len(pixels) < 60 * 106
    back = np.zeros((4, 60 * 106), np.float32)
    back[:, pixels] = weights.T
    np.testing.assert_array_equal(back, made.weights.reshape(4, -1).astype(np.float32))


def test_maps_that_show_nothing_are_refused(maps):
    with pytest.raises(Refusal, match="no response above 0"):
        footprints(replace(maps, responses=np.zeros_like(maps.responses)), (6, 10))
    line = ResponseMaps(np.ones((1, 1, 3)), np.arange(3.0), np.arange(3.0), np.array(["a", "b", "c"]))
    with pytest.raises(Refusal, match="span no triangle"):
        FootprintField(line)
