"""A blurred Gaussian is a wider one; moments and light against sums; a wide blur against scipy's."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import correlate1d, gaussian_filter
from scipy.special import ive

from physics.blurring import Blur, blurred
from physics.effects.footprint_blur import effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps

SHAPE = (60, 80)
Y, X = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)


def gaussian(variance, x=41.0, y=28.0):
    return np.exp(-((X - x) ** 2 + (Y - y) ** 2) / 2 / variance) / (2 * np.pi * variance)


def scanned(*images):
    """Footprints of zones with these maps, scanned and read at every pixel."""
    responses = np.stack([image.ravel() for image in images])[None]
    ids = np.full(X.size, "scan")
    return footprints(ResponseMaps(responses, X.ravel(), Y.ravel(), ids, json.dumps({"image_size": [80, 60]})), SHAPE)


def through(where, variance):
    return through_all(where, variance=variance)


def through_all(where, **values):
    changed = effect.footprints(effect.at(**values).values, Rendering(None, where, None, 1.0))
    return changed.weights * where.scale


@pytest.mark.parametrize("variance", [0.3, 4.0, 16.0])
def test_a_blurred_gaussian_is_a_wider_one(variance):
    found = through(scanned(gaussian(25.0)), variance)[0]
    # The discrete kernel's fourth cumulant is its variance: by that it is off a Gaussian (Edgeworth), at the peak most.
    off = 2 * variance / 8 / (25 + variance) ** 2
    np.testing.assert_allclose(found, gaussian(25 + variance), atol=(1.05 * off + 2e-5) * found.max())


@pytest.mark.parametrize("variance", [0.4, 4.0])
def test_with_a_coarse_kernel_the_maps_read_at_its_pixels_are_blurred(variance):
    """By the kernel of the differences of two Poisson numbers (Skellam 1946), convolved as scipy does."""
    rng, coarse = np.random.default_rng(1), 5
    image = gaussian(60.0) * rng.uniform(0.5, 1.5, SHAPE)
    # Between the camera's pixels lies noise of the scan, which such a blur does not see.
    shape = (SHAPE[0] // coarse, SHAPE[1] // coarse)
    responses, ids = image.reshape(1, 1, -1), np.full(X.size, "scan")
    maps = ResponseMaps(responses, X.ravel(), Y.ravel(), ids, json.dumps({"image_size": [80, 60]}))
    where = footprints(maps, shape)
    found = through_all(where, variance=variance * coarse**2, coarse=1.0)[0]
    kernel, expected = ive(np.abs(np.arange(-12, 13)), variance), where.weights[0] * where.scale
    for axis in (0, 1):
        expected = correlate1d(expected, kernel, axis=axis, mode="reflect")
    np.testing.assert_allclose(found, expected, atol=1e-3 * expected.max())
    fine = through_all(where, variance=variance * coarse**2)[0]
    assert np.abs(fine - expected).max() > 10 * np.abs(found - expected).max()


def test_little_blur_changes_maps_by_twice_as_much_where_it_is_twice_as_much():
    """To within a thousandth, which rounding of single precision would not leave: a fit needs these slopes."""
    where = scanned(gaussian(25.0) * np.random.default_rng(2).uniform(0.9, 1.1, SHAPE))
    table = where.field.table
    once, twice = (Blur(v)(table) - table for v in (1e-4, 2e-4))
    np.testing.assert_allclose(twice, 2 * once, atol=1e-3 * np.abs(once).max())
    drawn = [where.field.added((Blur(v),)) for v in (1e-4, 2e-4)]
    np.testing.assert_allclose(drawn[1], 2 * drawn[0], atol=1e-3 * np.abs(drawn[0]).max())


@pytest.mark.parametrize("variance", [-2.0, -0.5, 0.3, 4.0, 16.0])
def test_variances_add(variance):
    found = through(scanned(gaussian(25.0)), variance)[0]
    for axis in (X, Y):
        mean = (axis * found).sum() / found.sum()
        spread = ((axis - mean) ** 2 * found).sum() / found.sum()
        # Where a sharpened map reaches 0, a little less is taken off.
        np.testing.assert_allclose(spread, 25 + variance, rtol=1e-4 if variance > 0 else 5e-3)


@settings(deadline=None, max_examples=20)
@given(variance=st.floats(-400, 2500), haze=st.floats(0, 1), steeper=st.floats(-0.8, 3), seed=st.integers(0, 99))
def test_every_zone_keeps_its_light(variance, haze, steeper, seed):
    maps = np.random.default_rng(seed).uniform(0, 1, (2, *SHAPE)) * [[[1.0]], [[0.01]]]
    found = Blur(variance, haze=haze, steeper=steeper)(maps)
    np.testing.assert_allclose(found.sum(axis=(1, 2)), maps.sum(axis=(1, 2)), rtol=1e-9)
    assert (found >= 0).all()


def test_a_hazy_zone_is_a_narrow_one_and_a_wide_one():
    found = Blur(0.0, haze=0.3, wide_px2=36.0)(gaussian(25.0)[None])[0]
    # Off a Gaussian by the kernel's own fourth cumulant, as above.
    off = 0.3 * 2 * 36.0 / 8 / 61.0**2 * gaussian(61.0).max() / gaussian(25.0).max()
    np.testing.assert_allclose(
        found, 0.7 * gaussian(25.0) + 0.3 * gaussian(61.0), atol=(1.05 * off + 2e-5) * gaussian(25.0).max() + 2e-6
    )


@pytest.mark.parametrize("steeper", [-0.3, 0.5])
def test_a_power_of_a_gaussian_is_a_narrower_one(steeper):
    found = through_all(scanned(gaussian(25.0)), steeper=steeper)[0]
    np.testing.assert_allclose(found, gaussian(25.0 / (1 + steeper)), atol=1e-3 * found.max())


def test_light_of_footprints_is_kept_up_to_the_edge_of_the_image():
    where = scanned(gaussian(100.0, 3, 55), gaussian(50.0))
    for variance in (-30.0, 16.0, 900.0):
        sums = through(where, variance).sum(axis=(1, 2))
        np.testing.assert_allclose(sums, through(where, 0.0).sum(axis=(1, 2)), rtol=1e-5)


def test_an_unsharp_mask_cuts_off_what_would_be_below_nothing():
    image = np.random.default_rng(3).uniform(0, 1, SHAPE)
    # Away from the edges, where scipy's discrete kernel is a Gaussian read at pixels.
    mask = image + 1.4 * (image - gaussian_filter(image, 3.0, mode="reflect"))
    found = Blur(-9.0, amount=1.4, kept=0.0)(image[None])[0]
    np.testing.assert_allclose(found, np.maximum(mask, 0), atol=0.02)
    again = Blur(-9.0, amount=1.4, kept=0.5)(image[None])[0]
    np.testing.assert_allclose(again.sum(), np.sqrt(found.sum() * image.sum()), rtol=1e-9)


def test_blurs_follow_each_other_as_one():
    image = np.random.default_rng(1).uniform(0, 1, SHAPE)
    np.testing.assert_allclose(blurred(blurred(image, 3.0), 0.7), blurred(image, 3.7), atol=1e-12)


def test_a_wide_blur_is_scipys():
    image = np.random.default_rng(2).uniform(0, 1, SHAPE)
    # Kurtosis of the discrete kernel is 1/variance: so much they may differ.
    np.testing.assert_allclose(blurred(image, 64.0), gaussian_filter(image, 8.0, mode="reflect", truncate=8), atol=1e-3)


@pytest.mark.parametrize("lost", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("at", [(41.0, 28.0), (3.0, 28.0), (78.0, 57.0)])
def test_what_is_blurred_beyond_the_image_is_mirrored_or_lost(lost, at):
    image = gaussian(9.0, *at)
    mirrored, gone = (gaussian_filter(image, 8.0, mode=edge) for edge in ("reflect", "constant"))
    theirs = (1 - lost) * mirrored + lost * gone
    found = Blur(64.0, lost=lost)(image[None])[0]
    np.testing.assert_allclose(found, theirs, atol=6e-3 * image.max())
    hazy = Blur(0.0, haze=0.3, wide_px2=64.0, lost=lost)(image[None])[0]
    np.testing.assert_allclose(hazy, 0.7 * image + 0.3 * theirs, atol=2e-3 * image.max())


@pytest.mark.parametrize("taller", [-0.9, 0.6])
def test_a_patch_that_is_longer_one_way_blurs_more_that_way(taller):
    image = np.random.default_rng(8).random((90, 120))
    down, along = 8.0 * np.exp(taller / 2), 8.0 * np.exp(-taller / 2)
    theirs = gaussian_filter(image, (down, along), mode="reflect", truncate=8)
    np.testing.assert_allclose(Blur(64.0, taller=taller)(image[None])[0], theirs, atol=2e-3)


@pytest.mark.parametrize("flat", [1.0, 0.4])
def test_a_round_patch_blurs_evenly_to_its_edge(flat):
    """Means over places spread evenly in a disc, whose radius is twice the standard deviation along an axis."""
    variance, many = 30.0, 4000
    far, turn = np.sqrt((np.arange(many) + 0.5) / many), np.arange(many) * np.pi * (3 - np.sqrt(5))
    x, y = (2 * np.sqrt(variance) * far * of(turn) for of in (np.cos, np.sin))
    found = Blur(variance, flat=flat)(gaussian(9.0)[None])[0]
    normal = gaussian(9.0 + variance)
    for row, column in ((28, 41), (28, 50), (36, 33), (20, 48)):
        square = (column + x - 41) ** 2 + (row + y - 28) ** 2
        under = (np.exp(-square / 18) / (18 * np.pi)).mean()
        expected = flat * under + (1 - flat) * normal[row, column]
        assert found[row, column] == pytest.approx(expected, rel=5e-3, abs=1e-6)


def test_the_slope_at_nothing_is_the_same_from_both_sides():
    """A Gaussian's change with its variance solves the heat equation: half the Laplacian."""
    image = gaussian(64.0)
    up, down = (Blur(v)(image[None])[0] for v in (1e-4, -1e-4))
    laplacian = image * ((X - 41) ** 2 + (Y - 28) ** 2 - 2 * 64) / 64**2
    within = np.hypot(X - 41, Y - 28) < 20
    for slope in ((up - image) / 1e-4, (image - down) / 1e-4):
        np.testing.assert_allclose(slope[within], laplacian[within] / 2, atol=1e-2 * np.abs(laplacian).max())


def test_a_flat_scene_of_one_range_is_as_bright(small):
    """What a zone loses at its centre comes from beside it, through the model from maps to counts."""
    where = scanned(gaussian(30.0), gaussian(60.0, 30, 35), gaussian(40.0), gaussian(20.0))
    flat = direct_light(np.full((1, *SHAPE), 1.0), np.diag([1e9, 1e9, 1]), cosine=np.ones((1, *SHAPE)))
    model = ForwardModel(flat, where, small.clock)
    np.testing.assert_allclose(model.expected(1e3, [effect.at(variance=20)]), model.expected(1e3), rtol=1e-4)


def test_published_maps_keep_their_light_though_the_scan_ends_where_it_is_not_dark(shared_data):
    maps = load_maps(shared_data / "tmf8828_response_maps" / "spad_calib_3x3_longrange_bins15_35.npz")
    where = footprints(maps, (240, 424))
    sums = where.weights.sum(axis=(1, 2))
    for variance in (-36.0, 36.0):
        np.testing.assert_allclose(through(where, variance).sum(axis=(1, 2)) / where.scale, sums, rtol=5e-3)
