"""Names of what was found: gains on held-out frames, parameters, rivals and where they act."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import poisson

from mismatch import naming
from mismatch.cost import price
from mismatch.fit import fit, fit_nominal, on_others
from mismatch.form import forms_of
from mismatch.gained import gained
from mismatch.located import locate_effects
from mismatch.naming import contested, estimates, name_effects, standing
from mismatch.rivals import Rival, _best_of_each, evidence, probabilities
from mismatch.selection import Round, coordinates, select, without
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48, "edge": 47}
THREE = {"ambient_pedestal": {"level": 3.0}, "time_zero_offset": {"delay": 1.5e-10}, "impulse_tail": {"share": 0.03}}


def forms(*names):
    return [form for name in names for form in forms_of(find_effect(name), SIZES)]


@pytest.fixture(scope="module")
def parts(drawn):
    simulation = drawn(1, "ambient_pedestal", level=2.0)
    return simulation, simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))


@pytest.fixture(scope="module")
def pedestal(parts):
    train = parts[1]
    form = forms("ambient_pedestal")[0]
    return fit(train, (form,), np.concatenate([fit_nominal(train).x, form.at_start()]))


def test_the_gain_is_twice_the_log_likelihood_ratio_on_held_out_frames(parts, pedestal):
    _, train, test = parts
    less = without(train, pedestal, pedestal.forms[0])
    won = gained(test, less, pedestal)
    now, then = test.expected(less.gain), test.expected(pedestal.gain, pedestal.settings)
    ratio = poisson.logpmf(test.counts, then).sum() - poisson.logpmf(test.counts, now).sum()
    assert won.observed == pytest.approx(2 * ratio, rel=1e-6)
    # Its mean, were the pedestal there: the counts replaced by what is expected, less the noise that its one parameter
    # has fitted elsewhere; and z is its root, about.
    assert won.expected == pytest.approx(2 * (then * np.log(then / now) - then + now).sum() - 2, rel=1e-6)
    assert won.observed == pytest.approx(won.expected, abs=6 * np.sqrt(won.expected))
    assert won.z == pytest.approx(np.sqrt(won.expected), rel=0.25)


def test_estimates_are_in_the_units_of_their_parameters(drawn):
    form = forms("impulse_tail")[0]
    simulation = drawn(2, "impulse_tail", share=0.15, tau=4e-10)
    fitted = fit(simulation, (form,), np.concatenate([fit_nominal(simulation).x, form.at_start()]))
    share, tau = estimates(fitted, form)
    assert (share.name, share.unit, tau.name, tau.unit) == ("share", "1", "tau", "s")
    assert share.value == fitted.settings[0].values["share"]
    assert tau.value == fitted.settings[0].values["tau"]
    # A coordinate of tau is its logarithm, one of the share a unit of 0.1.
    assert tau.sigma == pytest.approx(tau.value * np.sqrt(fitted.covariance[2, 2]))
    assert share.sigma == pytest.approx(0.1 * np.sqrt(fitted.covariance[1, 1]))


def test_only_the_cause_is_selected_and_named(parts):
    simulation, train, test = parts
    tried = forms("ambient_pedestal", "stray_light", "impulse_tail", "zone_gain")
    rounds = select(train, test, tried)
    assert rounds[0].chosen is not None
    assert rounds[-1].chosen is None
    judged, contests = contested(train, test, rounds[-1].before, rounds, tried)
    assert [form.effect.id for form in judged.forms] == ["ambient_pedestal"]
    explained = fit(simulation, judged.forms, judged.x, judged.frame_gain_sigma)
    (named,) = name_effects(train, test, judged, contests, explained, rounds[0].tried)
    assert named.id == "ambient_pedestal"
    assert named.p_value < 1e-6
    (place,) = locate_effects(simulation, explained, (named,))
    assert place.share == 1
    assert place.p_value == named.p_value
    assert place.zones == (0, 1, 2, 3)


def test_of_nothing_nothing_is_selected(drawn):
    simulation = drawn(3)
    rounds = select(
        simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2)), forms("stray_light", "zone_gain")
    )
    assert len(rounds) == 1
    assert rounds[0].chosen is None


def test_without_an_effect_the_rest_is_fitted_again(parts, pedestal):
    less = without(parts[1], pedestal, pedestal.forms[0])
    assert less.forms == ()
    assert less.deviance == pytest.approx(fit_nominal(parts[1]).deviance, abs=0.1)
    assert len(coordinates(pedestal, pedestal.forms[0])) == 1


def test_a_parameter_costs_the_logarithm_of_the_number_of_histograms(parts):
    assert price(parts[1]) == pytest.approx(np.log(12 * 4))


def test_probabilities_are_those_of_bayes(pedestal):
    found = [Rival(pedestal.forms[0], pedestal, evidence) for evidence in (-1000.0, -1002.0, -1010.0)]
    weights = np.exp([0.0, -1.0, -5.0])
    np.testing.assert_allclose(probabilities(found), weights / weights.sum())


def test_an_effect_is_no_look_alike_of_itself(pedestal):
    """Of each effect the likeliest form stands, in the order of likelihood."""
    one, two = pedestal.forms[0], forms("impulse_tail")[0]
    found = [
        Rival(one, pedestal, -9.0),
        Rival(two, pedestal, -8.0),
        Rival(one, pedestal, -7.0),
        Rival(two, pedestal, -10.0),
    ]
    assert _best_of_each(found) == [found[2], found[1]]
    # One whose charge alone keeps it back is more probable than one that fits worse.
    charged = Rival(two, pedestal, -30.0, strain=25.0)
    assert _best_of_each([found[2], Rival(two, pedestal, -14.0), charged]) == [found[2], charged]
    assert _best_of_each([found[2], found[1], charged]) == [found[2], found[1]]


def test_a_stretched_name_that_fits_as_well_is_said_to_be_possible(pedestal):
    """Its charge decides who wins, not how sure one may be of that."""
    form = pedestal.forms[0]
    found = [
        Rival(form, pedestal, evidence, strain) for evidence, strain in ((-1000.0, 0), (-1015.0, 25), (-1030.0, 25))
    ]
    odds = probabilities(found)[1:] / probabilities(found)[0]
    np.testing.assert_allclose(odds, [1 / 16, 1 / 16])
    far = probabilities([found[0], Rival(form, pedestal, -1045.0, 25)])
    np.testing.assert_allclose(far[1] / far[0], np.exp(-10))
    # Nor does it tell between two that are stretched alike, nor make a near one less likely than it was.
    alike = probabilities([Rival(form, pedestal, e, 25) for e in (-1000.0, -1003.0)])
    np.testing.assert_allclose(alike[1] / alike[0], np.exp(-1.5))
    near = probabilities([found[0], Rival(form, pedestal, -1001.0, 25)])
    np.testing.assert_allclose(near[1] / near[0], np.exp(-0.5))


def test_what_frames_held_out_do_not_miss_does_not_stand(parts, pedestal):
    _, train, test = parts
    (tail, *_) = forms("impulse_tail")
    # There is no tail: one that stayed where it began fits nothing better.
    both = fit(train, (*pedestal.forms, tail), np.concatenate([pedestal.x, tail.at_start()]), most_steps=0)
    assert [form.effect.id for form in standing(train, test, both).forms] == ["ambient_pedestal"]
    assert standing(train, test, pedestal) is pedestal


def test_one_of_three_is_to_be_worth_more_than_one_of_two(rig, simulated):
    """A tail that gains less than a hundred stands beside a pedestal alone, and not beside an offset as well."""
    there = [find_effect(name).at(**at) for name, at in THREE.items()]
    simulation = simulated(np.random.default_rng(6).poisson(rig.expected(*there)))
    train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
    three = tuple(forms(name)[0] for name in THREE)
    fitted = fit(train, three, np.concatenate([fit_nominal(train).x, *(form.at_start() for form in three)]))
    lost = [on_others(test, without(train, fitted, form))[1] - on_others(test, fitted)[1] for form in three]
    assert 35 < lost[2] < 80
    assert min(lost[:2]) > 150
    assert standing(train, test, fitted).forms == three[:2]
    two = without(train, fitted, three[0])
    assert standing(train, test, two) is two


def test_what_few_of_the_frames_held_out_show_stands(rig, simulated, pedestal):
    """Pulses that have tails from the 14th frame on, of which one is held out."""
    there = find_effect("ambient_pedestal").at(level=2.0), find_effect("impulse_tail").at(share=0.06, since=13.5 / 15)
    simulation = simulated(np.random.default_rng(5).poisson(rig.expected(*there)))
    held = np.array([0, 1, 2, 4, 6, 8, 10, 12, 16])
    train, test = simulation.of(np.setdiff1d(np.arange(24), held)), simulation.of(held)
    tail = replace(forms("impulse_tail")[0], given=("since",))
    tail = replace(tail, start=tail.start | {"since": 13.5 / 15})
    x = np.concatenate([pedestal.x, tail.at_start()])
    both = fit(train, (*pedestal.forms, tail), x)
    less = without(train, both, tail)
    assert less.deviance - both.deviance > 150
    assert 5 < on_others(test, less)[1] - on_others(test, both)[1] < 35
    assert standing(train, test, both) is both


def test_what_frames_held_out_fit_better_without_does_not_stand(rig, simulated):
    """Pulses that have tails in the frames that choose alone, however much it gains there."""
    there = find_effect("ambient_pedestal").at(level=2.0), find_effect("impulse_tail").at(share=0.15)
    chose = np.arange(0, 24, 2)
    expected = np.array(rig.expected(there[0]))
    expected[chose] = rig.expected(*there)[chose]
    simulation = simulated(np.random.default_rng(5).poisson(expected))
    train, test = simulation.of(chose), simulation.of(chose + 1)
    both = (forms("ambient_pedestal")[0], forms("impulse_tail")[0])
    both = fit(train, both, np.concatenate([fit_nominal(train).x, *(form.at_start() for form in both)]))
    less = without(train, both, both.forms[1])
    assert less.deviance - both.deviance > 1000
    assert on_others(test, less)[1] - on_others(test, both)[1] < -35
    assert [form.effect.id for form in standing(train, test, both).forms] == ["ambient_pedestal"]


def test_many_parameters_are_not_expected_to_gain_the_noise_they_fitted(drawn):
    """Forty-eight widths fitted on half of the frames gain what is expected of them on the other half."""
    pattern = 0.06 * np.random.default_rng(2).normal(size=48)
    form = next(f for f in forms("bin_nonlinearity") if f.name == "bin_nonlinearity(width[])")
    short = []
    for seed in range(6):
        simulation = drawn([7, seed], "bin_nonlinearity", width=pattern)
        train, test = simulation.of(np.arange(0, 24, 2)), simulation.of(np.arange(1, 24, 2))
        nominal = fit_nominal(train)
        found = gained(test, nominal, fit(train, (form,), np.concatenate([nominal.x, form.at_start()])))
        assert found.expected > 200
        short.append(found.expected - found.observed)
    assert abs(np.mean(short)) < 45


@pytest.mark.parametrize(
    ("likelier", "gains", "names"),
    [
        (30.0, 90.0, ["stray_light"]),
        (-30.0, 90.0, ["ambient_pedestal", "zone_gain"]),
        (-30.0, 50.0, ["ambient_pedestal"]),
        (30.0, 50.0, ["stray_light"]),
    ],
)
def test_what_takes_up_two_is_named_where_it_is_likelier_than_both(
    parts, pedestal, monkeypatch, likelier, gains, names
):
    """Of a name and what was too little for one, and a rival that beats the first alone; too little for any, it is
    not named with the first either.
    """
    _, train, test = parts
    (little,) = [form for form in forms("zone_gain") if form.own and form.free == ("factor",)]
    both = fit(train, (*pedestal.forms, little), np.concatenate([pedestal.x, little.at_start()]))
    other = replace(pedestal, forms=forms("stray_light")[:1])

    def found(train, test, now, form, *_):
        itself = Rival(form, now, evidence(train, test, now))
        if now is not pedestal:
            return [itself]
        return [Rival(other.forms[0], other, evidence(train, test, both) + likelier), itself]

    monkeypatch.setattr(naming, "rivals", found)
    monkeypatch.setattr(naming, "standing", lambda train, test, judged: judged)
    last = Round(pedestal, (), 1, (), None, SimpleNamespace(fit=both, observed=gains))
    judged, contests = contested(train, test, pedestal, [last], [])
    assert [form.effect.id for form in judged.forms] == names
    assert [contest.form.effect.id for contest in contests] == names
