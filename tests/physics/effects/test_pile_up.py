"""First-photon counting: against shots drawn one by one, and undone by the Coates correction."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects.ambient_pedestal import effect as pedestal
from physics.effects.pile_up import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from recordings.refusal import Refusal

CYCLES = 2e4


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock, 20.0)


def test_the_coates_correction_undoes_it(model):
    """Coates 1968: rate of bin t = -ln(1 - counts_t / (shots not yet stopped before t))."""
    nominal, seen = model.expected(3e3), model.expected(3e3, [effect.at(share=1)])
    waiting = CYCLES - (np.cumsum(seen, axis=-1) - seen)
    np.testing.assert_allclose(-np.log1p(-seen / waiting) * CYCLES, nominal, rtol=1e-9)
    assert seen.sum() < 0.9 * nominal.sum()


def test_shots_drawn_one_by_one_agree(model):
    nominal, seen = model.expected(3e3)[0, 1], model.expected(3e3, [effect.at(share=1)])[0, 1]
    rng = np.random.default_rng(5)
    shots = 20 * int(CYCLES)
    first = np.full(shots, -1)
    # From the last bin to the first: the earliest photon of a shot stands at the end.
    for t in range(len(nominal) - 1, -1, -1):
        first[rng.random(shots) < 1 - np.exp(-nominal[t] / CYCLES)] = t
    drawn = np.bincount(first[first >= 0], minlength=len(nominal)) / 20
    assert (np.abs(drawn - seen) < 5 * np.sqrt(seen / 20) + 1e-9).all()


@pytest.mark.parametrize("dead_bins", [4.0, 5.4, 9.0])
def test_a_channel_that_is_soon_alive_again_drawn_shot_by_shot(model, small, dead_bins):
    """Photons at times within their bins, one after the other; those of a dead channel are lost."""
    width = small.clock.bin_width_s
    seen = model.expected(3e3, [effect.at(share=1, dead=dead_bins * width)])[0, 1]
    nominal = model.expected(3e3)[0, 1]
    rng, shots = np.random.default_rng(8), 40 * int(CYCLES)
    ready, drawn = np.zeros(shots), np.zeros(len(nominal))
    for t, mean in enumerate(nominal / CYCLES):
        which = np.repeat(np.arange(shots), rng.poisson(mean, shots))
        times = t + rng.random(len(which))
        order = np.argsort(times)
        for shot, at in zip(which[order], times[order], strict=True):
            if at >= ready[shot]:
                ready[shot] = at + dead_bins
                drawn[t] += 1 / 40
    assert (np.abs(drawn - seen) < 5 * np.sqrt(seen / 40) + 1e-9).all()
    assert seen.sum() > model.expected(3e3, [effect.at(share=1)])[0, 1].sum()


def test_a_channel_that_is_dead_for_the_window_counts_first_photons(model, small):
    window = small.clock.bin_width_s * small.clock.bins
    found = model.expected(3e3, [effect.at(share=1, dead=window * 0.999999)])
    np.testing.assert_allclose(found, model.expected(3e3, [effect.at(share=1)]), rtol=1e-5)


@pytest.mark.parametrize(
    ("converter", "groups", "single"),
    [(-1, [[0, 1], [2, 3]], []), ([0, 1, 2, 1], [[1, 3]], [0, 2]), ([5, 0, 0, 0], [[1, 2, 3]], [0])],
)
def test_zones_of_one_converter_share_its_first_photon(model, converter, groups, single):
    """Together they register what one zone that receives the light of both would, each its part of every bin."""
    nominal = model.expected(3e3)
    shared = model.expected(3e3, [effect.at(share=1, partner=1, converter=converter)])
    for group in groups:
        light = nominal[:, group].sum(axis=1) / CYCLES
        waiting = np.exp(-np.cumsum(light, axis=-1) + light)
        both = CYCLES * waiting * (1 - np.exp(-light))
        np.testing.assert_allclose(shared[:, group].sum(axis=1), both, rtol=1e-9)
        parts = (shared / nominal)[:, group]
        np.testing.assert_allclose(parts, np.broadcast_to(parts[:, :1], parts.shape), rtol=1e-9)
    alone = model.expected(3e3, [effect.at(share=1)])
    np.testing.assert_allclose(shared[:, single], alone[:, single], rtol=1e-12)


@pytest.mark.parametrize("converter", [[0, 1, 0, 1], [0, 0, 0, 1]])
def test_data_tell_which_zones_share_a_converter(small, model, converter):
    nominal = model.expected(3e3)
    wanted = effect.at(share=1, partner=1, converter=converter)
    excess = model.expected(3e3, [wanted]) - nominal
    rendering = Rendering(small.light, small.footprints, small.clock, 3e3)
    starts = effect.starts(excess, nominal, replace(rendering, background=model.expected(0.0)[:, :, :1]))
    assert starts[0]["converter"].tolist() == converter


def test_no_zone_counts_more_than_its_channels_have_shots(model):
    flood = [effect.at(share=0.25), pedestal.at(level=1e6)]
    total = model.expected(1.0, flood).sum(axis=-1)
    np.testing.assert_allclose(total, CYCLES / 0.25, rtol=1e-6)


def test_earlier_bins_are_not_touched_by_later_ones(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    nominal = model.expected(3e3)
    ratio = np.where(nominal > 1, model.expected(3e3, [effect.at(share=1)]) / np.maximum(nominal, 1), np.nan)
    for row in ratio.reshape(-1, nominal.shape[-1]):
        assert (np.diff(row[np.isfinite(row)])[:2] < 0).all()
    assert np.nanmax(ratio) <= 1


def test_it_asks_for_the_shots(small):
    unknown = replace(small.light, laser_cycles=None)
    with pytest.raises(Refusal, match="laser_cycles is missing"):
        ForwardModel(unknown, small.footprints, small.clock).expected(1.0, [effect.at()])


def test_shots_that_nobody_counted_are_estimated(small, model):
    """The same counts as with their number known; what they are told with a number they need not be guessed."""
    unknown = replace(small.light, laser_cycles=None)
    guessed = ForwardModel(unknown, small.footprints, small.clock, 20.0)
    per_count = effect.at(per_count=[1 / CYCLES, 0.5 / CYCLES, 0, 1 / CYCLES])
    wanted = model.expected(3e3, [effect.at(share=[1, 0.5, 0, 1])])
    np.testing.assert_allclose(guessed.expected(3e3, [per_count]), wanted, rtol=1e-12)
    known, none = (Rendering(light, small.footprints, small.clock, 1.0) for light in (small.light, unknown))
    assert effect.strained(per_count.values, known)
    assert not effect.strained(per_count.values, none)
    assert not effect.strained(effect.at().values, known)
