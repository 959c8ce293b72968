"""Zone responses against a spot spread over the array on a fine grid."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.optics import tmf882x_optics
from recordings.refusal import Refusal

OPTICS = tmf882x_optics(6, np.random.default_rng(5))


def spread_over_the_array(optics, tan_x, tan_y):
    """(P,) response, each SPAD summed on a 0.05 um grid of the array; shares no formula with the source."""
    step = 0.05e-6
    # Image side: the array as seen through the lens, x to the right of the image.
    place = np.arange(-400e-6, 400e-6, step) + step / 2
    core, halo = (
        [
            np.exp(-0.5 * ((place - tan * 400e-6) / blur) ** 2) * step / blur / np.sqrt(2 * np.pi)
            for tan in (tan_x, tan_y)
        ]
        for blur in (optics.blur_m, optics.halo_m)
    )
    own, scattered = np.zeros(len(optics.spads.masks)), np.zeros(len(optics.spads.masks))
    for zone, row, column in zip(*np.nonzero(optics.spads.masks), strict=True):
        centre_x, centre_y = -(column - 8.5) * 16.8e-6, (row - 5.5) * 38.8e-6
        for total, (across, along), (width, height) in (
            (own, core, optics.active_m),
            (scattered, halo, (16.8e-6, 38.8e-6)),
        ):
            inside_x = np.abs(place - centre_x) < width / 2
            inside_y = np.abs(place - centre_y) < height / 2
            total[zone] += across[inside_x].sum() * along[inside_y].sum()
    share = optics.halo_share
    together = (1 - share) * own + share * scattered + optics.stray_share * scattered.sum()
    return together * optics.flood.intensity(np.array(tan_x), np.array(tan_y))


@pytest.mark.parametrize(("tan_x", "tan_y"), [(0.01, -0.03), (0.123, 0.26), (-0.3, 0.05), (0.2, -0.24)])
def test_response_is_the_spot_on_the_spads(tan_x, tan_y):
    got = OPTICS.response(np.array([tan_x, tan_y, 1.0]))
    assert got == pytest.approx(spread_over_the_array(OPTICS, tan_x, tan_y), abs=0.004)


@given(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(0.01, 50))
def test_length_does_not_matter_and_nothing_is_gained(tan_x, tan_y, depth):
    near = OPTICS.response(np.array([tan_x, tan_y, 1.0]))
    assert OPTICS.response(depth * np.array([tan_x, tan_y, 1.0])) == pytest.approx(near, rel=1e-9, abs=1e-12)
    assert (near >= 0).all()
    # All light, times the largest texture, plus what stray light adds to each of nine zones.
    assert near.sum() < 1.3 * (1 + 9 * OPTICS.stray_share)


def test_continuous_in_angle():
    x = np.linspace(-0.4, 0.4, 4001)
    line = OPTICS.response(np.column_stack([x, np.full_like(x, 0.05), np.ones_like(x)]))
    assert np.abs(np.diff(line, axis=1)).max() < 0.02


def test_shape_follows_directions_and_behind_is_dark():
    directions = np.zeros((2, 5, 3))
    directions[..., 2] = [[1], [-1]]
    response = OPTICS.response(directions)
    assert response.shape == (9, 2, 5)
    assert (response[4, 0] > 0.1).all()
    assert (response[:, 1] == 0).all()


def test_stray_light_is_one_per_cent_of_the_sum_and_smooth():
    centre_of_zone_8 = np.array([-0.2, 0.28, 1.0])
    response = OPTICS.response(centre_of_zone_8)
    assert response.argmax() == 8
    assert 0.005 < response[0] / response.sum() < 0.02


def test_no_stray_light_leaves_far_zones_dark():
    dark = replace(OPTICS, stray_share=0.0, halo_share=0.0)
    assert dark.response(np.array([-0.2, 0.28, 1.0]))[0] < 1e-12


def test_directions_of_another_shape_are_refused():
    with pytest.raises(Refusal, match=r"directions has shape \(3, 2\), expected \(..., 3\)"):
        OPTICS.response(np.zeros((3, 2)))
