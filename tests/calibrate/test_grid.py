import numpy as np
import pytest

from calibrate.grid import map_images, sigma_images
from calibrate.kernel import fit_kernel
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal


def bell(x, y):
    return 1e4 * np.exp(-((np.asarray(x) - 420) ** 2 + (np.asarray(y) - 230) ** 2) / (2 * 70**2))


def maps_at(x, y):
    return ResponseMaps(bell(x, y)[None, None], x, y, np.array([f"{i:04d}" for i in range(len(x))]))


@pytest.fixture(scope="module")
def scanned():
    x, y = (g.ravel() for g in np.meshgrid(np.arange(200.0, 640, 16), np.arange(60.0, 420, 16)))
    maps = maps_at(x, y)
    return maps, fit_kernel(maps, 0.0)


@pytest.mark.parametrize("step", [4, 8])
def test_pixels_are_the_map_at_the_middle_of_their_block(scanned, step):
    images = map_images(scanned[1], scanned[0], step)
    assert images.shape == (1, 480 // step, 848 // step)
    row, column = np.nonzero(~np.isnan(images[0]))
    x, y = (column + 0.5) * step - 0.5, (row + 0.5) * step - 0.5
    np.testing.assert_allclose(images[0, row, column], bell(x, y), atol=100)


def test_nothing_is_said_outside_the_scan(scanned):
    maps, kernel = scanned
    images = map_images(kernel, maps)
    column, row = np.meshgrid(np.arange(212) * 4 + 1.5, np.arange(120) * 4 + 1.5)
    inside = (column >= maps.xs.min()) & (column <= maps.xs.max()) & (row >= maps.ys.min()) & (row <= maps.ys.max())
    np.testing.assert_array_equal(~np.isnan(images[0]), inside)
    np.testing.assert_array_equal(np.isnan(sigma_images(kernel, maps)), np.isnan(images))


def test_errors_are_those_of_the_kernel(scanned):
    maps, kernel = scanned
    errors = sigma_images(kernel, maps, 16)
    assert errors[0, 10, 25] == pytest.approx(kernel.response_sigma(np.array([407.5]), np.array([167.5]))[0, 0])


def test_positions_on_one_line_are_refused():
    line = maps_at(np.linspace(100, 700, 40), np.full(40, 200.0))
    with pytest.raises(Refusal, match="one line"):
        map_images(fit_kernel(line, 0.0), line)
