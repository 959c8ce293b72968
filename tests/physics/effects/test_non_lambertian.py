"""The lobe against Blinn's formula written out with vectors, and its limits."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_t

from physics.effects.non_lambertian import effect
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.rendering import Rendering

INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30.0, 11.5], [0, 0, 1]])


def seen(light, **values):
    return effect.light(effect.at(**values).values, SimpleNamespace(light=light)).returns[0].strength


def sphere():
    """Depth, normals and points of a sphere of 0.4 m at 1.2 m, NaN beside it."""
    v, u = np.mgrid[:24, :32]
    rays = np.stack([(u - 15.5) / 30, (v - 11.5) / 30, np.ones((24, 32))], axis=-1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    along = 1.2 * rays[..., 2]
    inside = along**2 - 1.2**2 + 0.4**2
    points = np.where(inside > 1e-3, along - np.sqrt(np.maximum(inside, 0)), np.nan)[..., None] * rays
    return points[..., 2], (points - [0, 0, 1.2]) / 0.4, points


@pytest.mark.parametrize(("lobe", "exponent"), [(0.5, 20.0), (3.0, 1.0), (20.0, 300.0), (1.0, 0.0)])
def test_it_is_blinns_with_source_and_eye_in_one_place(lobe, exponent):
    depth, normals, points = sphere()
    to_source = to_eye = -points / np.linalg.norm(points, axis=-1, keepdims=True)
    half = (to_source + to_eye) / np.linalg.norm(to_source + to_eye, axis=-1, keepdims=True)
    matt = np.sum(normals * to_source, axis=-1)
    specular = np.sum(normals * half, axis=-1) ** exponent
    closed = 0.3 * (matt + lobe * specular) / np.sum(points**2, axis=-1)
    light = direct_light(depth[None], INTRINSICS, np.full((1, 24, 32), 0.3), matt[None])
    np.testing.assert_allclose(seen(light, lobe=lobe, exponent=exponent)[0], np.nan_to_num(closed), rtol=1e-4)


def test_straight_on_it_is_brighter_by_the_lobe_whatever_the_exponent(small):
    light = direct_light(np.ones((1, 24, 32)), INTRINSICS, None, np.ones((1, 24, 32)))
    for exponent in (0, 1, 20, 500):
        np.testing.assert_allclose(seen(light, lobe=2, exponent=exponent), 3 * light.returns[0].strength, rtol=1e-6)


def test_exponent_1_is_a_gain_in_the_counts(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found = model.expected(1e3, [effect.at(lobe=0.7, exponent=1)])
    np.testing.assert_allclose(found, 1.7 * model.expected(1e3), rtol=1e-6)


def test_a_retroreflector_does_not_fall_with_incidence():
    cosine = np.linspace(0.05, 1, 24 * 32).reshape(1, 24, 32)
    light = direct_light(np.ones((1, 24, 32)), INTRINSICS, None, cosine)
    matt = light.returns[0].strength
    lobe = (seen(light, lobe=5, exponent=0) - matt) * light.range_m**2
    np.testing.assert_allclose(lobe, 5, rtol=1e-4)


@pytest.mark.parametrize("power", [-1.0, -0.4, 1.0, 5.0])
def test_a_power_of_the_cosine_is_minnaerts_law(power):
    """Radiance of a full moon: both cosines to the power k, over that of the light that leaves; k = 1 + power/2."""
    depth, normals, points = sphere()
    matt = np.sum(normals * -points, axis=-1) / np.linalg.norm(points, axis=-1)
    k = 1 + power / 2
    closed = 0.3 * matt**k * matt ** (k - 1) / np.sum(points**2, axis=-1)
    light = direct_light(depth[None], INTRINSICS, np.full((1, 24, 32), 0.3), matt[None])
    np.testing.assert_allclose(seen(light, power=power)[0], np.nan_to_num(closed), rtol=1e-4)


def test_a_varnish_shines_alike_on_dark_and_bright():
    reflectance = np.linspace(0.05, 1, 24 * 32).reshape(1, 24, 32)
    light = direct_light(np.ones((1, 24, 32)), INTRINSICS, reflectance, np.full((1, 24, 32), 0.8))
    added = (seen(light, lobe=0.6, exponent=3, pigment=0) - light.returns[0].strength) * light.range_m**2
    np.testing.assert_allclose(added, 0.6 * 0.5 * 0.8**3, rtol=1e-4)


def test_one_surface_may_be_glossy_and_the_others_matt():
    """A bar before a wall, both of the same incidence: with a lobe as with all surfaces, or as without."""
    bar = np.broadcast_to(np.abs(np.arange(32) - 14) < 5, (1, 24, 32))
    light = direct_light(np.where(bar, 0.8, 1.6), INTRINSICS)
    every, matt = seen(light, lobe=0.8, exponent=9), light.returns[0].strength
    found = seen(light, gloss=0.8, gloss_exponent=9, surface=2)
    np.testing.assert_allclose(found, np.where(bar, every, matt), rtol=1e-6)
    found = seen(light, gloss=0.8, gloss_exponent=9, surface=1)
    np.testing.assert_allclose(found, np.where(bar, matt, every), rtol=1e-6)
    found = seen(light, gloss=0.8, gloss_exponent=9, surface=2, matt=0.3)
    np.testing.assert_allclose(found, np.where(bar, every - 0.7 * matt, matt), rtol=1e-5)
    assert effect.reach(effect.at(gloss=1, surface=2).values) == (np.inf, np.inf)
    assert effect.reach(effect.at(lobe=1).values) == (0, 0)
    assert effect.strained(effect.at(gloss=0.8, gloss_exponent=2).values, None)
    assert not effect.strained(effect.at(gloss=0.8, gloss_exponent=9).values, None)


@pytest.mark.parametrize(("degrees_of_freedom", "slope"), [(0.5, 0.4), (2, 0.3), (40, 0.2), (90, 1)])
def test_another_shape_is_of_facets_with_slopes_by_students_t(degrees_of_freedom, slope):
    """Facets that face the sensor, against those that lie in the surface: densities by scipy."""
    angle = np.linspace(0, 1.3, 24 * 32)
    light = direct_light(np.ones((1, 24, 32)), INTRINSICS, None, np.cos(angle).reshape(1, 24, 32))
    tail = 1 / (degrees_of_freedom * slope**2)
    values = {"exponent": tail * (degrees_of_freedom + 2), "tail": tail}
    lobe = (seen(light, lobe=2.0, **values) - light.returns[0].strength) * light.range_m**2
    facets = multivariate_t([0, 0], slope**2 * np.eye(2), df=degrees_of_freedom)
    slopes = np.stack([np.tan(angle), np.zeros_like(angle)], axis=-1)
    np.testing.assert_allclose(lobe.ravel(), 2 * facets.pdf(slopes) / facets.pdf([0, 0]), rtol=1e-3, atol=1e-5)


def test_parts_of_surfaces_may_each_be_glossy():
    bar = np.broadcast_to(np.abs(np.arange(32) - 14) < 5, (1, 24, 32))
    light = direct_light(np.where(bar, 0.8, 1.6), INTRINSICS)
    several = seen(light, gloss_1=0.3, gloss_2=0.8, gloss_exponent=9)
    for number, lobe in ((1, 0.3), (2, 0.8)):
        alone = seen(light, gloss=lobe, gloss_exponent=9, surface=number)
        np.testing.assert_allclose(several[light.surfaces == number], alone[light.surfaces == number], rtol=1e-6)
    assert effect.reach(effect.at(gloss_2=1).values) == (np.inf, np.inf)


@given(cosine=st.floats(-1, 1, width=32), lobe=st.floats(-1, 100), exponent=st.floats(0, 500), power=st.floats(-1, 5))
def test_no_surface_sends_back_less_than_nothing(cosine, lobe, exponent, power):
    light = direct_light(np.ones((1, 1, 1)), np.eye(3), None, np.full((1, 1, 1), cosine))
    found = seen(light, lobe=lobe, exponent=exponent, power=power)
    assert np.isfinite(found).all()
    assert (found >= 0).all()


def test_a_lobe_below_0_is_darkest_straight_on():
    cosine = np.linspace(0.05, 1, 24 * 32).reshape(1, 24, 32)
    light = direct_light(np.ones((1, 24, 32)), INTRINSICS, None, cosine)
    ratio = seen(light, lobe=-0.6, exponent=5) / light.returns[0].strength
    np.testing.assert_allclose(ratio, 1 - 0.6 * cosine**4, rtol=1e-5)


@given(cosine=st.floats(-1, 1, width=32), lobe=st.floats(0, 100), exponent=st.floats(0, 500))
def test_what_faces_away_or_is_unknown_stays_dark_and_nothing_dims(cosine, lobe, exponent):
    light = direct_light(np.array([[[1.0, np.nan, 1.0]]]), np.eye(3), None, np.array([[[cosine, 1.0, np.nan]]]))
    found, matt = seen(light, lobe=lobe, exponent=exponent), light.returns[0].strength
    assert np.isfinite(found).all()
    assert (found >= matt).all()
    assert (found[matt == 0] == 0).all()


@pytest.mark.parametrize(
    ("lobe", "exponent", "pigment", "strained"),
    [(0.3, 5, 0.0, False), (0.3, 1, 0.0, True), (-0.3, 5, 0.5, True), (-0.3, 1, 1.0, False)],
)
def test_varnish_that_dims_or_is_matt_is_rather_reflectance(lobe, exponent, pigment, strained):
    assert effect.strained(effect.at(lobe=lobe, exponent=exponent, pigment=pigment).values, None) == strained


def test_a_small_surface_that_counts_suggest_is_tried_alone():
    """Six boards before a wall; the smallest shines, and is among the few that are tried beside the largest."""
    where = np.zeros((24, 44), int)
    for k in range(1, 7):
        where[2 : 21 - 2 * k, 6 * k : 6 * k + 4] = k
    depth = np.stack([np.where(where > 0, 1.0 + 0.03 * where, 2.0) - 0.05 * i for i in range(6)])
    light = direct_light(depth, np.array([[40.0, 0, 21.5], [0, 40.0, 11.5], [0, 0, 1]]))
    weights = np.random.default_rng(3).uniform(0, 1, (4, *where.shape))
    sent = light.returns[0].strength.astype(float)
    expected, counts = (
        3e3 * np.einsum("fvu,pvu->fp", sent * times, weights)[..., None]
        for times in (1.0, np.where(where == 6, 1.5, 1.0))
    )
    rendering = Rendering(light, SimpleNamespace(weights=weights), None, 1.0, background=0.0)
    tried = effect.starts(counts - expected, expected, rendering)
    small = {one["surface"] for one in tried if one["surface"] > 4}
    assert float(light.surfaces[0][where == 6][0]) in small
    assert len(small) <= 2
    assert {one["gloss_exponent"] for one in tried if one["surface"] in small} == set(
        effect.parameter("gloss_exponent").tries
    )
