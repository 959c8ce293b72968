import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import bisplev

from calibrate.spline import SplineBasis, disc_quadrature

BASIS = SplineBasis(-3.0, 5.0, 2.5, 7, 4)


@given(st.integers(0, 2**32 - 1))
def test_values_agree_with_fitpack(seed):
    """FITPACK's bivariate splines on the same knots, which share no code with the design matrix."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-3, 14.5, 8), rng.uniform(5, 15, 8)
    coefficients = rng.normal(size=BASIS.shape)
    knots_x = -3 + 2.5 * np.arange(-3, 11)
    knots_y = 5 + 2.5 * np.arange(-3, 8)
    expected = [bisplev(a, b, (knots_x, knots_y, coefficients.ravel(), 3, 3)) for a, b in zip(x, y, strict=True)]
    np.testing.assert_allclose(BASIS.at(x, y) @ coefficients.ravel(), expected, atol=1e-10)


@given(st.floats(-30, 40), st.floats(-20, 40))
def test_splines_sum_to_one_everywhere(x, y):
    assert BASIS.at(np.array([x]), np.array([y])).sum() == pytest.approx(1)


def test_quadrature_averages_polynomials_over_the_disc():
    """Means of x^a y^b over a disc of radius r: 0 for odd powers, r²/4 for x², r⁴/8 for x⁴, r⁴/24 for x²y²."""
    offsets, weights = disc_quadrature(3.0)
    x, y = offsets.T
    for power, mean in (
        ((0, 0), 1),
        ((1, 0), 0),
        ((2, 0), 9 / 4),
        ((4, 0), 81 / 8),
        ((2, 2), 81 / 24),
        ((3, 2), 0),
    ):
        assert weights @ (x ** power[0] * y ** power[1]) == pytest.approx(mean, abs=1e-12)


def test_disc_of_no_radius_is_its_centre():
    x, y = np.array([1.0, 4.0]), np.array([6.0, 9.0])
    np.testing.assert_array_equal(BASIS.over_disc(x, y, 0).toarray(), BASIS.at(x, y).toarray())


def test_disc_mean_agrees_with_a_fine_sum():
    basis = SplineBasis.covering(np.array([0.0, 100.0]), np.array([0.0, 60.0]), 18, 10.5)
    coefficients = np.random.default_rng(0).normal(size=basis.size)
    u, v = (g.ravel() for g in np.meshgrid(*[np.arange(-17.75, 17.75, 0.1)] * 2))
    inside = np.hypot(u, v) <= 17.75
    expected = (basis.at(40 + u[inside], 30 + v[inside]) @ coefficients).mean()
    assert basis.over_disc(np.array([40.0]), np.array([30.0]), 17.75) @ coefficients == pytest.approx(
        expected, abs=0.02
    )


def test_roughness_is_the_sum_of_squared_differences():
    c = np.random.default_rng(0).normal(size=BASIS.shape)
    expected = np.square(np.diff(c, axis=0)).sum() + np.square(np.diff(c, axis=1)).sum()
    assert c.ravel() @ BASIS.roughness() @ c.ravel() == pytest.approx(expected)


def test_covering_covers():
    x, y = np.array([3.0, 90.0]), np.array([-4.0, 33.0])
    basis = SplineBasis.covering(x, y, 5, 7)
    corners = np.array([-2.0, 95.0]), np.array([-9.0, 38.0])
    assert basis.covers(*corners).all()
    assert not basis.covers(np.array([-30.0, 50.0]), np.array([0.0, 60.0])).any()
