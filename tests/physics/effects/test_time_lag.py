"""A lag against scenes that were taken at the other time."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects import find_effect
from physics.effects.time_lag import effect
from physics.light import direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from physics.told_between import jumps, together

INTRINSICS = np.array([[7.5, 0, 4.5], [0, 7.5, 2.5], [0, 0, 1]])
TIMES = np.array([0.0, 0.1, 0.25, 0.3, 0.5])


def approaching(times):
    """A wall at 1.2 m that comes nearer by 0.4 m/s."""
    depth = np.broadcast_to((1.2 - 0.4 * np.asarray(times))[:, None, None], (len(times), 6, 10))
    return direct_light(depth, INTRINSICS, None, np.ones(depth.shape), time_s=TIMES)


@pytest.mark.parametrize("lag", [-0.08, 0.03, 0.05, 0.2])
def test_it_sees_the_wall_where_it_is_by_then(small, lag):
    light = approaching(TIMES)
    found = ForwardModel(light, small.footprints, small.clock).expected(1e3, [effect.at(lag=lag)])
    # Before the first frame and after the last nothing moves.
    then = approaching(np.clip(TIMES + lag, TIMES[0], TIMES[-1]))
    closed = ForwardModel(then, small.footprints, small.clock).expected(1e3)
    # Ranges are linear in time, 1/r² is not quite: 0.08 m within 1 m.
    np.testing.assert_allclose(found, closed, atol=5e-3 * closed.max())


@pytest.mark.parametrize(("lag", "skew"), [(0.0, 0.2), (0.03, -0.3)])
def test_clocks_that_do_not_agree_run_apart(small, lag, skew):
    light = approaching(TIMES)
    found = ForwardModel(light, small.footprints, small.clock).expected(1e3, [effect.at(lag=lag, skew=skew)])
    then = approaching(np.clip(lag + (1 + skew) * TIMES, TIMES[0], TIMES[-1]))
    closed = ForwardModel(then, small.footprints, small.clock).expected(1e3)
    np.testing.assert_allclose(found, closed, atol=5e-3 * closed.max())
    assert effect.reach(effect.at(skew=skew).values) == (np.inf, np.inf)


@pytest.mark.parametrize("frames", [1, -1])
def test_a_whole_frame_is_the_next_or_the_one_before(small, frames):
    model = ForwardModel(small.light, small.footprints, small.clock)
    found, nominal = model.expected(1e3, [effect.at(lag=0.1 * frames)]), model.expected(1e3)
    held = np.clip(np.arange(3) + frames, 0, 2)
    np.testing.assert_allclose(found, nominal[held], atol=1e-4 * nominal.max())


def test_where_nothing_moves_there_is_nothing_to_see(small):
    still = approaching(np.zeros(5))
    model = ForwardModel(still, small.footprints, small.clock)
    np.testing.assert_allclose(model.expected(1e3, [effect.at(lag=0.13)]), model.expected(1e3), rtol=1e-9)
    only = replace(
        direct_light(np.ones((1, 6, 10)), INTRINSICS, None, np.ones((1, 6, 10))), laser_cycles=None, time_s=np.zeros(1)
    )
    model = ForwardModel(only, small.footprints, small.clock)
    np.testing.assert_array_equal(model.expected(1e3, [effect.at(lag=-1.0)]), model.expected(1e3))


@pytest.mark.parametrize(
    ("late", "second"), [(-1.0, [False, False, True, True]), ([1, 0, 0, 1], [True, False, False, True])]
)
@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_zones_of_a_second_burst_look_later(small, late, second, lag):
    model = ForwardModel(approaching(TIMES), small.footprints, small.clock)
    found = model.expected(1e3, [effect.at(lag=lag, burst=0.04, late=late)])
    first, then = (model.expected(1e3, [effect.at(lag=by)]) for by in (lag, lag + 0.04))
    wanted = np.where(np.array(second)[:, None], then, first)
    np.testing.assert_allclose(found, wanted, atol=1e-9 * wanted.max())
    assert effect.reach(effect.at(lag=-0.1, burst=0.3).values) == pytest.approx((0.1, 0.2))


@pytest.mark.parametrize(("lag", "burst"), [(0.0, 0.03), (0.02, -0.05)])
def test_data_tell_which_zones_were_measured_later(small, lag, burst):
    light = approaching(TIMES)
    model = ForwardModel(light, small.footprints, small.clock, 1.0)
    plain = model.expected(1e3)
    excess = model.expected(1e3, [effect.at(lag=lag, burst=burst, late=[0, 1, 0, 1])]) - plain
    *both, alone = effect.starts(excess, plain, Rendering(light, small.footprints, small.clock, 1e3, background=1.0))
    farther = 1.0 if abs(lag + burst) > abs(lag) else 0.0
    assert alone["late"].tolist() == [1 - farther, farther, 1 - farther, farther]
    assert len(both) == (lag != 0)
    start = {"lag": 0.0, "late": alone["late"]} | (both[0] if both else alone)
    assert start["lag"] + (start["burst"] if farther else 0) == pytest.approx(
        lag + (burst if farther else 0), rel=0.5, abs=0.004
    )
    assert alone["late"] is start["late"] or (alone["late"] == start["late"]).all()


def test_pixels_that_come_to_be_known_rise_from_nothing(small):
    """Counts are continuous in the lag, at 0 too: what is unknown in a frame contributes nothing at its time."""
    depth = np.ones((2, 6, 10), np.float32)
    depth[0, :3] = np.nan
    light = direct_light(depth, INTRINSICS, None, np.ones(depth.shape), time_s=np.array([0.0, 0.1]))
    model = ForwardModel(light, small.footprints, small.clock)
    first, second = model.expected(1e3)
    for lag in (1e-6, 0.03, 0.0999):
        found = model.expected(1e3, [effect.at(lag=lag)])[0]
        np.testing.assert_allclose(found, (1 - lag / 0.1) * first + lag / 0.1 * second, atol=1e-6 * second.max())


def test_a_plate_that_passes_is_seen_in_its_place_and_nothing_between(small):
    """Halfway between two frames a plate has covered half of what it covers by the second: counts are the mean."""
    depth = np.full((2, 6, 10), 1.5, np.float32)
    depth[1, :, 4:7] = 0.5
    light = direct_light(depth, INTRINSICS, None, np.ones(depth.shape), time_s=np.array([0.0, 0.1]))
    model = ForwardModel(light, small.footprints, small.clock)
    before, after = model.expected(1e3)
    for part in (0.25, 0.5, 0.9):
        found = model.expected(1e3, [effect.at(lag=0.1 * part)])[0]
        np.testing.assert_allclose(found, (1 - part) * before + part * after, atol=1e-5 * after.max())


def test_it_says_how_far_it_looks():
    assert effect.reach(effect.at(lag=0.2).values) == (0, 0.2)
    assert effect.reach(effect.at(lag=-0.3).values) == (0.3, 0)
    assert effect.reaches(effect.at(lag=-0.3).values)
    assert not effect.reaches(effect.vanished().values)
    pile_up = find_effect("pile_up").at()
    assert pile_up.effect.reach(pile_up.values) == (0, 0)


@pytest.mark.parametrize("lag", [-0.06, 0.07])
def test_before_and_after_the_session_all_may_move_on(small, lag):
    """A wall that nears evenly was farther before, and is nearer after: as if it had been seen then."""
    found = ForwardModel(approaching(TIMES), small.footprints, small.clock).expected(
        1e3, [effect.at(lag=lag, beyond=1)]
    )
    closed = ForwardModel(approaching(TIMES + lag), small.footprints, small.clock).expected(1e3)
    np.testing.assert_allclose(found, closed, atol=1e-2 * closed.max())


def curved(times):
    """A wall that swings by 6 cm about 0.8 m, 2.2 times a second."""
    depth = np.broadcast_to((0.8 + 0.06 * np.sin(14 * np.asarray(times)))[:, None, None], (len(times), 6, 10))
    return direct_light(depth, INTRINSICS, None, np.ones(depth.shape), time_s=times)


@pytest.mark.parametrize("lag", [0.01, 0.025, -0.02])
@pytest.mark.parametrize("beyond", [0.0, 1.0])
def test_what_nobody_saw_between_frames_is_owned_up_to(small, lag, beyond):
    """What interpolation leaves of a wall on a curve, to a factor of two; nothing of one that nears evenly."""
    times = 0.05 * np.arange(40)
    model = ForwardModel(curved(times), small.footprints, small.clock, 1.0)
    true = ForwardModel(curved(times + lag), small.footprints, small.clock, 1.0).expected(1e5)
    lagged = effect.at(lag=lag, beyond=beyond)
    left = ((model.expected(1e5, [lagged]) - true) ** 2).sum()
    rendering = Rendering(curved(times), small.footprints, small.clock, 1e5, background=1.0)
    owned = effect.unseen(lagged.values, rendering).variance.sum()
    assert left > 1e3 * true.mean()
    assert left / 2 < owned < 2 * left
    still = Rendering(approaching(TIMES), small.footprints, small.clock, 1e5, background=1.0)
    assert effect.unseen(effect.at(lag=0.05, beyond=1).values, still).variance.sum() < 0.02 * owned
    assert not effect.unseen(effect.at(lag=0.0).values, rendering).variance.any()


def fence(times):
    """Rails 0.5 m away before a wall at 1 m, that pass by at 5 pixels a second, other rails in each row."""
    rng = np.random.default_rng(8)
    at = np.arange(10) - 5 * np.asarray(times)[:, None, None] + rng.uniform(0, 9, (6, 1))
    depth = np.where(np.sin(at * rng.uniform(0.7, 1.3, (6, 1))) > 0, 0.5, 1.0)
    return direct_light(depth, INTRINSICS, None, np.ones(depth.shape), time_s=times)


@pytest.mark.parametrize("lag", [0.005, 0.02, 0.04])
def test_whether_an_edge_has_passed_a_pixel_is_owned_up_to(small, lag):
    times = 0.05 * np.arange(60)
    true = ForwardModel(fence(times + lag), small.footprints, small.clock, 1.0).expected(1e4)
    lagged = effect.at(lag=lag)
    left = (ForwardModel(fence(times), small.footprints, small.clock, 1.0).expected(1e4, [lagged]) - true) ** 2
    rendering = Rendering(fence(times), small.footprints, small.clock, 1e4, background=1.0)
    assert left.sum() / 2 < effect.unseen(lagged.values, rendering).variance.sum() < 2 * left.sum()


def test_what_is_off_alike_is_told(small):
    """Rails that pass are off in all bins of a pulse, and in zones that see them together; noise in each by itself."""
    times = 0.05 * np.arange(60)
    rendering = Rendering(fence(times), small.footprints, small.clock, 1e4, background=1.0)
    assert 2 < effect.unseen(effect.at(lag=0.02).values, rendering).together < 30
    noise = np.random.default_rng(3).normal(size=(200, 4, 40))
    assert together(noise) == pytest.approx(1, abs=0.1)
    assert together(np.repeat(noise, 3, axis=2)) == pytest.approx(3, rel=0.1)
    assert together(noise[:, :1] * np.ones((4, 1))) == pytest.approx(4, rel=0.1)


def test_what_jumps_from_frame_to_frame_is_told_from_what_glides(small):
    for light, wanted in ((fence(0.05 * np.arange(60)), True), (approaching(TIMES), False)):
        assert jumps(Rendering(light, small.footprints, small.clock, 1e4, background=1.0)) == wanted


@pytest.mark.parametrize(("speed", "lag"), [(4.0, 0.02), (6.0, 0.004), (6.0, -0.004)])
def test_where_the_scene_stands_still_the_camera_s_motion_carries_it(small, speed, lag):
    """A deep relief that the camera passes, two pixels a frame or three, against what it sees at the other times."""
    times = 0.05 * np.arange(40)

    def relief(times):
        poses = np.tile(np.eye(4), (len(times), 1, 1))
        poses[:, 0, 3] = speed * np.asarray(times)
        across = direct_light(np.ones((1, 6, 10)), INTRINSICS).rays[..., 0]
        depth = np.full((len(times), 6, 10), 0.8)
        for _ in range(60):  # Where a ray meets the surface z = 0.8 + 0.15·sin(3·x).
            depth = 0.8 + 0.15 * np.sin(3 * (poses[:, 0, 3, None, None] + depth * across))
        return direct_light(depth, INTRINSICS, None, np.ones(depth.shape), time_s=times, motion=Motion.of(times, poses))

    model = ForwardModel(relief(times), small.footprints, small.clock)
    true = ForwardModel(relief(times + lag), small.footprints, small.clock).expected(1e3)
    off = [((model.expected(1e3, [effect.at(lag=lag, carried=c)]) - true)[1:-1] ** 2).sum() for c in (0.0, 1.0)]
    assert off[1] < 0.35 * off[0]
    excess, plain = true - model.expected(1e3), model.expected(1e3)
    starts = effect.starts(excess, plain, Rendering(relief(times), small.footprints, small.clock, 1e3, background=1.0))
    assert all(start["carried"] == 1 for start in starts)
    assert starts[0]["lag"] == pytest.approx(lag, rel=0.5)


@pytest.mark.parametrize(("lag", "skew"), [(0.02, 0.0), (0.0, 0.01), (0.01, -0.01)])
def test_data_tell_how_far_clocks_are_apart_where_what_is_seen_moves_as_one(small, lag, skew):
    times = 0.05 * np.arange(40)

    def swaying(times):
        """A wall askew whose distance swings."""
        across = direct_light(np.ones((1, 6, 10)), INTRINSICS).rays @ np.array([0.3, -0.2, 1])
        depth = (1 + 0.3 * np.sin(4 * np.asarray(times)))[:, None, None] / across
        return direct_light(depth, INTRINSICS, None, np.ones(depth.shape), time_s=times)

    plain = ForwardModel(swaying(times), small.footprints, small.clock).expected(1e3)
    excess = ForwardModel(swaying(times + lag + skew * times), small.footprints, small.clock).expected(1e3) - plain
    rendering = Rendering(swaying(times), small.footprints, small.clock, 1e3, background=1.0)
    starts = effect.starts(excess, plain, rendering)
    (found,) = (start for start in starts if {"lag", "skew"} <= start.keys())
    assert found["lag"] == pytest.approx(lag, abs=0.006)
    assert found["skew"] == pytest.approx(skew, abs=0.006)


@pytest.mark.parametrize("lag", [0.002, 0.005, 0.02])
def test_an_edge_that_passes_soon_after_a_frame_does_so_seldom_and_is_off_by_its_whole(small, lag):
    """Light blended is off by a little in most frames, by much in few: in those by more than the mean it owns up to."""
    times = 0.05 * np.arange(40)
    model = ForwardModel(fence(times), small.footprints, small.clock, 1.0)
    true = ForwardModel(fence(times + lag), small.footprints, small.clock, 1.0).expected(1e4)
    lagged = effect.at(lag=lag)
    off = ((model.expected(1e4, [lagged]) - true) ** 2).sum(axis=(1, 2))[1:-1]
    rendering = Rendering(fence(times), small.footprints, small.clock, 1e4, background=1.0)
    unseen = effect.unseen(lagged.values, rendering)
    x = lag / 0.05
    np.testing.assert_allclose(unseen.at_most[:-1], 1 / (x * (1 - x)), rtol=1e-9)
    owned = unseen.variance.sum(axis=(1, 2))[1:-1]
    assert (off < 2 * unseen.at_most[1:-1] * owned).all()
    if x < 0.1:
        assert off.max() > 3 * owned.mean()
