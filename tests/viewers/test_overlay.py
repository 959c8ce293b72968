import cv2
import numpy as np
import pytest

from viewers.overlay import overlay, save_overlay, zone_colours, zone_opacity


def bumps(zones=4, shape=(30, 40)):
    """One bright block a zone, side by side."""
    images = np.zeros((zones, *shape))
    for p in range(zones):
        images[p, 5:25, p * 10 : p * 10 + 8] = 100.0 * (p + 1)
    return images


def test_each_zone_shows_in_its_own_colour():
    picture = overlay(np.full((120, 160, 3), 100, np.uint8), bumps())
    for p, colour in enumerate(zone_colours(4)):
        shown = picture[60, p * 40 + 16] / 255
        strongest = colour.argmax()
        assert shown[strongest] == pytest.approx(shown.max())


def test_where_no_zone_looks_the_darkened_image_shows():
    picture = overlay(np.full((120, 160, 3), 100, np.uint8), bumps())
    assert (picture[4, 4] == 70).all()


def test_unmeasured_and_faint_points_are_clear():
    images = bumps()
    images[:, :2] = np.nan
    images[0, 28, 0] = 0.5
    opacity = zone_opacity(images)
    assert (opacity[:, :2] == 0).all()
    assert opacity[0, 28, 0] == 0
    assert opacity.max() == pytest.approx(0.9)
    assert (zone_opacity(np.zeros((2, 4, 4))) == 0).all()


def test_picture_is_written_whole_or_not_at_all(tmp_path):
    rgb = np.zeros((120, 160, 3), np.uint8)
    save_overlay(tmp_path / "a.png", rgb, bumps(), (2, 2))
    assert cv2.imread(str(tmp_path / "a.png")).shape[2] == 3
    with pytest.raises(ValueError, match="does not exist"):
        save_overlay(tmp_path / "none" / "a.png", rgb, bumps(), (2, 2))
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]
