import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.patch_circle import RAYS, Expected, fit_circle

ANGLES = np.linspace(0, 2 * np.pi, RAYS, endpoint=False)
ALL = np.ones(RAYS, bool)


def rim(dx, dy, radius):
    """Where rays from the origin meet a circle, from the quadratic equation of ray and circle."""
    along = dx * np.cos(ANGLES) + dy * np.sin(ANGLES)
    return along + np.sqrt(along**2 - dx**2 - dy**2 + radius**2)


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(10, 40))
def test_exact_points_give_the_circle(dx, dy, radius):
    found = fit_circle(rim(dx, dy, radius), ALL, ALL, 4.0, Expected(radius + 1))
    assert (found.dx_px, found.dy_px) == pytest.approx((dx, dy), abs=1e-3)
    assert found.radius_px == pytest.approx(radius, abs=0.02)
    assert found.inlier.all()


@given(st.integers(0, RAYS - 1), st.integers(1, 30))
def test_points_of_something_else_do_not_count(first, count):
    distance = rim(0.2, -0.1, 18.0)
    other = (first + np.arange(count)) % RAYS
    distance[other] += 3.0
    found = fit_circle(distance, ALL, ALL, 4.0, Expected(18.0))
    assert (found.dx_px, found.dy_px) == pytest.approx((0.2, -0.1), abs=0.01)
    assert not found.inlier[other].any()


@pytest.mark.parametrize("seen", [1.0, 0.5])
@pytest.mark.parametrize("smooth", [1, 3])
def test_the_error_is_what_repetition_shows(seen, smooth):
    rng = np.random.default_rng(0)
    visible = seen * 2 * np.pi > ANGLES
    kernel = np.ones(smooth) / smooth**0.5
    shifts, claimed = [], []
    for _ in range(400):
        noise = 0.25 * np.convolve(rng.standard_normal(RAYS + smooth - 1), kernel, mode="valid")
        found = fit_circle(rim(0, 0, 18.0) + noise, visible, visible, 0.0, Expected(18.0))
        shifts.append((found.dx_px, found.dy_px))
        claimed.append(found.sigma_px)
    assert np.std(shifts) == pytest.approx(np.sqrt(np.mean(np.square(claimed))), rel=0.2)


def test_a_known_radius_steadies_a_short_arc():
    rng = np.random.default_rng(1)
    visible = ANGLES < 2.0
    off = {0.02: [], np.inf: []}
    for _ in range(100):
        distance = rim(0, 0, 18.0) + 0.1 * rng.standard_normal(RAYS)
        for sigma, errors in off.items():
            found = fit_circle(distance, visible, visible, 0.0, Expected(18.0, sigma))
            errors.append(np.hypot(found.dx_px, found.dy_px))
    assert np.median(off[0.02]) < 0.5 * np.median(off[np.inf])


def test_usual_roughness_is_the_least_error():
    smooth = fit_circle(rim(0, 0, 18.0), ALL, ALL, 4.0, Expected(18.0))
    rough = fit_circle(rim(0, 0, 18.0), ALL, ALL, 4.0, Expected(18.0, noise_px=1.0))
    assert smooth.sigma_px < 0.015
    # A mean over independent rays: var(dx) = 2 var / RAYS.
    assert rough.sigma_px == pytest.approx((2 / RAYS) ** 0.5, rel=0.01)


def test_a_few_points_are_no_circle():
    usable = np.arange(RAYS) < 8
    assert fit_circle(rim(0, 0, 18.0), usable, ALL, 4.0, Expected(18.0)) is None
