"""Rendered frames: the disc's edge found along rays must lie where the geometry says."""

import cv2
import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.optimize import least_squares

from calibrate.plan import ScanPlan
from calibrate.simulated.bench import Bench
from calibrate.simulated.frames import FrameRenderer, Mishaps, encode_jpeg
from recordings.refusal import Refusal

BENCH = Bench()
POSITIONS = BENCH.patch_positions(ScanPlan(80, 45), np.random.default_rng(4))
CENTRES = BENCH.project(POSITIONS)
MIDDLE = 22 * 80 + 40


@pytest.fixture(scope="module")
def clean():
    return FrameRenderer(BENCH, np.random.default_rng(0), noise=0.0)


@pytest.fixture(scope="module")
def noisy():
    return FrameRenderer(BENCH, np.random.default_rng(0))


def draw(renderer, cell, seed=0, **mishaps):
    named = Mishaps(**{name: frozenset({cell}) for name in mishaps})
    return renderer.render(POSITIONS[cell], cell, np.random.default_rng(seed), named)


def edge_circle(image, guess):
    """Centre and radius of the circle through the half-way points of 180 brightness profiles across the edge."""
    grey = image.astype(float).mean(axis=2)
    angle = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    radius = np.arange(12.0, 24.0, 0.05)
    x = guess[0] + radius[:, None] * np.cos(angle)
    y = guess[1] + radius[:, None] * np.sin(angle)
    profile = map_coordinates(grey, [y, x], order=3)
    half = (profile[:20].mean(axis=0) + profile[-40:-20].mean(axis=0)) / 2
    first = (profile < half).argmax(axis=0)
    edge_x, edge_y = x[first, np.arange(180)], y[first, np.arange(180)]
    fit = least_squares(lambda c: np.hypot(edge_x - c[0], edge_y - c[1]) - c[2], [*guess, 17.0], loss="soft_l1")
    return fit.x


@pytest.mark.parametrize("cell", [MIDDLE, MIDDLE + 17, 500, 1203, 2222, 3011])
def test_the_disc_is_where_it_should_be(clean, cell):
    x, y, radius = edge_circle(draw(clean, cell), np.round(CENTRES[cell]))
    assert [x, y] == pytest.approx(CENTRES[cell], abs=0.05)
    assert radius == pytest.approx(BENCH.focal_px * BENCH.patch_radius_m / POSITIONS[cell, 2], abs=0.1)


def test_noise_and_jpeg_hardly_move_it(noisy):
    """Mean over frames of one position: noise scatters the edge, it does not shift it."""
    found = [
        edge_circle(cv2.imdecode(np.frombuffer(encode_jpeg(draw(noisy, MIDDLE, seed)), np.uint8), 1), CENTRES[MIDDLE])
        for seed in range(8)
    ]
    assert np.mean(found, axis=0)[:2] == pytest.approx(CENTRES[MIDDLE], abs=0.1)


def test_patch_is_bright_on_dark_plate_in_light_ring_on_black_cloth(noisy):
    image = draw(noisy, MIDDLE).astype(float).mean(axis=2)
    y, x = np.indices(image.shape)
    distance = np.hypot(x - CENTRES[MIDDLE, 0], y - CENTRES[MIDDLE, 1])
    patch, plate = image[distance < 14], image[(distance > 19) & (distance < 22)]
    ring = image[(distance > 37) & (distance < 41)]
    assert 170 < patch.mean() < 220
    assert 45 < plate.mean() < 85
    assert 180 < ring.mean() < 225
    assert 15 < np.median(image) < 50


def test_frames_look_as_the_published_one(noisy, shared_data):
    """Brightness around the patch, and the median and spread of the cloth, beside the one published frame."""
    published = cv2.imread(str(shared_data / "tmf8828_response_maps" / "sample_rgb.png")).astype(float)
    cell = np.hypot(*(CENTRES - (428.4, 237.4)).T).argmin()
    ours = draw(noisy, cell).astype(float)
    profiles = []
    for image, (x0, y0) in ((published, (428.4, 237.4)), (ours, CENTRES[cell])):
        y, x = np.indices(image.shape[:2])
        distance = np.hypot(x - x0, y - y0).astype(int)
        profiles.append([image[distance == r].mean() for r in (5, 12, 15, 20, 24, 30, 39)])
    assert profiles[1] == pytest.approx(profiles[0], abs=25)
    for part in (published, ours):
        cloth = part[300:460, 450:700]
        assert 25 < np.median(cloth) < 50
        assert 3 < (cloth - cv2.GaussianBlur(cloth, (0, 0), 6)).std() < 6


def test_the_arm_comes_from_the_upper_left_and_turns(clean):
    """Light pixels far from the flange lie up and to the left of it, and nowhere else."""
    for cell in (MIDDLE, 10, 3590):
        light = draw(clean, cell).min(axis=2) > 120
        y, x = np.nonzero(light)
        far = np.hypot(x - CENTRES[cell, 0], y - CENTRES[cell, 1]) > 70
        assert (x[far] < CENTRES[cell, 0] + 60).all()
        assert (y[far] < CENTRES[cell, 1] + 60).all()


def test_same_generator_same_frame_other_generator_other_noise(noisy):
    first, again, other = draw(noisy, 77, 1), draw(noisy, 77, 1), draw(noisy, 77, 2)
    assert np.array_equal(first, again)
    assert 0.5 < np.abs(first.astype(float) - other).mean() < 20


def test_mishaps_hide_the_patch(noisy):
    def patch_of(image):
        x, y = CENTRES[MIDDLE].round().astype(int)
        return image[y - 8 : y + 9, x - 8 : x + 9].astype(float).mean()

    usual = patch_of(draw(noisy, MIDDLE))
    assert patch_of(draw(noisy, MIDDLE, missing=True)) < 0.5 * usual
    assert patch_of(draw(noisy, MIDDLE, occluded=True)) < 0.5 * usual
    assert patch_of(draw(noisy, MIDDLE, glare=True)) > 1.1 * usual


def test_a_patch_outside_the_image_is_no_error(clean):
    for x, y in ((-2.0, 0.0), (2.0, 2.0), (0.0, -3.0)):
        image = clean.render(np.array([x, y, 0.6]), 0, np.random.default_rng(0))
        assert image.shape == (480, 848, 3)


def test_other_image_sizes():
    bench = Bench(image_size=(424, 240), focal_px=306.0, principal_px=(211.5, 119.5), corners_px=(10, 230, 415, 10))
    image = FrameRenderer(bench, np.random.default_rng(0)).render(
        np.array([0.0, 0.0, 0.6]), 0, np.random.default_rng(0)
    )
    assert image.shape == (240, 424, 3)
    assert image.dtype == np.uint8
    assert image[119, 211].min() > 150


def test_mishaps_outside_the_scan_are_refused():
    with pytest.raises(Refusal, match="mishaps: glare has frame 12, expected 0 to 11"):
        Mishaps(glare=frozenset({12})).check(12)
