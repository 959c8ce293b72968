"""Which forms are fitted for what they promise, and in which other ways those that come near."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.candidates import candidates_of
from mismatch.fit import fit_nominal
from mismatch.form import forms_of
from mismatch.poisson import deviance
from mismatch.promising import candidates_among, most_promising, other_ways, to_be_gained
from mismatch.ranking import ranked
from mismatch.score import Score
from mismatch.work import MOST_RENDERINGS, Work
from physics.effects import find_effect

from .conftest import BINS, ZONES


@pytest.mark.parametrize("level", [1.0, 30.0])
def test_noise_leaves_little_to_be_gained_and_a_misfit_what_it_makes(level):
    """Counts drawn around what is expected, few or many; and around other ones, whose divergence is to be gained."""
    rng = np.random.default_rng(4)
    mean = np.full((40, 9, 60), level)
    truth = mean * np.where(np.arange(60) < 30, 1.5, 1.0)

    def fitted(counts):
        return SimpleNamespace(expected=mean, deviance=float(deviance(counts, mean).sum()))

    scatter = np.sqrt(np.var([fitted(rng.poisson(mean)).deviance for _ in range(30)]))
    assert 0 < to_be_gained(fitted(rng.poisson(mean))) < 8 * scatter
    due = 2 * float((truth * np.log(truth / mean) - truth + mean).sum())
    # Where few are expected noise itself makes more than it would, were the fit right.
    assert due - 2 * scatter < to_be_gained(fitted(rng.poisson(truth))) < 5 * due


def scores(*promised):
    """Scores of forms of effects by name, that look or not, promise so much, have so many numbers; best first."""
    made = []
    for name, looks, gain, *numbers in sorted(promised, key=lambda one: -one[2]):
        effect = SimpleNamespace(id=name)
        # By zone, as the name says.
        own = ("passed",) if name == "by zone" else ()
        alike = {"own": own, "strengths": ("passed",)}
        many = range(*(numbers or [2]))
        form = SimpleNamespace(effect=effect, **alike, looks=looks, coordinates=many, free=many)
        made.append(Score(form, np.ones(1), gain, 0, 0.0, 0.0))
    return made


def test_what_promises_more_than_there_is_to_gain_hides_nothing_that_looks():
    found = scores(
        ("aliasing", False, 9e5),
        ("other", False, 8e5),
        ("other", False, 7e5),
        ("other", False, 6e5),
        ("other", True, 2e4),
    )
    kept = most_promising(found, 3e4)
    assert [(one.form.effect.id, one.gain) for one in kept] == [
        ("aliasing", 9e5), ("other", 8e5), ("other", 7e5), ("other", 2e4)
    ]  # fmt: skip
    # Were there as much to gain as is promised, what looks would be too little.
    assert len(most_promising(found)) == 3


@pytest.mark.parametrize(("numbers", "kept"), [(128, {"widths", "fog"}), (1, {"widths"})])
def test_what_many_numbers_gain_from_noise_hides_nothing(numbers, kept):
    """A width for each of 128 bins gains 128 where nothing is amiss; beyond that, 72, it hides no gain of 52."""
    widths, fog = scores(("widths", False, 200.0), ("fog", False, 52.0))
    found = most_promising([replace(widths, dof=numbers), replace(fog, dof=2)])
    assert {one.form.effect.id for one in found} == kept


def test_what_has_far_fewer_numbers_is_tried_beside_two_that_promise_more():
    found = scores(
        ("ways", False, 90.0, 8), ("ways", False, 89.0, 14), ("ways", False, 88.0, 7), ("ways", False, 87.0, 4),
        ("ways", False, 86.0, 3), ("ways", False, 50.0, 2),
    )  # fmt: skip
    assert [one.gain for one in most_promising(found)] == [90.0, 89.0, 87.0]


def test_what_goes_straight_is_tried_beside_what_is_curved_where_zones_have_their_own():
    """A number for each of 12 zones and one way for all: curved, it has not twice as many numbers."""
    found = scores(("ways", False, 90.0, 20), ("ways", False, 89.0, 20), ("ways", False, 88.0, 13))
    for one, parameters in zip(found, (8, 8, 2), strict=True):
        one.form.free = range(parameters)
    assert [one.gain for one in most_promising(found)] == [90.0, 89.0, 88.0]
    found[2].form.free = range(5)
    assert [one.gain for one in most_promising(found)] == [90.0, 89.0]


def test_one_value_for_all_zones_is_tried_beside_a_value_for_each():
    found = scores(*(("by zone", False, gain) for gain in (9.0, 8.0, 7.0)))
    alike = scores(("by zone", False, 6.0), ("by zone", False, 5.0))
    for one in alike:
        one.form.own = ()
    assert [one.gain for one in most_promising([*found, *alike])] == [9.0, 8.0, 6.0]
    # Also where another way of being there, with a value for each, has come between.
    found[2].form.strengths = ("counts",)
    assert [one.gain for one in most_promising([*found, *alike])] == [9.0, 8.0, 7.0, 6.0]
    # And where that has the same value for all.
    found[2].form.own = ()
    assert [one.gain for one in most_promising([*found, *alike])] == [9.0, 8.0, 7.0, 6.0]


def test_each_way_of_being_there_is_tried():
    found = scores(*(("other", False, gain) for gain in (9.0, 8.0, 7.0, 6.0, 5.0, 4.0)))
    for one, strength in zip(found, ("passed", "passed", "passed", "covered", "covered", "one"), strict=True):
        one.form.strengths = (strength,)
    assert [one.gain for one in most_promising(found)] == [9.0, 8.0, 6.0, 4.0]


def fitted(name, free, criterion):
    """A candidate as far as its form and what it came to."""
    return SimpleNamespace(form=SimpleNamespace(effect=SimpleNamespace(id=name), free=(free,)), criterion=criterion)


def promising(name, free, gain, own=()):
    """A score of a form with one free parameter."""
    (one,) = scores((name, False, gain))
    one.form.free, one.form.own = (free,), own
    return one


def test_what_came_near_the_best_is_tried_in_its_other_ways():
    """Each once, where it promises most; none of the best, of what is far from it, by zone, or fitted already."""
    before = SimpleNamespace(deviance=10_000.0)
    found = [fitted("glass", "share", 2000), fitted("fog", "layer", 2700), fitted("echo", "delay", 2900)]
    told = [
        promising("fog", "layer", 9e4),
        promising("fog", "each", 8e4, own=("each",)),
        promising("glass", "trail", 7e4),
        promising("fog", "overlap", 6e4),
        promising("fog", "overlap", 5e4),
        promising("echo", "trail", 4e4),
        promising("fog", "growth", 3e4),
    ]
    assert [(s.form.free, s.gain) for s in other_ways(before, told, found)] == [(("overlap",), 6e4), (("growth",), 3e4)]
    # A tenth of what was gained is near, or 120 where that is less.
    little = SimpleNamespace(deviance=2500.0)
    assert [s.form.free for s in other_ways(little, told, [found[0], fitted("echo", "delay", 2119)])] == [("trail",)]
    assert not other_ways(little, told, [found[0], fitted("echo", "delay", 2121)])


def test_a_way_that_promises_less_is_found_beside_another_effect(drawn):
    """Thin fog that the sensor sees from some range on: forms that begin with a layer promise more, and glass wins."""
    simulation = drawn(7, "scattering_medium", extinction=0.02, albedo=1.0, overlap=0.3, blind=0.1)
    train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
    names = ("scattering_medium", "cover_glass_crosstalk")
    forms = [form for name in names for form in forms_of(find_effect(name), {"zone": ZONES, "bin": BINS})]
    nominal = fit_nominal(train)
    told, _ = ranked(train, nominal, forms)
    first = candidates_of(train, test, nominal, most_promising(told, to_be_gained(nominal)))
    assert first[0].form.effect.id == "cover_glass_crosstalk"
    found = candidates_among(train, test, nominal, told)
    assert found[0].form.free == ("extinction", "albedo", "overlap", "blind")
    assert first[0].criterion > found[0].criterion + 10
    assert found == sorted(found, key=lambda c: c.criterion)
    # Where enough was done what is fitted is only what promises most.
    busy = candidates_among(replace(train, work=Work(2 * MOST_RENDERINGS)), test, nominal, told)
    assert {c.form for c in busy} == {c.form for c in first}
    # Nothing that was fitted is fitted again.
    assert len({(c.form.free, c.form.own) for c in found}) == len(found)
