"""Acts of the scene, each by itself: limits, and light of a second bounce against integrals over plates."""

from dataclasses import replace

import numpy as np
import pytest

from physics.effects import find_effect
from physics.single_photons.acts import find_act, multipath
from physics.single_photons.draw import counts_of
from physics.single_photons.engine import draw_frames
from physics.single_photons.world import Photons
from recordings.refusal import Refusal

C = 299_792_458.0
NOBODY = Photons(*(np.zeros(0, kind) for kind in (np.int32, float, np.int32, np.int32)))
NONE = {"between": 0, "sensor": 0, "outside": 0}


@pytest.fixture
def world(both):
    return both().session.world(1)


def acted(world, name, **values):
    effect = find_effect(name)
    return find_act(name).world(world, effect.at(**(effect.vanished().values | values)).values, None)


@pytest.mark.parametrize("name", ["reflectance_map", "non_lambertian"])
def test_where_an_act_vanishes_surfaces_shine_as_they_did(name, world):
    found = acted(world, name)
    np.testing.assert_allclose(found.reflectance, world.reflectance)
    np.testing.assert_allclose(np.broadcast_to(found.gloss, (6, 10)), np.broadcast_to(world.gloss, (6, 10)))


def test_contrast_is_a_power_about_one_half(world):
    np.testing.assert_allclose(acted(world, "reflectance_map", contrast=1).reflectance, 2 * world.reflectance**2)
    alike = acted(world, "reflectance_map", contrast=-1).reflectance
    np.testing.assert_allclose(alike[np.isfinite(alike)], 0.5)
    dark = replace(world, reflectance=np.zeros((6, 10)))
    assert (acted(dark, "reflectance_map", contrast=-1, step=2, spot=1).reflectance == 0).all()


def test_a_step_is_on_the_dark_side_of_its_level(world):
    for reflectance, part in ((0.1, 1), (0.4, 0.5), (0.44, 1 / (1 + 1.1**10)), (1.0, 0)):
        flat = replace(world, reflectance=np.full((6, 10), reflectance))
        found = acted(flat, "reflectance_map", step=0.8, level=0.4).reflectance
        np.testing.assert_allclose(found, reflectance * np.exp(0.8 * part), rtol=2e-4)


def test_a_spot_is_where_its_tangents_say_at_any_range(world):
    for seen in (world, replace(world, depth_m=3 * world.depth_m)):
        x, y = (7 - 4.5) / 7.5, (4 - 2.5) / 7.5
        values = {"spot": -1.2, "spot_x": x, "spot_y": y, "spot_size": 2 / 7.5}
        factor = acted(seen, "reflectance_map", **values).reflectance / world.reflectance
        assert factor[4, 7] == pytest.approx(np.exp(-1.2))
        assert factor[4, 9] == pytest.approx(np.exp(-1.2 * np.exp(-0.5)))


LOBES = [(0, lambda c: c + 0.7), (1, lambda c: 1.7 * c), (3, lambda c: c + 0.7 * c**3)]


@pytest.mark.parametrize(("exponent", "light"), LOBES)
def test_a_lobe_adds_a_power_of_the_cosine_to_it(world, exponent, light):
    facing = np.nan_to_num(world.cosine) > 0
    found = acted(world, "non_lambertian", lobe=0.7, exponent=exponent)
    np.testing.assert_allclose((found.gloss * found.cosine)[facing], light(world.cosine[facing]))
    np.testing.assert_allclose(found.gloss[~facing], 1)


def on_axis(world, depth_m, reflectance, gain):
    """5 × 5 pixels about the axis, so narrow that all are on it, that zone 0 sees; and a pulse of no width."""
    matrix = np.array([[2000.0, 0, 2], [0, 2000.0, 2], [0, 0, 1]])
    return replace(
        world, depth_m=np.full((5, 5), depth_m), reflectance=np.full((5, 5), reflectance), cosine=np.ones((5, 5)),
        intrinsics=matrix, weights=np.ones((4, 5, 5)) * np.array([1, 0, 0, 0])[:, None, None], gain=gain,
        pulse_time_s=np.arange(-1, 2) * 1e-15, pulse=np.array([0, 1.0, 0]),
    )  # fmt: skip


def bounced(world, seed=1, **values):
    values = find_effect("multipath").at(**NONE | values).values
    return multipath.photons(NOBODY, world, values, np.random.default_rng(seed))


def test_no_bounce_no_photons(world):
    assert len(bounced(world)) == 0
    assert len(bounced(replace(world, depth_m=np.full((6, 10), np.nan)), between=1, sensor=1e-2, outside=1)) == 0


def test_the_sensors_face_is_a_lamp_as_bright_as_it_is_lit(world):
    """25 pixels of 1/2000² sr at z: light ρ/z² each falls on the face, and by the face on the wall again."""
    narrow = on_axis(world, 0.2, 0.5, gain=1e10)
    found = bounced(narrow, sensor=0.02)
    sent = 0.5 / 0.2**2
    mean = 1e10 * 25 * sent * 0.02 / np.pi**2 * sent * 25 / 2000**2
    assert len(found) == pytest.approx(mean, abs=4 * np.sqrt(mean))
    assert (found.zone == 0).all()
    np.testing.assert_allclose(found.time_s - world.time_zero_s[0], 4 * 0.2 / C, rtol=1e-4)


@pytest.mark.parametrize("azimuth", [0, 90, 217])
def test_a_plane_outside_shows_the_wall_the_sensors_image(world, azimuth):
    narrow = on_axis(world, 0.8, 0.5, gain=1e6)
    found = bounced(narrow, outside=0.3, outside_distance=0.3, outside_azimuth=azimuth)
    far = np.hypot(0.8, 2 * 0.3)
    mean = 1e6 * 25 * 0.3 * 0.5 * (0.8 / far) / far**2
    assert len(found) == pytest.approx(mean, abs=4 * np.sqrt(mean) + 1e-3 * mean)
    np.testing.assert_allclose(found.time_s - world.time_zero_s[0], (0.8 + far) / C, rtol=5e-3)


def test_a_flat_wall_does_not_light_itself(world):
    assert len(bounced(on_axis(world, 0.8, 0.5, gain=1e9), between=10)) < 10


@pytest.fixture
def corner(world):
    """A wall at z = 1 that zone 0 sees and a plate at x = 0.3 that zone 1 sees, 27 × 39 pixels."""
    shape, focal = (27, 39), 28.0
    matrix = np.array([[focal, 0, 19], [0, focal, 13], [0, 0, 1]])
    x = (np.arange(39) - 19) / focal * np.ones((27, 1))
    side = x > 0.3
    return replace(
        world, depth_m=np.where(side, 0.3 / np.where(side, x, 1), 1.0), reflectance=np.where(side, 0.5, 0.8),
        cosine=np.ones(shape), intrinsics=matrix, weights=np.stack([~side, side, 0 * side, 0 * side]).astype(float),
        gain=1e4,
    )  # fmt: skip


def between_plates(nodes=24):
    """Light on all pixels of wall and plate by way of the other: integrals over both, by Gauss and Legendre.

    Pixels end at columns 27.5 and 38.5; the plate begins where the column 27.5 meets it.
    """
    focal, (t, share) = 28.0, np.polynomial.legendre.leggauss(nodes)
    left, fold, right, up = -19.5 / focal, 8.5 / focal, 19.5 / focal, 13.5 / focal

    def spread(low, high):
        return (low + high) / 2 + t * (high - low) / 2, share * (high - low) / 2

    def plate(low, high):
        (a, da), (b, db) = spread(low, high), spread(-up, up)
        a, b = (grid.ravel() for grid in np.meshgrid(a, b))
        return np.stack([a, b, np.ones_like(a)], axis=1), np.outer(db, da).ravel()

    (wall, wall_area), (side, side_area) = plate(left, fold), plate(fold, right)
    side_points = side * (0.3 / side[:, :1])
    way = side_points[None] - wall[:, None]
    apart = np.linalg.norm(way, axis=-1)
    exchange = np.clip(-way[..., 2], 0, None) * np.clip(way[..., 0], 0, None) / np.pi / apart**4
    wall_solid = wall_area * np.linalg.norm(wall, axis=1) ** -3
    side_solid = side_area * np.linalg.norm(side, axis=1) ** -3
    onto_side = 0.8 * wall_solid @ exchange @ (0.5 * side_area) * focal**2
    onto_wall = (0.8 * wall_area) @ exchange @ (0.5 * side_solid) * focal**2
    return onto_wall, onto_side


@pytest.mark.parametrize("most", [3000, 500])
def test_two_plates_exchange_what_integrals_say(corner, most, monkeypatch):
    """Near the fold pixels are no points: some hundredths."""
    monkeypatch.setattr(multipath, "MOST_POINTS", most)
    draws = 4
    zone = np.concatenate([bounced(corner, seed, between=1).zone for seed in range(draws)])
    for p, light in enumerate(between_plates()):
        assert (zone == p).sum() == pytest.approx(draws * 1e4 * light, rel=0.06)
    assert (zone < 2).all()


def test_a_pulse_that_roams_is_anywhere_and_the_same_in_all_zones(both):
    """Over many frames its mean is the fast engine's, which spreads it; within one it is in one place."""
    made = both(gain=1.0)
    setting = find_effect("interference").at(roaming=[500, 500, 0, 1000], present=0.7)
    world, act = made.session.world(1), find_act("interference").photons
    counts = np.stack(
        [counts_of(act(NOBODY, world, setting.values, np.random.default_rng(s)), world) for s in range(600)]
    )
    expected = (made.model.expected(1.0, [setting]) - made.model.expected(1.0))[1]
    error = counts.std(axis=0) / np.sqrt(len(counts)) + 1e-9
    assert (np.abs(counts.mean(axis=0) - expected)[[0, 1, 3], 10:] / error[[0, 1, 3], 10:]).max() < 4.5
    assert not counts[:, 2].any()
    there = counts[:, 3].sum(axis=1) > 500
    peaks = counts[there].argmax(axis=2)
    assert np.median(np.abs(peaks[:, 0] - peaks[:, 3])) <= 1


def test_photons_of_a_lag_go_pixel_by_pixel_and_nothing_else_is_drawn_in_silence(world):
    with pytest.raises(Refusal, match="carried is 1, expected 0"):
        acted(world, "time_lag", lag=0.03, carried=1.0)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("range_aliasing", {"counts": 1.0, "apparent_range": 0.5, "still": 1.0}),
        ("reflectance_map", {"mark": 0.5}),
        ("reflectance_map", {"space_x": 0.5}),
        ("reflectance_map", {"wave_cos": 0.5}),
        ("reflectance_map", {"patch": 0.5}),
        ("second_surface", {"pane": 0.5}),
    ],
)
def test_what_stands_still_needs_the_camera_s_way(both, name, values):
    drawn = both(effects=[find_effect(name).at(**values)]).session
    with pytest.raises(Refusal, match="camera_pose is missing"):
        list(draw_frames(drawn, np.random.default_rng(0)))
