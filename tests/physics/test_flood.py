"""The flood against the widths the datasheet prints, found here by walking along the axes."""

import numpy as np
import pytest

from physics.flood import tmf882x_flood

ANGLES = np.linspace(0, 35, 3501)
# One scan line along an axis, off the seam and away from the other axis' fall-off.
LINES = {"x": lambda t: (t, 0 * t), "y": lambda t: (0 * t + np.tan(np.radians(6)), t)}


def width_deg(axis: str, level: float) -> float:
    tan = np.tan(np.radians(ANGLES))
    profile = tmf882x_flood().intensity(*LINES[axis](tan))
    plateau = profile[np.argmin(np.abs(ANGLES - 5))] if axis == "x" else profile[0]
    above = profile[ANGLES > 4] > level * plateau
    return 2 * ANGLES[ANGLES > 4][np.argmin(above)]


@pytest.mark.parametrize(("axis", "fwhm"), [("x", 30), ("y", 32)])
def test_full_width_at_half_maximum(axis, fwhm):
    assert width_deg(axis, 0.5) == pytest.approx(fwhm, abs=1)


@pytest.mark.parametrize(
    ("axis", "level", "width"),
    [("x", np.exp(-2), 41), ("y", np.exp(-2), 47), ("x", 0.05, 47), ("y", 0.05, 57)],
)
def test_width_further_out(axis, level, width):
    assert width_deg(axis, level) == pytest.approx(width, abs=1.2)


def test_seam():
    at = np.tan(np.radians([0.0, 4.0]))
    middle, beside = tmf882x_flood().intensity(at, np.zeros(2))
    assert 0.15 < 1 - middle / beside < 0.20


def test_texture_is_fine_and_of_ten_per_cent():
    plain, textured = tmf882x_flood(), tmf882x_flood(np.random.default_rng(3))
    tan = np.tan(np.radians(np.linspace(-12, 12, 121)))
    ratio = textured.intensity(tan, tan[:, None]) / plain.intensity(tan, tan[:, None])
    assert np.std(ratio) == pytest.approx(0.05, rel=0.25)
    assert ratio.mean() == pytest.approx(1, abs=0.01)
    # Fine: what lies 6 degrees away (30 samples) has no say.
    away = np.corrcoef(ratio[:, :-30].ravel(), ratio[:, 30:].ravel())[0, 1]
    assert abs(away) < 0.5


def test_texture_belongs_to_the_device():
    tan = np.linspace(-0.3, 0.3, 20)
    first, again, other = (tmf882x_flood(np.random.default_rng(seed)).intensity(tan, tan) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.allclose(first, other, rtol=0.01)
