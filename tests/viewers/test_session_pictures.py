from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viewers.footprint_contours import contours
from viewers.session_pictures import every, metres, picture, points, spacing, thin_cloud

from .fusion_frames import HEIGHT, WIDTH, footprints, frame


def numbers(image):
    blob = image.blob.as_arrow_array()[0].values.to_numpy()
    return cv2.imdecode(blob, cv2.IMREAD_UNCHANGED)


@given(st.integers(1, 3000), st.integers(1, 3000), st.integers(1, 1 << 17))
def test_a_step_leaves_no_more_pixels_than_asked_for(height, width, most):
    step = every((height, width), most)
    assert step >= 1
    assert height * width / step**2 <= most or step == 1


@settings(max_examples=25, deadline=None)
@given(st.lists(st.floats(0.0, 60.0, width=32) | st.just(float("nan")), min_size=4, max_size=4))
def test_metres_are_kept_to_a_millimetre(values):
    image = np.array(values, np.float32).reshape(2, 2)
    kept = numbers(metres(image, 1 << 10, "Turbo", (0, 1))) / 1000
    np.testing.assert_allclose(kept, np.nan_to_num(image), atol=0.0006)


def test_beyond_what_sixteen_bits_hold_depth_stays_at_the_end():
    image = np.array([[100.0, np.inf, -3.0]], np.float32)
    np.testing.assert_array_equal(numbers(metres(image, 10, "Turbo", (0, 1))), [[65535, 0, 0]])


def test_bytes_of_an_image_are_kept_as_they_came():
    blob = cv2.imencode(".png", np.zeros((4, 6, 3), np.uint8))[1].tobytes()
    image, size = picture(blob)
    assert size == (4, 6)
    assert image.blob.as_arrow_array()[0].values.to_numpy().tobytes() == blob
    assert image.media_type.as_arrow_array()[0].as_py() == "image/png"


def test_a_thinned_cloud_lies_on_the_whole_one():
    fused = frame(0).fused
    ramp = np.linspace(1, 3, WIDTH)[None, :] * np.ones((HEIGHT, 1))
    fused = replace(fused, depth_m=ramp.astype(np.float32))
    thin = thin_cloud(fused, 300)
    assert 0 < len(thin) <= 300
    # Depth is a ramp along x of the image: every point says where it came from.
    z = thin.points_m[:, 2].astype(float)
    u = (z - 1) / 2 * (WIDTH - 1)
    np.testing.assert_allclose(thin.points_m[:, 0], (u - 31.5) / 50 * z, atol=2e-3)


def test_points_are_as_large_as_they_lie_apart():
    x, y = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41))
    grid = np.stack([x, y, np.full_like(x, 2.0)], axis=-1).reshape(-1, 3)
    assert spacing(grid) == pytest.approx(0.05, rel=0.05)
    assert spacing(np.empty((0, 3))) == 0


def test_a_cloud_without_colour_has_those_of_its_zones():
    cloud = replace(frame(0).cloud, colours=None, zones=np.full(len(frame(0).cloud), 3, np.uint8))
    table = np.zeros((256, 3), np.uint8)
    table[3] = (10, 20, 30)
    shown = points(cloud, 100, None, table)
    assert len(shown.positions) <= 100
    assert set(shown.colors.as_arrow_array().to_pylist()) == {0x0A141EFF}


def test_contours_run_round_the_footprints():
    size = (360, 640)
    for p, lines in enumerate(contours(footprints(), size)):
        (line,) = lines
        row, column = divmod(p, 3)
        left, top = 10 * (4 + 20 * (2 - column)), 10 * (4 + 15 * row)
        np.testing.assert_allclose(line.min(axis=0), (left, top), atol=6)
        np.testing.assert_allclose(line.max(axis=0), (left + 160, top + 100), atol=6)
        np.testing.assert_array_equal(line[0], line[-1])


def test_a_zone_that_looks_nowhere_has_no_contour():
    assert contours(np.zeros((2, 6, 8)), (60, 80)) == [[], []]
