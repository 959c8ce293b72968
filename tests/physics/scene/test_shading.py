import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.scene.material import Material, reflectance_of_colour
from physics.scene.open_scene import open_scene
from physics.scene.shading import EVENLY, LIGHT, coded, linear, shaded
from recordings.refusal import Refusal

TOWARDS = LIGHT / np.linalg.norm(LIGHT)


@given(st.floats(0, 1))
def test_coding_and_its_inverse(bright):
    assert linear(coded(np.array(bright))) == pytest.approx(bright, abs=1e-6)


def test_coding_is_that_of_the_standard():
    # Values of sRGB from colorimetry tables: middle grey and the ends.
    np.testing.assert_allclose(coded(np.array([0, 0.0021, 0.18, 0.5, 1])), [0, 0.0271, 0.4614, 0.7354, 1], atol=2e-4)


def test_a_surface_towards_the_light_has_its_colour_and_one_away_is_dimmed():
    colour = np.array([[0.8, 0.4, 0.2]] * 2)
    lit, unlit = shaded(colour, np.stack([TOWARDS, -TOWARDS]), np.stack([-TOWARDS, TOWARDS])).astype(float)
    np.testing.assert_allclose(lit, 255 * colour[0], atol=0.51)
    np.testing.assert_allclose(linear(unlit / 255), EVENLY * linear(colour[0]), atol=0.005)


def test_the_sign_of_a_normal_does_not_matter():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    looks, colour = rng.normal(size=(20, 3)), rng.uniform(size=(20, 3))
    np.testing.assert_array_equal(shaded(colour, normals, looks), shaded(colour, -normals, looks))


def scene(tmp_path, **wall):
    said = {
        "format": "difflidar-scene/1",
        "camera": {"width": 8, "height": 6, "horizontal_deg": 60},
        "materials": {"wall": {"reflectance": 0.25, **wall}, "plain": {"reflectance": 0.5}},
        "surfaces": [
            {"kind": "plane", "point_m": [0, 0, 2], "normal": [0, 0, 1], "material": "wall"},
            {"kind": "sphere", "centre_m": [0, 0, 1], "radius_m": 0.2, "material": "plain"},
        ],
        "trajectory": {"frames": 1, "poses": [{"time_s": 0, "position_m": [0, 0, 0], "look_at_m": [0, 0, 1]}]},
    }
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(said))
    return path


def test_a_scene_with_a_colour_has_pictures(tmp_path, maps):
    (view,) = open_scene(scene(tmp_path, colour=[1.0, 0.5, 0.0]), maps).views
    assert view.rgb.shape == (6, 8, 3)
    assert view.rgb.dtype == np.uint8
    red, green, blue = (int(n) for n in view.rgb[0, 0])
    assert red > green > blue == 0
    assert np.ptp(view.rgb[2, 3]) == 0  # The ball, of no colour, is grey.


def test_a_scene_without_colours_has_none(tmp_path, maps):
    (view,) = open_scene(scene(tmp_path), maps).views
    assert view.rgb is None


def test_grey_is_as_bright_as_its_reflectance():
    grey = coded(np.array([0.3]))[:, None].repeat(3, axis=1)
    seen = shaded(grey, TOWARDS[None], -TOWARDS[None])
    assert reflectance_of_colour(seen[None])[0, 0] == pytest.approx(0.3, abs=0.004)


@pytest.mark.parametrize("colour", [[1, 2, 3], [0.1, 0.2], "red", [0, 0, None]])
def test_colours_that_cannot_be(tmp_path, maps, colour):
    with pytest.raises(Refusal, match=r"materials\.wall\.colour"):
        open_scene(scene(tmp_path, colour=colour), maps)


def test_materials_check_their_colour():
    with pytest.raises(Refusal, match="colour is"):
        Material(0.5, colour=(0.1, 0.2))
