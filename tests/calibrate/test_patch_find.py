import cv2
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from calibrate.patch_find import candidates, find_discs, rim_scores

SHAPE = (240, 424)


def cover(x, y, radius, shape=SHAPE):
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    return np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0, 1)


def scene(x, y, seed=0, radius=10.0, with_patch=True):
    """A flange on an arm on dark cloth: a bright ring around a dark plate with bolts, a joint cap, and the patch."""
    rng = np.random.default_rng(seed)
    image = np.full(SHAPE, 25.0)
    arm = np.zeros(SHAPE, np.uint8)
    cv2.line(arm, (int(x), int(y)), (int(x) - 300, int(y) - 130), 255, 36, cv2.LINE_AA)
    image += arm / 255 * 150
    layers = [(x - 60, y - 26, 27, 205), (x - 60, y - 5, 3, 120), (x, y, 2.5 * radius, 220), (x, y, 2 * radius, 65)]
    layers += [(x + 1.5 * radius * c, y + 1.5 * radius * s, 2, 120) for c, s in ((0, 1), (1, 0), (0, -1), (-1, 0))]
    for cx, cy, r, level in layers + [(x, y, radius, 190)] * with_patch:
        share = cover(cx, cy, r)
        image = image * (1 - share) + level * share
    image = cv2.GaussianBlur(image, (0, 0), 0.7) + rng.normal(0, 3, SHAPE)
    return np.clip(image, 0, 255).astype(np.uint8)


@settings(max_examples=15, deadline=None)
@given(st.floats(2, SHAPE[1] - 3), st.floats(2, SHAPE[0] - 3), st.floats(8, 14), st.integers(0, 99))
def test_the_patch_is_the_most_certain_disc(x, y, radius, seed):
    assume(min(x, SHAPE[1] - 1 - x) > radius or min(y, SHAPE[0] - 1 - y) > radius)
    image = scene(x, y, seed, radius)
    for best in find_discs(image)[0], find_discs(image, 1.05 * radius)[0]:
        assert np.hypot(best.x_px - x, best.y_px - y) < 0.3
        assert best.radius_px == pytest.approx(radius, abs=0.3)


@pytest.mark.parametrize(("x", "y"), [(3.6, 4.0), (420.0, 5.5), (3.6, 235.0), (419.0, 235.5)])
def test_a_quarter_of_the_patch_in_a_corner(x, y):
    for best in find_discs(scene(x, y, 0, 17.75))[0], find_discs(scene(x, y, 0, 17.75), 17.75)[0]:
        assert np.hypot(best.x_px - x, best.y_px - y) < 0.6


@pytest.mark.parametrize("seed", range(5))
def test_without_a_patch_nothing_is_certain(seed):
    rng = np.random.default_rng(seed)
    image = scene(rng.uniform(100, 300), rng.uniform(60, 180), seed, with_patch=False)
    assert all(disc.confidence < 0.7 for disc in find_discs(image))


@pytest.mark.parametrize(
    "image",
    [
        np.zeros(SHAPE, np.uint8),
        np.full(SHAPE, 255, np.uint8),
        np.random.default_rng(0).integers(0, 256, SHAPE, np.uint8),
        np.random.default_rng(1).normal(30, 4, SHAPE).astype(np.uint8),
        np.tile(np.arange(SHAPE[1]) // 20 % 2 * 200, (SHAPE[0], 1)).astype(np.uint8),
        np.zeros((1, 1), np.uint8),
        np.full((3, 200), 80, np.uint8),
    ],
    ids=["black", "white", "noise", "dark noise", "stripes", "one pixel", "three rows"],
)
def test_images_without_any_disc(image):
    assert find_discs(image) == []
    assert find_discs(image, 12.0) == []


def test_the_real_frame_shows_the_patch(shared_data):
    grey = cv2.imread(str(shared_data / "tmf8828_response_maps" / "sample_rgb.png"), cv2.IMREAD_GRAYSCALE)
    for radius in (None, 17.75):
        best, *others = find_discs(grey, radius)
        assert (best.x_px, best.y_px) == pytest.approx((428.4, 238.25), abs=0.2)
        assert best.confidence > 0.95
        # Joint cap (310, 186), flange ring, bolts and screws stay doubtful.
        assert all(disc.confidence < 0.7 for disc in others)
    covered = cv2.circle(grey.copy(), (428, 238), 21, 70, -1)
    assert all(disc.confidence < 0.7 for disc in find_discs(covered))


def test_score_is_the_mean_of_inward_unit_gradients():
    image = scene(200, 120)
    radius = 10.0
    score = next(rim_scores(image, [radius], (180, 100), (41, 41)))
    gradient = [np.gradient(image.astype(float), axis=axis) for axis in (1, 0)]
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    x, y = (200 + radius * np.cos(angles)).round().astype(int), (120 + radius * np.sin(angles)).round().astype(int)
    inward = -(gradient[0][y, x] * np.cos(angles) + gradient[1][y, x] * np.sin(angles))
    assert np.unravel_index(score.argmax(), score.shape) == (20, 20)
    assert score[20, 20] == pytest.approx(np.mean(inward / np.hypot(*(g[y, x] for g in gradient))), abs=0.25)


def test_candidates_lie_in_the_box_they_were_asked_for():
    image = scene(6, 120)
    found = candidates(image, [10.0], (-10, 100), (31, 41), 3)
    assert (found[0].x_px, found[0].y_px) == pytest.approx((6, 120), abs=1.5)
    assert all(-10 <= spot.x_px <= 20 and 100 <= spot.y_px <= 140 for spot in found)
    assert candidates(image, [10.0], (-500, -500), (31, 41), 3) == []
