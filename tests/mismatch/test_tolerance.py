"""Models that are far off: by how much, how far counts are trusted then, and what is named all the same."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mismatch.explain import explain
from mismatch.fit import expected_at, fit_nominal
from mismatch.open_simulation import simulation_of
from mismatch.poisson import deviance
from mismatch.tolerance import LEFT, error_leaving, in_words, is_near, still_off, tolerated
from physics.effects import find_effect
from physics.nominal import ForwardModel

BRIGHTER = 300.0


@pytest.fixture(scope="module")
def bright(rig):
    """bright(off, effect, seed): a simulation beside many photons, each cell off by a part `off`."""

    def make(off=0.2, effect=None, seed=1):
        rng = np.random.default_rng(seed)
        seen = simulation_of(rig.recording(np.ones((24, 4, 48))), rig.maps)[0]
        model = ForwardModel(seen.light, seen.footprints, seen.clock, seen.background)
        mean = model.expected(rig.gain * BRIGHTER, () if effect is None else (effect,))
        return replace(seen, counts=rng.poisson(mean * np.exp(off * rng.standard_normal(mean.shape))).astype(float))

    return make


@given(st.floats(0.02, 0.3), st.integers(0, 9))
def test_the_error_of_a_model_is_told_from_what_it_is_off_by(off, seed):
    """Of many counts a cell's deviance is the square of its relative error times them, trusted 1/ε² of one."""
    rng = np.random.default_rng(seed)
    mean = 10 ** rng.uniform(6, 8, (20, 4, 50))
    counts = rng.poisson(mean * (1 + off * np.clip(rng.standard_normal(mean.shape), -3, 3))).astype(float)
    assert error_leaving(1.0, counts, mean) == pytest.approx(off, rel=0.12)
    assert error_leaving(4.0, counts, mean) == pytest.approx(off / 2, rel=0.12)


def test_a_model_that_is_right_is_tolerated_nothing(drawn):
    simulation = drawn(1)
    assert tolerated(simulation) == (simulation, 0.0)
    strong = drawn(2, "zone_gain", factor=np.array([0.9, 1.1, 1.0, 1.0]))
    assert tolerated(strong) == (strong, 0.0)


def test_counts_are_trusted_as_far_as_leaves_a_misfit_of_ordinary_size(bright):
    simulation = bright(0.3)
    before = fit_nominal(simulation)
    tolerant, error = tolerated(simulation)
    assert in_words(error).split(" to ")[1].startswith(f"{100 * error:.0f} %")
    after = fit_nominal(tolerant)
    assert before.deviance > 10 * LEFT * simulation.counts.size
    assert after.deviance == pytest.approx(LEFT * simulation.counts.size, rel=0.05)
    assert (tolerant.trust <= 1).all()
    assert (tolerant.trust > 0).all()
    # Dim cells are trusted more than bright ones, and all of it can be taken back.
    order = np.argsort(simulation.counts.ravel())
    assert tolerant.trust.ravel()[order[:100]].min() > tolerant.trust.ravel()[order[-100:]].max()
    np.testing.assert_allclose(tolerant.as_recorded().counts, simulation.counts, rtol=1e-12)
    assert tolerant.trusting(None).trust is tolerant.trust
    part = tolerant.of(np.arange(5))
    assert part.trust is part.tolerance
    np.testing.assert_array_equal(part.counts, tolerant.counts[:5])


def test_what_trust_says_beside_a_tolerance_counts_with_it(bright):
    tolerant, _ = tolerated(bright(0.3))
    half = tolerant.trusting(np.full(tolerant.counts.shape, 0.5))
    np.testing.assert_allclose(half.trust, 0.5 * tolerant.tolerance)
    np.testing.assert_allclose(half.trusting(None).counts, tolerant.counts, rtol=1e-12)


def test_how_far_off_a_model_is_is_said_in_per_cent(bright):
    simulation = bright(0.2)
    nominal = fit_nominal(simulation)
    assert not is_near(simulation, nominal)
    assert "nominal model" in (said := still_off(simulation, nominal)).sentence
    assert float(said.sentence.split("off by ")[1].split(" %")[0]) == pytest.approx(20, abs=3)
    right = bright(0.0)
    assert is_near(tolerated(right)[0], fit_nominal(right))
    # Gains that fluctuate are no fault of the model's.
    gains = np.random.default_rng(2).normal(1, 0.05, (24, 1, 1))
    assert is_near(replace(right, counts=np.rint(right.counts * gains)), fit_nominal(right))


@pytest.mark.slow
def test_a_cause_is_named_beside_a_model_that_is_off_everywhere(bright):
    """Light passed from zone to zone, where every cell is off by a tenth: dim cells tell it, bright ones do not."""
    effect = find_effect("stray_light").at(share=0.05)
    simulation = bright(0.1, effect)
    assert fit_nominal(simulation).deviance > 100 * simulation.counts.size
    found = explain(simulation)
    verdict = found.verdict
    assert [named.id for named in verdict.effects] == ["stray_light"]
    assert verdict.verdict == "unknown"
    share = next(p for p in verdict.effects[0].parameters if p.name == "share")
    assert share.value == pytest.approx(0.05, rel=0.1)
    assert abs(share.value - 0.05) < 5 * share.sigma
    assert any("off by 1" in place.sentence for place in verdict.unexplained)
    assert sum("were trusted to" in note for note in verdict.notes) == 1
    # What is shown is in photons all the same.
    assert found.simulation.trust is None
    mean = expected_at(found.simulation, found.explained.forms, found.explained.x)
    assert verdict.heldout.explained == pytest.approx(deviance(found.simulation.counts, mean).mean(), rel=0.3)
    assert verdict.heldout.floor < 2 < verdict.heldout.explained < verdict.heldout.nominal


@pytest.mark.slow
def test_zones_in_another_order_are_named_by_all_their_photons(bright):
    """Far off as well, until they have their name; then nothing is."""
    found = explain(bright(0.0, find_effect("mirrored_zones").at(columns=1.0))).verdict
    assert found.verdict == "explained"
    assert [named.id for named in found.effects] == ["mirrored_zones"]
    assert found.gap_closed > 0.999
