import numpy as np
import pytest

from physics.scene.material import Material, reflectance_of_colour
from recordings.refusal import Refusal


def test_matt_is_matt_and_gloss_keeps_its_light():
    cosine = np.linspace(0, 1, 2001)
    assert (Material(0.5).gloss(cosine) == 1).all()
    shiny = Material(1.0, 0.4, 100).gloss(cosine)
    assert shiny[-1] == pytest.approx(0.6 + 0.4 * 108 / 8)
    assert shiny[0] == pytest.approx(0.6)
    assert (np.diff(shiny) >= 0).all()


def test_grey_values():
    rgb = np.array([[[0, 0, 0], [255, 255, 255], [128, 128, 128], [255, 0, 0]]], np.uint8)
    assert reflectance_of_colour(rgb)[0] == pytest.approx([0.02, 1, 0.2158605, 1 / 3], abs=1e-6)


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ((1.1, 0, 1), "reflectance is 1.1, expected 0 to 1"),
        ((np.nan, 0, 1), "reflectance is nan"),
        ((1, -0.1, 1), "specular is -0.1, expected 0 to 1"),
        ((1, 0, -1), "shininess is -1"),
    ],
)
def test_materials_that_cannot_be(numbers, sentence):
    with pytest.raises(Refusal, match=sentence):
        Material(*numbers)
