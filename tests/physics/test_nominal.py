"""The nominal model against an independent implementation of the same page, and against its own slow form."""

import numpy as np
import pytest

from physics.clock import Clock
from physics.effects import all_effects, find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import ImpulseResponse
from recordings.files import load
from recordings.maps_file import load_maps
from recordings.refusal import Refusal

from .conftest import slow_model

MAPS = "spad_calib_3x3_longrange_bins15_35.npz"


@pytest.fixture(scope="module")
def conformance(shared_data, published_maps):
    seen = load(shared_data / "conformance" / "recording.npz")
    truth = np.load(shared_data / "conformance" / "expected.npz")
    light = direct_light(seen.depth_m, seen.intrinsics, seen.reflectance, seen.incidence_cosine)
    where = footprints(load_maps(published_maps / MAPS), seen.depth_m.shape[1:])
    pulse = ImpulseResponse(seen.irf_time_s, seen.irf)
    clock = Clock(float(seen.bin_width_s), seen.counts.shape[2], seen.time_zero_s, pulse)
    model = ForwardModel(light, where, clock, seen.background_counts)
    return seen, truth["expected"], model.expected(float(truth["gain"]))


def test_expected_counts_are_those_of_the_independent_implementation(conformance):
    _, truth, found = conformance
    enough = truth >= 50
    assert enough.sum() > 1000
    # 0.3 % is asked for; both are exact up to float32.
    assert np.abs(found / truth - 1)[enough].max() < 1e-5


def test_the_recording_is_poisson_around_them(conformance):
    seen, _, expected = conformance
    counts = seen.counts.astype(float)
    deviance = 2 * (expected - counts + np.where(counts > 0, counts * np.log(np.maximum(counts, 1) / expected), 0))
    assert 0.97 < deviance.mean() < 1.04


def test_signal_is_gain_times_the_sum_and_background_is_added(small):
    model = ForwardModel(small.light, small.footprints, small.clock, np.array([1.0, 2, 3, 4]))
    clock = small.clock
    signal = slow_model(small.light, small.footprints.weights, clock.bin_width_s, 40, clock.time_zero_s, clock.pulse)
    expected = 7 * signal + np.array([1.0, 2, 3, 4])[:, None]
    np.testing.assert_allclose(model.expected(7.0), expected, rtol=1e-6)


def test_what_is_kept_between_calls_changes_nothing(small):
    kept = ForwardModel(small.light, small.footprints, small.clock, 2.0)
    rng = np.random.default_rng(0)
    for _ in range(12):
        gain = rng.choice([5.0, 80.0])
        effects = [e.at() for e in all_effects().values() if rng.random() < 0.5]
        fresh = ForwardModel(small.light, small.footprints, small.clock, 2.0).expected(gain, effects)
        np.testing.assert_array_equal(kept.expected(gain, effects), fresh)


def test_footprints_are_made_once_however_bright_things_are_but_not_wherever_they_are(small, monkeypatch):
    kind, made = type(find_effect("parallax")), []
    original = kind.footprints
    monkeypatch.setattr(kind, "footprints", lambda *given: made.append(1) or original(*given))
    model, parallax = ForwardModel(small.light, small.footprints, small.clock), find_effect("parallax").at()
    for contrast in (0.1, 0.2, 0.3):
        model.expected(1.0, [parallax, find_effect("reflectance_map").at(contrast=contrast)])
    assert len(made) == 1
    model.expected(1.0, [parallax, find_effect("time_lag").at(lag=0.03)])
    assert len(made) == 2


def test_effects_compose_in_the_order_of_their_stages_however_they_are_named(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    settings = [find_effect(i).at() for i in ("pile_up", "ambient_pedestal", "impulse_tail")]
    together = model.expected(1e3, settings)
    np.testing.assert_array_equal(model.expected(1e3, settings[::-1]), together)
    # The pedestal is light: it takes part in the pile-up.
    alone = model.expected(1e3, settings[2:])
    assert (together.sum(axis=2) <= 2e4).all()
    assert together[..., -1].max() < 10 + alone[..., -1].max()


def test_counts_that_are_no_numbers_are_refused_before_effects_are_given_them(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    assert np.isfinite(model.expected(1e300)).all()
    with pytest.raises(Refusal, match="expected counts are not finite at a gain of inf"):
        model.expected(np.inf, [find_effect("bin_nonlinearity").at()])
