import numpy as np
import pytest

from calibrate.kernel import fit_kernel
from calibrate.support import supports
from recordings.maps import ResponseMaps


@pytest.mark.parametrize("threshold", [0.1, 0.5])
def test_area_of_a_bell(threshold):
    """exp(−r²/2s²) reaches a threshold within r² = −2 s² ln(threshold): the area is π times that."""
    x, y = (g.ravel() for g in np.meshgrid(np.arange(0.0, 400, 10), np.arange(0.0, 400, 10)))
    bell = 1e4 * np.exp(-((x - 200) ** 2 + (y - 190) ** 2) / (2 * 50**2))
    maps = ResponseMaps(bell[None, None], x, y, np.array([f"{i:04d}" for i in range(len(x))]))
    found = supports(fit_kernel(maps, 0.0), threshold)
    assert found.area_px2[0] == pytest.approx(-2 * np.pi * 50**2 * np.log(threshold), rel=0.03)
    assert found.inside.shape == (1, len(found.y_px), len(found.x_px))
