"""Interference against where its pulse's mean must lie, and its sum."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects.interference import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock, 4.0)


def more(model, **values):
    return model.expected(1e3, [effect.at(**values)]) - model.expected(1e3)


def test_its_counts_are_those_given_in_each_zone(model):
    counts = np.array([0, 10, 200, 1e4])
    found = more(model, counts=counts, arrival=3e-9).sum(axis=-1)
    np.testing.assert_allclose(found, np.broadcast_to(counts, found.shape), rtol=1e-5, atol=1e-8)


def test_its_mean_arrival_wanders_by_drift_times_time(model, small):
    found = more(model, arrival=2e-9, drift=1e-8)[:, 0]
    centres = (np.arange(found.shape[-1]) + 0.5) * small.clock.bin_width_s
    mean = found @ centres / found.sum(axis=-1)
    np.testing.assert_allclose(np.diff(mean), 1e-8 * 0.1, atol=2e-12)


def test_what_has_left_returns_after_its_period(model, small):
    window = small.clock.bins * small.clock.bin_width_s
    period = 0.7 * window
    found = more(model, counts=50, arrival=0.1 * window, drift=0, period=period)
    alone = more(model, counts=50, arrival=0.1 * window, drift=0)
    again = more(model, counts=50, arrival=0.8 * window, drift=0)
    np.testing.assert_allclose(found, alone + again, atol=0.2)
    later = more(model, counts=50, arrival=0.1 * window + 3 * period, drift=0, period=period)
    np.testing.assert_allclose(later, found, atol=1e-6)


def test_it_enters_the_window_without_a_jump(model, small):
    arrivals = np.linspace(-8e-9, 2e-9, 201)
    totals = np.array([more(model, arrival=a, drift=0)[0, 0].sum() for a in arrivals])
    assert totals[0] < 1e-2
    assert totals[-1] == pytest.approx(100, rel=1e-3)
    # In 50 ps no more comes in than the fullest 50 ps of the pulse hold.
    most = np.diff(small.clock.pulse.cumulative(np.arange(-1e-9, 4e-9, 25e-12)))
    assert np.diff(totals).max() < 100 * 2.2 * most.max()


def test_outside_the_window_it_is_not_seen(model):
    assert np.abs(more(model, arrival=30e-9, drift=0)).max() < 1e-6


def test_a_pulse_that_roams_is_anywhere_where_nothing_was_recorded(model, small):
    found = more(model, roaming=[0, 10, 200, 1e4], present=0.5)
    assert np.ptp(found, axis=0).max() < 1e-9
    # But for what falls out at the ends of the window.
    inner = found[0, 3, 12:-3]
    np.testing.assert_allclose(inner, 0.5 * 1e4 / small.clock.bins, rtol=0.02)
    np.testing.assert_allclose(found[0, 1], 1e-3 * found[0, 3], rtol=1e-9)


def test_a_pulse_that_roams_is_where_the_recording_has_it(small):
    shares = small.clock.pulse.in_bins(np.array([3e-9, 5e-9, 8e-9]), small.clock.bins, small.clock.bin_width_s)
    bare = ForwardModel(small.light, small.footprints, small.clock, 4.0).expected(1e3)
    recorded = bare + 500 * shares[:, None]
    model = ForwardModel(small.light, small.footprints, small.clock, 4.0, recorded)
    found = model.expected(1e3, [effect.at(roaming=500, present=0.9)]) - bare
    # Places are half a bin apart.
    assert np.abs(found.argmax(axis=-1) - shares.argmax(axis=-1)[:, None]).max() <= 1
    np.testing.assert_allclose(found.sum(axis=-1), 500, rtol=0.01)


def test_a_longer_pulse_has_the_same_mean_and_the_variance_it_is_given(model, small):
    centres = (np.arange(small.clock.bins) + 0.5) * small.clock.bin_width_s

    def moments(**longer):
        found = more(model, arrival=5e-9, drift=0.0, **longer)[0, 0]
        mean = found @ centres / found.sum()
        return mean, found @ (centres - mean) ** 2 / found.sum()

    (mean, variance), (later, wider) = moments(), moments(longer=6e-10)
    assert later == pytest.approx(mean, abs=2e-12)
    assert wider - variance == pytest.approx(3.6e-19, rel=0.02)


def test_slopes_of_what_it_saw_are_those_of_its_evidence(small):
    shares = small.clock.pulse.blurred(5e-10).in_bins(
        np.array([3e-9, 5e-9, 8e-9]), small.clock.bins, small.clock.bin_width_s
    )
    bare = ForwardModel(small.light, small.footprints, small.clock, 4.0).expected(1e3)
    recorded = np.random.default_rng(1).poisson(bare + 80 * shares[:, None]).astype(float)
    start = Rendering(small.light, small.footprints, small.clock, 1e3, background=np.full((4, 1), 4.0))
    seen = replace(start, expected=bare, recorded=recorded)

    def evidence(values):
        return effect._placed(values, seen).evidence.sum() / 2

    values = effect.at(roaming=60.0, present=0.7, longer=4e-10).values
    slopes = effect.look(values, seen).slopes
    for name, step in (("present", 1e-3), ("longer", 1e-11), ("roaming", 0.1)):
        apart = evidence({**values, name: values[name] + step}) - evidence({**values, name: values[name] - step})
        assert slopes[name].sum() == pytest.approx(apart / (2 * step), rel=0.1)


def test_at_random_it_is_in_a_share_of_the_frames(small):
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0, expected=np.zeros((3, 4, 40)))
    values = effect.at(roaming=100, present=0.6).values
    drawn = np.concatenate([effect.at_random(values, rendering, np.random.default_rng(s)) for s in range(200)])
    there = drawn.any(axis=(1, 2))
    assert there.mean() == pytest.approx(0.6, abs=4 * np.sqrt(0.24 / 600))
    assert len(set(drawn[there, 0].argmax(axis=1))) > 30
    np.testing.assert_array_equal(drawn[:, 0], drawn[:, 3])


def test_at_random_it_is_anywhere_where_no_frame_shows_it(small, monkeypatch):
    """Evidence against it may be so strong that no place has any chance at all."""
    values = effect.at(roaming=50.0, present=1.0).values
    mean = np.full((3, 4, small.clock.bins), 2.0)
    rendering = Rendering(small.light, small.footprints, small.clock, 1e3, background=2.0, expected=mean, recorded=mean)
    nowhere = effect._placed(values, rendering)
    monkeypatch.setattr(type(effect), "_placed", lambda *_: replace(nowhere, chances=0 * nowhere.chances))
    drawn = effect.at_random(values, rendering, np.random.default_rng(2))
    assert (drawn >= mean).all()
    assert drawn.sum() > mean.sum()


def test_at_random_it_is_where_it_was_seen(small):
    """In frames that show it in the upper half of the window it is drawn there."""
    empty = np.zeros((3, 4, 40))
    values = effect.at(roaming=100, present=1.0).values
    recorded = np.zeros((3, 4, 40))
    recorded[np.arange(3), :, [25, 30, 34]] = 60.0
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0, expected=empty, recorded=recorded)
    drawn = np.concatenate([effect.at_random(values, rendering, np.random.default_rng(s)) for s in range(60)])
    assert set(drawn[:, 0].argmax(axis=1)) <= {24, 25, 26, 29, 30, 31, 33, 34, 35}
    assert len(set(drawn[:, 0].argmax(axis=1))) >= 3


def test_how_a_search_begins_goes_by_what_is_there(small):
    rng = np.random.default_rng(3)
    shares = small.clock.pulse.in_bins(np.array([3e-9, 5e-9, 8e-9]), small.clock.bins, small.clock.bin_width_s)
    expected = np.full((3, 4, 40), 5.0)
    excess = rng.poisson(expected + 60 * shares[:, None]) - expected
    *_, begun, alone = effect.starts(
        excess, expected, Rendering(small.light, small.footprints, small.clock, 1.0, background=5.0)
    )
    assert begun["roaming"] == 70
    assert np.count_nonzero(alone["roaming"]) == 1


def test_a_faint_pulse_in_few_frames_is_looked_for(small):
    rng, frames = np.random.default_rng(5), 32
    places = rng.uniform(2e-9, 9e-9, frames)
    shares = small.clock.pulse.in_bins(places, small.clock.bins, small.clock.bin_width_s)
    expected = np.full((frames, 4, 40), 0.5)
    there = (np.arange(frames) % 3 == 0)[:, None, None]
    excess = rng.poisson(expected + 5 * there * shares[:, None]) - expected
    light = replace(small.light, time_s=np.arange(frames) / 30)
    rendering = Rendering(light, small.footprints, small.clock, 1.0, background=0.5)
    assert any(start.get("present") == 0.3 for start in effect.starts(excess, expected, rendering))


@pytest.mark.parametrize(
    ("drift", "longer", "stays", "lasts"),
    [(1e-7, 0.0, False, False), (0.0, 0.0, True, False), (1e-7, 4e-9, False, True), (1e-7, 1e-9, False, False)],
)
def test_what_stays_or_lasts_long_is_hardly_another_emitters_pulse(small, drift, longer, stays, lasts):
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)
    values = effect.at(counts=10.0, drift=drift, longer=longer).values
    assert effect.strained(values, rendering) == stays
    assert (effect.contradiction(values, rendering) is not None) == (stays or lasts)


@pytest.mark.parametrize(("bins", "stays", "lingers"), [(0.9, True, True), (-1.1, False, True), (0.4, False, False)])
def test_a_pulse_that_hardly_wanders_is_rather_a_thing_that_moves(small, bins, stays, lingers):
    """It may be one: where it seems to be is a remainder of many periods. The last in parts of the window."""
    rendering = Rendering(small.light, small.footprints, small.clock, 1.0)
    travelled = bins * (1 if lingers else small.clock.bins) * small.clock.bin_width_s
    values = effect.at(counts=10.0, drift=travelled / np.ptp(small.light.time_s)).values
    assert effect.strained(values, rendering) == lingers
    assert (effect.contradiction(values, rendering) is not None) == stays


def test_a_fit_may_begin_wherever_it_is_told_to(small):
    """Windows of a few nanoseconds: half of one is less than a period may be."""
    clock = replace(small.clock, bin_width_s=1e-10)
    rendering = Rendering(replace(small.light, time_s=np.arange(64) / 30), small.footprints, clock, 1.0)
    frames, bins = np.indices((64, small.clock.bins))
    expected = np.full((64, 4, small.clock.bins), 20.0)
    excess = np.where((frames * 2 + bins) % 24 < 3, 60.0, 0.0)[:, None] * np.ones((1, 4, 1))
    starts = effect.starts(excess, expected, rendering)
    assert any("period" in start for start in starts)
    for start in starts:
        effect.at(**start)


@pytest.mark.parametrize("returns", [True, False])
def test_one_that_returns_late_is_told_from_one_that_leaves(small, returns):
    """It is back for a tenth of the session, where noise alone adds nothing to what crosses once."""
    bins, width = small.clock.bins, small.clock.bin_width_s
    rendering = Rendering(replace(small.light, time_s=np.arange(60) / 30), small.footprints, small.clock, 1.0)
    crossing = (0.2 + 0.9 * np.arange(60) / 54) * bins * width
    arrival = np.stack([crossing, crossing - bins * width])[: 2 if returns else 1]
    shares = small.clock.pulse.in_bins(arrival, bins, width).sum(axis=0)
    expected = np.full((60, 4, bins), 20.0)
    there = expected + 60 * shares[:, None] * np.array([1, 0.5, 1.5, 0.8])[:, None]
    excess = np.random.default_rng(6).poisson(there) - expected
    starts = effect.starts(excess, expected, rendering)
    assert any("period" in start for start in starts) == returns
