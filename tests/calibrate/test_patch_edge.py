import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from calibrate.patch_circle import Expected
from calibrate.patch_edge import SMOOTH_PX, fit_disc

SHAPE = (90, 120)
SUB = 8


def disc(x, y, radius, inside=180.0, outside=60.0, shape=SHAPE):
    """An image of a disc: each pixel the mean of SUB × SUB points, without rounding."""
    fine = (np.arange(SUB) + 0.5) / SUB - 0.5
    rows = (np.arange(shape[0])[:, None] + fine).ravel() - y
    columns = (np.arange(shape[1])[:, None] + fine).ravel() - x
    covered = np.square(rows[:, None]) + np.square(columns) < radius**2
    share = covered.reshape(shape[0], SUB, shape[1], SUB).mean(axis=(1, 3))
    return outside + (inside - outside) * share


def seen(image):
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


def fit(image, x, y, radius, search=4.0, **known):
    return fit_disc(seen(image), x, y, Expected(radius, **known), search)


@settings(max_examples=40, deadline=None)
@given(st.floats(40, 80), st.floats(35, 55), st.floats(8, 25), st.floats(-2, 2), st.floats(-2, 2))
@example(40.0, 35.0, 8.0625, 0.0, 1.125)
def test_a_disc_is_found_to_a_few_hundredths_of_a_pixel(x, y, radius, dx, dy):
    found = fit(disc(x, y, radius), x + dx, y + dy, radius + 0.7)
    # Of 4000 drawn discs none was farther off than 0.07, neither its centre nor its radius.
    assert (found.x_px, found.y_px) == pytest.approx((x, y), abs=0.08)
    # Smoothed, and seen by square pixels: as blur moves a rim inwards.
    assert found.radius_px == pytest.approx(radius - (SMOOTH_PX**2 + 1 / 12) / (2 * radius), abs=0.08)
    assert found.confidence > 0.95
    assert found.contrast == pytest.approx(120, rel=0.05)
    assert found.arc == 1
    assert found.sigma_px < 0.05


@settings(max_examples=20, deadline=None)
@given(st.floats(58, 62), st.floats(43, 47), st.integers(0, 2**32 - 1))
def test_turned_and_mirrored_images_turn_and_mirror_the_centre(x, y, seed):
    image = seen(disc(x, y, 17.0) + np.random.default_rng(seed).normal(0, 3, SHAPE))
    last = SHAPE[1] - 1
    found = fit_disc(image, 60, 45, Expected(17.0), 4)
    mirrored = fit_disc(np.ascontiguousarray(image[:, ::-1]), last - 60, 45, Expected(17.0), 4)
    transposed = fit_disc(np.ascontiguousarray(image.T), 45, 60, Expected(17.0), 4)
    assert (last - mirrored.x_px, mirrored.y_px) == pytest.approx((found.x_px, found.y_px), abs=0.02)
    assert (transposed.y_px, transposed.x_px) == pytest.approx((found.x_px, found.y_px), abs=0.02)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.1, 1.3), st.floats(0, 20))
def test_brightness_does_not_move_the_centre(gain, offset):
    found = fit(gain * disc(60.3, 44.8, 17.3) + offset, 61, 44, 17)
    assert (found.x_px, found.y_px) == pytest.approx((60.3, 44.8), abs=0.06)
    assert found.confidence > 0.95


@pytest.mark.parametrize(
    ("x", "y", "allowed"),
    [(3.6, 45, 0.06), (-1.0, 45, 0.08), (60, 86.2, 0.06), (116.0, 4.0, 0.25), (3.6, 85.0, 0.25)],
)
def test_part_of_a_disc_at_the_border(x, y, allowed):
    found = fit(disc(x, y, 17.75), x + 1, y - 1, 17.75)
    assert np.hypot(found.x_px - x, found.y_px - y) < allowed
    assert found.arc < 0.65
    known = fit(disc(x, y, 17.75), x + 1, y - 1, 17.75, radius_sigma_px=0.03)
    assert np.hypot(known.x_px - x, known.y_px - y) < 0.1


def test_blur_shrinks_the_radius_as_stated_and_moves_nothing():
    blurred = cv2.GaussianBlur(disc(60.2, 44.6, 15.0), (0, 0), 2.0)
    found = fit(blurred, 60, 45, 15)
    assert (found.x_px, found.y_px) == pytest.approx((60.2, 44.6), abs=0.03)
    # The fit smooths by 0.8 px more.
    assert found.radius_px == pytest.approx(15 - (2.0**2 + 0.8**2) / 30, abs=0.05)


def test_something_dark_over_a_third_of_it():
    image = disc(60.2, 44.6, 17.0)
    image[:, 68:] = 55
    found = fit(image, 60, 45, 17)
    assert (found.x_px, found.y_px) == pytest.approx((60.2, 44.6), abs=0.1)
    assert 0.35 < found.confidence < 0.85


def test_errors_are_honest():
    rng = np.random.default_rng(3)
    pulls = []
    for _ in range(150):
        x, y = rng.uniform(50, 70), rng.uniform(40, 50)
        image = cv2.GaussianBlur(disc(x, y, 17.0), (0, 0), 1.0) + rng.normal(0, 8, SHAPE)
        found = fit(image, x + rng.uniform(-1, 1), y + rng.uniform(-1, 1), 17)
        pulls += [(found.x_px - x) / found.sigma_px, (found.y_px - y) / found.sigma_px]
    assert 0.75 < np.std(pulls) < 1.3
    assert abs(np.mean(pulls)) < 0.25


@pytest.mark.parametrize(
    "image",
    [
        np.full(SHAPE, 0.0),
        np.full(SHAPE, 90.0),
        disc(60, 45, 17, inside=40, outside=160),
        np.tile(np.linspace(0, 200, SHAPE[1]), (SHAPE[0], 1)),
        np.random.default_rng(0).normal(60, 10, SHAPE),
    ],
    ids=["black", "grey", "dark disc", "slope", "noise"],
)
def test_what_is_no_bright_disc_is_not_taken_for_one(image):
    found = fit(image, 60, 45, 17)
    assert found is None or found.confidence < 0.35 or found.sigma_px > 0.5


def test_a_ring_is_no_disc():
    ring = disc(60, 45, 22, 200, 30) - 130 * (disc(60, 45, 16, 1, 0))
    assert fit(ring, 60, 45, 22).confidence < 0.3


def test_a_guess_outside_the_image_finds_nothing():
    assert fit(disc(60, 45, 17), 400, 300, 17) is None
    assert fit(disc(60, 45, 17), -40, 45, 17) is None


def test_the_real_patch_against_a_threshold(shared_data):
    grey = cv2.imread(str(shared_data / "tmf8828_response_maps" / "sample_rgb.png"), cv2.IMREAD_GRAYSCALE)
    y, x = np.mgrid[: grey.shape[0], : grey.shape[1]]
    # Half way between patch (195) and plate (70), within the dark plate around it.
    bright = (grey > 130) & (np.hypot(x - 429, y - 239) < 25)
    found = fit_disc(grey, 430.5, 240.0, Expected(17.75), 4)
    assert (found.x_px, found.y_px) == pytest.approx((x[bright].mean(), y[bright].mean()), abs=0.2)
    assert found.radius_px == pytest.approx(np.sqrt(bright.sum() / np.pi), abs=0.3)
    assert found.confidence > 0.95
    assert 0.02 < found.sigma_px < 0.3
