"""Falloff against scenes whose strength is that by formula."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import expon, rayleigh, uniform

from physics.effects.range_falloff import effect
from physics.light import Return
from physics.nominal import ForwardModel


def agrees_with_strength(small, setting, strength, tolerance):
    """The effect over a nominal scene, against a scene whose direct light has that strength [frame, row, column]."""
    light = replace(small.light, returns=(Return(small.light.returns[0].range_m, strength.astype(np.float32)),))
    found = ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [setting])
    expected = ForwardModel(light, small.footprints, small.clock).expected(1e3)
    np.testing.assert_allclose(found, expected, atol=tolerance * expected.max())


@pytest.mark.parametrize(("overlap", "steepness"), [(0.0, 2), (0.1, 2), (0.3, 2), (1.0, 2), (0.5, 4), (0.8, 3)])
def test_it_is_a_scene_of_that_strength(small, overlap, steepness):
    """(1/r²) / (1 + (r0/r)^n) = r^(n − 2) / (r^n + r0^n)."""
    direct = small.light.returns[0]
    r = direct.range_m.astype(float)
    closed = direct.strength * r**steepness / (r**steepness + overlap**steepness)
    agrees_with_strength(small, effect.at(overlap_range=overlap, steepness=steepness), closed, 2e-4)


def test_a_zone_of_its_own_overlap_leaves_the_others(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found, nominal = model.expected(1e3, [effect.at(overlap_range=[0, 0.5, 0, 0])]), model.expected(1e3)
    np.testing.assert_allclose(found[:, [0, 2, 3]], nominal[:, [0, 2, 3]])
    assert (found[:, 1].sum(axis=-1) < nominal[:, 1].sum(axis=-1)).all()


@pytest.mark.parametrize(("overlap", "steepness", "sudden"), [(0.4, 2, 1.0), (0.8, 2, 0.3), (0.6, 4, 1.0)])
def test_of_a_gaussian_beam_what_lies_within_a_radius_is_caught(small, overlap, steepness, sudden):
    """Rayleigh's distribution by scipy: (r/r0)^n is half the square of as many standard deviations."""
    direct = small.light.returns[0]
    ratio = (direct.range_m.astype(float) / overlap) ** steepness
    caught = sudden * rayleigh.cdf(np.sqrt(2 * ratio)) + (1 - sudden) * ratio / (1 + ratio)
    agrees_with_strength(
        small, effect.at(overlap_range=overlap, steepness=steepness, sudden=sudden), direct.strength * caught, 2e-4
    )


@pytest.mark.parametrize(("overlap", "sudden"), [(0.8, 2.0), (0.8, 1.4)])
def test_a_beam_may_move_evenly_into_the_field(small, overlap, sudden):
    direct = small.light.returns[0]
    ratio = direct.range_m.astype(float) / overlap
    caught = (2 - sudden) * expon.cdf(ratio) + (sudden - 1) * uniform.cdf(ratio)
    agrees_with_strength(
        small, effect.at(overlap_range=overlap, steepness=1, sudden=sudden), direct.strength * caught, 3e-4
    )


@pytest.mark.parametrize(("blur", "focus_m"), [(0.8, 1.0), (2.0, 0.7)])
def test_what_is_in_focus_loses_nothing(small, blur, focus_m):
    """A thin lens with its detector in the image of focus_m: the blur's radius goes with |1/r - 1/focus_m|."""
    direct = small.light.returns[0]
    r = direct.range_m.astype(float)
    closed = direct.strength / (1 + (blur * (focus_m - r) / (r * focus_m)) ** 2)
    agrees_with_strength(small, effect.at(overlap_range=blur, focus=1 / focus_m), closed, 3e-4)


def test_an_exponential_begins_where_it_loses_some_of_what_is_near(small):
    starts = effect.starts(None, None, SimpleNamespace(light=small.light))
    near = np.quantile(small.light.range_m[small.light.range_m > 0], 0.05)
    sudden = [start for start in starts if "sudden" in start]
    assert [start["sudden"] for start in sudden] == [1.0, 1.0]
    for start in sudden:
        lost = np.exp(-((near / start["overlap_range"]) ** 2))
        assert 0.05 < lost < 0.4
    for start in starts[2:]:
        # Of the ranges there are some are in focus, and none loses more than a tenth or so.
        lost = (start["overlap_range"] * (1 / small.light.range_m[small.light.range_m > 0] - start["focus"])) ** 2
        assert lost.min() < 0.03
        assert 0.05 < np.quantile(lost, 0.97) < 0.3
    dark = SimpleNamespace(range_m=np.zeros((1, 2, 2)))
    assert effect.starts(None, None, SimpleNamespace(light=dark)) == []


@pytest.mark.parametrize(
    ("exponent", "stretched"), [(0.8, False), ([0.1, 0.3, 0.2, 0.4], False), ([1, 0, -1, 0], True)]
)
def test_powers_that_zones_do_not_share_are_factors_of_their_own(exponent, stretched):
    assert effect.strained(effect.at(exponent=exponent).values, None) == stretched
