"""Photons of the nominal model by what is known of them in closed form, and what the engine refuses."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from physics.effects import find_effect
from physics.scene.view import View, Views
from physics.simulate import simulate
from physics.single_photons import draw
from physics.single_photons.acts import find_act
from physics.single_photons.engine import draw_frame, draw_frames, photon_counts, record
from physics.single_photons.sight import pixel_places, zone_weights
from physics.single_photons.world import Photons
from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal

C = 299_792_458.0


def of(*arrays):
    return Photons(*(np.array(array) for array in arrays))


@pytest.fixture
def world(both):
    return both().session.world(0)


def test_a_surface_returns_what_its_range_says(world):
    """One pixel of range 1 m: gain · w · ρ · cosθ photons, all in the bin where a pulse of no length arrives."""
    depth = np.full_like(world.depth_m, np.nan)
    depth[2, 4] = 1 / np.linalg.norm([(4 - 4.5) / 7.5, (2 - 2.5) / 7.5, 1])
    alone = replace(
        world,
        depth_m=depth,
        reflectance=np.full(depth.shape, 0.5),
        cosine=np.full(depth.shape, 0.8),
        gain=1e6,
        background=np.zeros(4),
        pulse_time_s=np.array([0, 1e-12]),
        pulse=np.array([1.0, 0]),
    )
    counts = draw_frame(alone, (), np.random.default_rng(1))
    mean = 1e6 * 0.4 * world.weights[:, 2, 4]
    assert (np.abs(counts.sum(axis=1) - mean) < 5 * np.sqrt(mean)).all()
    due = np.floor((2 / C + world.time_zero_s) / world.bin_width_s).astype(int)
    np.testing.assert_array_equal(counts[np.arange(4), due], counts.sum(axis=1))


def test_delays_are_those_of_the_pulse(world):
    step = world.pulse_time_s[1] - world.pulse_time_s[0]
    found = draw.delays(world, 50_000, np.random.default_rng(2))
    edges = world.pulse_time_s[0] + step * (np.arange(len(world.pulse) + 1) - 0.5)
    heaped = np.concatenate([[0], np.cumsum(world.pulse)])
    assert kstest(found, lambda time: np.interp(time, edges, heaped)).pvalue > 1e-3


def test_what_is_unknown_or_faces_away_returns_nothing(world):
    for change in ({"depth_m": np.nan}, {"reflectance": np.nan}, {"cosine": np.nan}, {"cosine": -0.5}, {"depth_m": 0}):
        (name, value), *_ = change.items()
        dark = replace(world, **{name: np.full(world.depth_m.shape, float(value))})
        assert len(draw.returned(dark, np.random.default_rng(0))) == 0


def test_photons_outside_the_window_are_lost(world):
    width = world.bin_width_s
    photons = of([0, 1, 3, 3, 2], np.array([-0.01, 0.5, 47.99, 48.01, 7.2]) * width, [0] * 5, [0] * 5)
    found = draw.counts_of(photons, world)
    assert found.shape == (4, 48)
    assert [tuple(cell) for cell in np.argwhere(found)] == [(1, 0), (2, 7), (3, 47)]
    np.testing.assert_array_equal(draw.in_window(photons, world), [False, True, True, False, True])


def test_background_is_even_and_poisson(world):
    rng = np.random.default_rng(3)
    seen = np.stack([draw.counts_of(draw.background(world, rng), world) for _ in range(200)])
    mean = np.array([1.0, 2, 0.5, 3]) * 1e-3 * world.gain
    np.testing.assert_allclose(seen.mean(axis=(0, 2)), mean, rtol=0.02)
    np.testing.assert_allclose(seen.var(axis=(0, 2)), mean, rtol=0.1)


def test_weights_are_linear_between_positions():
    """A response that is linear in the image is found at every pixel's centre, and nothing outside the scan."""
    x, y = (axis.ravel() for axis in np.meshgrid([100.0, 350, 700], [60.0, 300, 420]))
    maps = ResponseMaps((1 + 2 * x + 3 * y).reshape(1, 1, -1), x, y, np.arange(9).astype(str))
    at_x, at_y = pixel_places(maps, (60, 106))
    assert (at_x[0, 0], at_y[0, 0], at_x[-1, -1], at_y[-1, -1]) == pytest.approx((3.5, 3.5, 843.5, 475.5))
    inside = (at_x >= 100) & (at_x <= 700) & (at_y >= 60) & (at_y <= 420)
    linear = np.where(inside, 1 + 2 * at_x + 3 * at_y, 0)
    np.testing.assert_allclose(zone_weights(maps, (60, 106))[0], linear / linear.max(), atol=1e-12)


def test_incidence_that_is_not_given_is_that_of_a_tilted_plane(both):
    made = both()
    rays = np.stack([*np.meshgrid((np.arange(10) - 4.5) / 7.5, (np.arange(6) - 2.5) / 7.5), np.ones((6, 10))], axis=-1)
    normal = np.array([0.3, -0.2, 1]) / np.linalg.norm([0.3, -0.2, 1])
    session = replace(made.session, views=[View(0.0, 1 / (rays @ normal))])
    cosine = rays @ normal / np.linalg.norm(rays, axis=-1)
    np.testing.assert_allclose(session.cosine(0)[1:-1, 1:-1], cosine[1:-1, 1:-1], rtol=0.02)


def test_gloss_brightens(both):
    session = both().session
    bright = replace(session, views=[replace(session.views[0], gloss=np.full((6, 10), 3.0))])
    matt, glossy = (len(draw.returned(s.world(0), np.random.default_rng(4))) for s in (session, bright))
    assert glossy / matt == pytest.approx(3, rel=0.02)


def test_other_frames_are_the_nearest_in_time(both):
    session = both().session
    assert session.at(0.14).time_s == pytest.approx(0.1)
    assert session.at(9).time_s == pytest.approx(0.2)


def test_the_same_generator_gives_the_same(both):
    made = both()
    one, two = (np.stack(list(draw_frames(made.session, np.random.default_rng(6)))) for _ in range(2))
    np.testing.assert_array_equal(one, two)
    again = photon_counts(made.views, made.maps, made.sensor, np.random.default_rng(6), 1e5)
    np.testing.assert_array_equal(again, one)


def test_it_makes_recordings_with_the_fields_of_the_fast_engine(both):
    made = both(effects=[find_effect("ambient_pedestal").at(level=30)])
    seen = record(made.views, made.maps, made.sensor, np.random.default_rng(7), 1e5)
    views = Views(made.session.intrinsics, iter(made.session.views), 3)
    fast = simulate(views, made.maps, made.sensor, np.random.default_rng(7), gain=1e5)[0].collect()
    assert isinstance(seen, Recording)
    for (name, value), (same, other) in zip(seen.present(), fast.present(), strict=True):
        assert name == same
        if name not in ("counts", "meta_json"):
            np.testing.assert_array_equal(value, other)
    assert seen.meta["effects"] == fast.meta["effects"]
    expected = made.model.expected(1e5, made.sensor.effects)
    assert seen.counts.dtype == np.uint32
    assert float(seen.counts.sum()) == pytest.approx(expected.sum(), rel=3e-3)


def test_what_it_cannot_do_it_refuses(both):
    made = both()
    with pytest.raises(Refusal, match="effect 'fog' has no act on single photons, expected one of afterpulsing,"):
        find_act("fog")
    with pytest.raises(Refusal, match="response maps have 1 x 4 zones but the sensor 2 x 2"):
        replace(made.session, maps=replace(made.maps, responses=made.maps.responses.reshape(1, 4, -1)))
    with pytest.raises(Refusal, match="gain is 0, expected"):
        replace(made.session, gain=0)
    with pytest.raises(Refusal, match="no view"):
        replace(made.session, views=[])
    with pytest.raises(Refusal, match=r"depth_m\[1\] has shape \(3, 4\)"):
        replace(made.session, views=[made.session.views[0], View(8.0, np.ones((3, 4)))])
    with pytest.raises(Refusal, match="photons, expected 1e\\+08 at most: lower the gain"):
        draw.returned(replace(made.session.world(0), gain=1e12), np.random.default_rng(0))
    with pytest.raises(Refusal, match="pile_up: laser_cycles is missing"):
        draw_frame(
            replace(made.session.world(0), laser_cycles=None),
            (find_effect("pile_up").at(),),
            np.random.default_rng(0),
        )


def test_maps_on_a_line_are_refused():
    maps = ResponseMaps(np.ones((1, 1, 3)), np.arange(3.0), np.arange(3.0), np.arange(3).astype(str))
    with pytest.raises(Refusal, match="3 positions lie on a line"):
        zone_weights(maps, (6, 10))
