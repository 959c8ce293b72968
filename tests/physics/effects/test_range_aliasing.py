"""An aliased pulse against pulses of shots drawn one by one, whose period jitters."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.form import forms_of
from physics.effects.range_aliasing import effect
from physics.far_wall import toward_unknown
from physics.light import direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from physics.walk import LEVELS

C = 299_792_458.0


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock, 4.0)


def more(model, **values):
    return model.expected(1e3, [effect.at(**values)]) - model.expected(1e3)


def test_a_steady_laser_puts_its_pulse_at_the_apparent_range(model, small):
    found = more(model, counts=[0, 10, 20, 50], apparent_range=0.6, jitter=0)
    clock = small.clock
    pulse = clock.pulse.in_bins(clock.time_zero_s + 1.2 / C, clock.bins, clock.bin_width_s)
    closed = np.array([0, 10, 20, 50])[:, None] * pulse
    np.testing.assert_allclose(found, np.broadcast_to(closed, found.shape), atol=1e-8)


@pytest.mark.parametrize("speed", [-2.0, 1.5])
def test_a_target_that_moves_is_elsewhere_in_each_frame(model, speed):
    found = more(model, counts=50, apparent_range=0.8, speed=speed)
    for i, time in enumerate((0.0, 0.1, 0.2)):
        still = more(model, counts=50, apparent_range=0.8 + speed * time)
        np.testing.assert_allclose(found[i], still[i], atol=1e-9)


@pytest.mark.parametrize(("apparent", "speed"), [(0.9, 0.0), (0.5, 1.5)])
def test_it_suggests_where_a_pulse_is_in_one_zone_only(model, small, apparent, speed):
    nominal = model.expected(1e4)
    there = model.expected(1e4, [effect.at(counts=[0, 0, 9000, 0], apparent_range=apparent, speed=speed, jitter=0)])
    excess = np.random.default_rng(9).poisson(there) - nominal
    starts = effect.starts(excess, nominal, Rendering(small.light, small.footprints, small.clock, 1e4))
    assert abs(starts[0]["apparent_range"] - apparent) < 0.04
    # A bin in 0.2 s is 0.2 m/s.
    assert abs(starts[0]["speed"] - speed) < 0.5
    for name in ("jitter", "spread"):
        assert {start[name] for start in starts if name in start} == set(effect.parameter(name).tries)


@pytest.mark.parametrize(("counts", "spread", "stretched"), [(50, 4e-9, True), (50, 2e-9, False), (0, 4e-9, False)])
def test_a_pulse_that_is_broader_than_targets_is_stretched(counts, spread, stretched, small):
    there = Rendering(small.light, small.footprints, small.clock, 1.0)
    assert effect.strained(effect.at(counts=counts, apparent_range=0.6, spread=spread).values, there) == stretched


@pytest.mark.parametrize(("part", "stretched"), [(0.0, False), (0.2, False), (-0.4, True), (0.5, True)])
def test_a_pulse_that_wanders_far_by_itself_is_rather_another_emitters(part, stretched, small):
    """Over much of the window; not one that comes nearer as the camera does."""
    there = Rendering(small.light, small.footprints, small.clock, 1.0)
    window_m = small.clock.bins * C / 2 * small.clock.bin_width_s
    speed = part * window_m / np.ptp(small.light.time_s)
    assert effect.strained(effect.at(counts=50, apparent_range=0.6, speed=speed).values, there) == stretched
    assert not effect.strained(effect.at(counts=50, apparent_range=0.6, still=1.0).values, there)
    assert not effect.strained(effect.at(through=50, depth=9.0, speed=speed).values, there)


@pytest.mark.parametrize("name", ["through", "across", "distant"])
@pytest.mark.parametrize(("apparent", "stretched"), [(0.02, True), (0.3, False)])
def test_a_far_wall_that_seems_to_be_at_the_sensor_is_rather_its_glass(small, name, apparent, stretched):
    there = Rendering(small.light, small.footprints, small.clock, 1.0)
    values = {name: 5.0, "counts": 0, "period": 2e-8, "depth": C / 2 * 2e-8 + apparent}
    assert effect.strained(effect.at(**values).values, there) == stretched


def test_a_period_that_varies_by_chance_makes_a_longer_pulse(model, small):
    """Against the mean of pulses at ranges that a normal density weights."""
    sigma, nodes = 3e-10, np.linspace(-6, 6, 301)
    weights = np.exp(-(nodes**2) / 2)
    each = [more(model, counts=50, apparent_range=0.6 + C / 2 * sigma * node, jitter=0) for node in nodes]
    wanted = np.tensordot(weights / weights.sum(), each, axes=1)
    found = more(model, counts=50, apparent_range=0.6, spread=sigma, jitter=0)
    np.testing.assert_allclose(found, wanted, atol=1e-3 * wanted.max())


def test_it_is_what_photons_of_jittered_shots_make(model, small):
    rng, clock, photons, jitter = np.random.default_rng(8), small.clock, 400_000, 1e-9
    step = clock.pulse.time_s[1] - clock.pulse.time_s[0]
    delay = rng.choice(clock.pulse.time_s, photons, p=clock.pulse.probability / clock.pulse.probability.sum())
    delay = delay + rng.uniform(-step / 2, step / 2, photons) + rng.uniform(-jitter, jitter, photons)
    at = clock.time_zero_s[2] + 2 * 0.5 / C + delay
    drawn = np.histogram(at, np.arange(clock.bins + 1) * clock.bin_width_s)[0]
    found = more(model, counts=photons, apparent_range=0.5, jitter=jitter)[0, 2]
    assert (np.abs(drawn - found) < 5 * np.sqrt(found) + 5).all()


def test_jitter_keeps_the_counts_and_the_mean_but_not_the_height(model, small):
    steady, smeared = (more(model, apparent_range=0.5, jitter=j)[0, 0] for j in (0, 1e-9))
    centres = np.arange(small.clock.bins)
    assert smeared.sum() == pytest.approx(steady.sum(), rel=1e-4)
    assert smeared @ centres == pytest.approx(steady @ centres, rel=1e-3)
    assert smeared.max() < 0.5 * steady.max()


def moved(light, ahead):
    """The light of a camera that has moved ahead by so many metres in each frame."""
    poses = np.tile(np.eye(4), (len(ahead), 1, 1))
    poses[:, 2, 3] = ahead
    return replace(light, motion=Motion.of(light.time_s, poses))


def test_a_target_that_stands_still_comes_nearer_as_the_camera_moves(small):
    ahead = np.array([0.0, 0.12, 0.05])
    model = ForwardModel(moved(small.light, ahead), small.footprints, small.clock, 4.0)
    found = more(model, counts=50, apparent_range=0.8, still=1)
    for i, way in enumerate(ahead):
        np.testing.assert_allclose(found[i], more(model, counts=50, apparent_range=0.8 - way)[i], atol=1e-9)
    # Where nobody says how the camera moved what it sees does: a wall that comes nearer by as much.
    depth = 0.9 - ahead[:, None, None] * np.ones((3, 6, 10))
    light = direct_light(depth, small.light.intrinsics, time_s=small.light.time_s)
    blind = ForwardModel(light, small.footprints, small.clock, 4.0)
    np.testing.assert_allclose(more(blind, counts=50, apparent_range=0.8, still=1), found, atol=1e-4)


def test_it_suggests_a_target_that_stands_still(small):
    light = moved(small.light, np.array([0.0, 0.35, -0.2]))
    model = ForwardModel(light, small.footprints, small.clock, 4.0)
    nominal, setting = model.expected(1e4), effect.at(counts=9000, apparent_range=0.7, still=1, jitter=0)
    excess = np.random.default_rng(9).poisson(model.expected(1e4, [setting])) - nominal
    starts = effect.starts(excess, nominal, Rendering(light, small.footprints, small.clock, 1e4))
    assert {start["still"] for start in starts if "still" in start} == {0.0, 1.0}
    best = next(start for start in starts if start.get("still") == 1)
    assert abs(best["apparent_range"] - 0.7) < 0.04
    assert abs(best["speed"]) < 0.5


@pytest.fixture
def deep(small):
    """A wall in the window, and behind an opening in it another, 9 m away."""
    depth = np.where(np.arange(10) < 4, 9.0, 0.5) * np.ones((3, 6, 10))
    light = direct_light(depth, small.light.intrinsics, time_s=small.light.time_s)
    return light, ForwardModel(light, small.footprints, small.clock, 4.0)


@pytest.mark.parametrize("period", [57e-9, 60.4e-9])
def test_what_is_seen_beyond_the_period_comes_one_period_early(deep, small, period):
    """Against a wall that much nearer, dimmer by the square of the ranges, pixel by pixel; or before time zero."""
    light, model = deep
    found = model.expected(1e6, [effect.at(counts=0, folded=0.7, period=period)]) - model.expected(1e6)
    (way,) = light.returns
    far = way.range_m > 2
    early = replace(way, range_m=way.range_m - np.float32(C / 2 * period), strength=0.7 * way.strength * far)
    alone = ForwardModel(replace(light, returns=(early,)), small.footprints, small.clock, 0.0).expected(1e6)
    np.testing.assert_allclose(found, alone, rtol=1e-4, atol=1e-6 * alone.max())
    assert alone.sum() > 100


@pytest.mark.parametrize("in_turn", [0.0, 1.0])
def test_of_two_periods_each_has_half_of_the_shots_or_every_other_frame(deep, in_turn):
    _, model = deep
    both = {"counts": 0, "folded": 0.7, "period": 56e-9, "stagger": 2e-9, "in_turn": in_turn}
    found = more(model, **both)
    short, long = (more(model, counts=0, folded=0.7, period=period) for period in (56e-9, 58e-9))
    wanted = (short + long) / 2
    if in_turn:
        wanted[::2], wanted[1::2] = short[::2], long[1::2]
    np.testing.assert_allclose(found, wanted, atol=1e-9 * wanted.max())
    assert np.abs(short - long).max() > 0.1 * short.max()


def test_frames_that_take_turns_do_so_by_their_place_in_the_session(deep, small):
    light, _ = deep
    some = ForwardModel(light.of(np.array([1, 2])), small.footprints, small.clock, 0.0)
    setting = effect.at(counts=0, folded=0.7, period=56e-9, stagger=2e-9, in_turn=1.0)
    every = ForwardModel(light, small.footprints, small.clock, 0.0).expected(1e6, [setting])
    np.testing.assert_allclose(some.expected(1e6, [setting]), every[[1, 2]], rtol=1e-12)


def test_two_periods_are_suggested_where_both_explain_something(deep, small):
    light, model = deep
    nominal = model.expected(1e6)
    setting = effect.at(counts=0, folded=1, period=215 * 0.26e-9, stagger=9 * 0.26e-9)
    excess = model.expected(1e6, [setting]) - nominal
    starts = effect.starts(excess, nominal, Rendering(light, small.footprints, small.clock, 1e6, background=4.0))
    found = {(s["period"], s["period"] + s["stagger"]) for s in starts if "stagger" in s and not s["in_turn"]}
    ((one, other),) = (sorted(pair) for pair in found)
    assert [one, other] == pytest.approx([215 * 0.26e-9, 224 * 0.26e-9], abs=0.3e-9)


def test_nothing_beyond_the_period_changes_nothing(deep):
    _, model = deep
    changed = model.expected(1e6, [effect.at(counts=0, folded=1, period=140e-9)])
    np.testing.assert_array_equal(changed, model.expected(1e6))


@pytest.mark.parametrize("period", [215 * 0.26e-9, 224 * 0.26e-9])
def test_it_suggests_the_period(deep, small, period):
    light, model = deep
    nominal, setting = model.expected(1e6), effect.at(counts=0, folded=1, period=period)
    excess = np.random.default_rng(3).poisson(model.expected(1e6, [setting])) - nominal
    starts = effect.starts(excess, nominal, Rendering(light, small.footprints, small.clock, 1e6, background=4.0))
    found = [start["period"] for start in starts if "folded" in start]
    assert abs(found[0] - period) < small.clock.bin_width_s / 2


def test_a_wall_is_seen_where_depth_is_unknown(small):
    """Against a scene that holds it, one period nearer and dimmer by the square of the ranges."""
    known, period = np.arange(10) < 6, 57e-9
    depth = np.where(known, 0.5, np.nan) * np.ones((3, 6, 10))
    light = direct_light(depth, small.light.intrinsics, time_s=small.light.time_s)
    model = ForwardModel(light, small.footprints, small.clock, 4.0)
    setting = effect.at(counts=0, through=0.3, depth=8.9, speed=0.5, period=period)
    found = model.expected(1e6, [setting]) - model.expected(1e6)
    away = 8.9 + 0.5 * small.light.time_s[:, None, None]
    whole = direct_light(
        np.where(known, np.nan, away) * np.ones(depth.shape), small.light.intrinsics, np.float32(0.3),
        time_s=small.light.time_s, cosine=np.broadcast_to(1 / np.linalg.norm(light.rays, axis=-1), depth.shape),
    )  # fmt: skip
    (way,) = whole.returns
    early = replace(way, range_m=way.range_m - np.float32(C / 2 * period))
    alone = ForwardModel(replace(whole, returns=(early,)), small.footprints, small.clock, 0.0).expected(1e6)
    np.testing.assert_allclose(found, alone, rtol=1e-4, atol=1e-6 * alone.max())
    assert alone.sum() > 100


@pytest.fixture
def window(small):
    """A wall in whose right part nothing is known."""
    depth = np.where(np.arange(10) < 6, 0.5, np.nan) * np.ones((3, 6, 10))
    return direct_light(depth, small.light.intrinsics, time_s=small.light.time_s)


@pytest.mark.parametrize("smear", [5e-10, 2e-9])
def test_it_suggests_where_a_wall_is_seen_through(small, window, smear):
    model = ForwardModel(window, small.footprints, small.clock, 4.0)
    azimuth, _ = toward_unknown(window, None)
    truth = effect.at(counts=0, through=0.5, depth=8.95, azimuth=azimuth, smear=smear)
    nominal = model.expected(1e6)
    excess = np.random.default_rng(3).poisson(model.expected(1e6, [truth])) - nominal
    starts = effect.starts(excess, nominal, Rendering(window, small.footprints, small.clock, 1e6, background=4.0))
    found = [start for start in starts if "through" in start and start["smear"] == smear]
    assert abs(found[0]["depth"] - 8.95) < 0.06
    assert found[0]["azimuth"] == azimuth > 0.2


def test_a_far_target_aside_comes_nearer_as_the_camera_moves_towards_it(small):
    """Where it is by the law of cosines, to first order in the camera's way over its distance."""
    way = np.array([[0, 0, 0], [0.3, -0.1, 0.05], [-0.2, 0.25, 0.1]])
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, :3, 3] = way
    light = replace(small.light, motion=Motion.of(small.light.time_s, poses))
    toward = np.array([0.48, -0.6, 0.64])
    far = 1e4 * toward
    nearer = 1e4 - np.linalg.norm(far - way, axis=1)
    model = ForwardModel(light, small.footprints, small.clock)
    still = {"still_right": toward[0], "still_down": toward[1], "still": toward[2]}
    found = model.expected(0.0, [effect.at(counts=100.0, apparent_range=0.9, **still)])
    for frame, by in enumerate(nearer):
        closed = model.expected(0.0, [effect.at(counts=100.0, apparent_range=0.9 - by)])[frame]
        np.testing.assert_allclose(found[frame], closed, atol=1e-3 * closed.max())
    assert np.abs(found[1] - found[0]).max() > 0.1 * found.max()


def test_a_target_that_fills_the_view_is_as_bright_as_zones_see(model, small):
    """Against the zones' maps summed over the image; in the same places as one that is alike in all."""
    alike, seen = (model.expected(0.0, [effect.at(counts=50, apparent_range=0.4, as_seen=of)]) - 4 for of in (0, 1))
    whole = small.footprints.weights.sum(axis=(1, 2))
    np.testing.assert_allclose(seen, alike * (whole / whole.mean())[:, None], rtol=1e-6)
    half = model.expected(0.0, [effect.at(counts=50, apparent_range=0.4, as_seen=0.5)]) - 4
    np.testing.assert_allclose(half, (alike + seen) / 2, rtol=1e-6)


def test_what_goes_straight_is_not_begun_on_a_curved_way(small):
    forms = list(forms_of(effect, {"zone": 4, "bin": small.clock.bins}))
    curved = {"counts": 5.0, "apparent_range": 0.5, "every": 0.1} | {name: 0.01 for name in LEVELS}
    begun = {form.free for form in forms if form.beginning(curved) is not None}
    assert begun
    assert all(set(LEVELS) <= set(free) for free in begun)
