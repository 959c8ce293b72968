"""A second bounce against rays drawn one by one, the image of a plane mirror, and closed forms."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import dblquad

from physics import bounce
from physics.bounce import OUTSIDE, bounces, patches
from physics.clock import Clock
from physics.effects.multipath import effect
from physics.footprint import footprints
from physics.light import Return, direct_light
from physics.motion import Motion
from physics.nominal import ForwardModel
from physics.outside_plane import by_way_of_plane
from physics.pulse import ImpulseResponse
from physics.rendering import Rendering
from recordings.maps import ResponseMaps

C = 299_792_458.0
NONE = {"between": 0, "sensor": 0, "retro": 0, "outside": 0}
WALL_Z, SIDE_X = 1.0, 0.3
RHO_WALL, RHO_SIDE = 0.8, 0.5


def sensor_of(shape, zones=2):
    """Zones that see everything alike, and a clock of 20 ps steps without a pulse's width."""
    x, y = (a.ravel() for a in np.meshgrid([-50.0, 900.0], [-50.0, 530.0]))
    maps = ResponseMaps(np.ones((1, zones, 4)), x, y, np.arange(4).astype(str))
    pulse = ImpulseResponse(np.arange(-1, 2) * 2e-11, np.array([0, 1.0, 0]))
    return footprints(maps, shape), Clock(2e-10, 120, np.full(zones, 2e-9), pulse)


def pinhole(shape):
    focal = 0.72 * shape[1]
    return np.array([[focal, 0, (shape[1] - 1) / 2], [0, focal, (shape[0] - 1) / 2], [0, 0, 1]])


@pytest.fixture
def corner():
    """Two plates at right angles, a wall before the sensor and one at its side; zone 0 sees the first, 1 the other."""
    shape, matrix = (37, 53), pinhole((37, 53))
    x = np.broadcast_to((np.arange(shape[1]) - matrix[0, 2]) / matrix[0, 0], shape)
    side = x * WALL_Z > SIDE_X
    depth = np.where(side, SIDE_X / np.where(side, x, 1), WALL_Z)
    where, clock = sensor_of(shape)
    light = direct_light(depth[None], matrix, np.where(side, RHO_SIDE, RHO_WALL)[None])
    return SimpleNamespace(
        light=light, clock=clock, matrix=matrix, shape=shape,
        footprints=where.changed(lambda weights: weights * np.stack([~side, side])),
    )  # fmt: skip


def drawn_bounces(corner, from_wall, rays, rng):
    """Total (over pixels, 1/m²) and path lengths with weights of light that rays carry from one plate to the other."""
    matrix, (height, width) = corner.matrix, corner.shape
    reach_x, reach_y = width / 2 / matrix[0, 0], height / 2 / matrix[1, 1]
    near_z = SIDE_X / reach_x
    y = rng.uniform(-reach_y, reach_y, rays) * WALL_Z
    if from_wall:
        start = np.stack([rng.uniform(-reach_x * WALL_Z, SIDE_X, rays), y, np.full(rays, WALL_Z)], axis=1)
        area, normal, rho = (SIDE_X + reach_x * WALL_Z) * 2 * reach_y * WALL_Z, np.array([0, 0, -1.0]), RHO_WALL
    else:
        start = np.stack([np.full(rays, SIDE_X), y, rng.uniform(near_z, WALL_Z, rays)], axis=1)
        area, normal, rho = (WALL_Z - near_z) * 2 * reach_y * WALL_Z, np.array([-1.0, 0, 0]), RHO_SIDE
    # Lambert's cosine about the normal: a point of the unit disc, lifted to the sphere.
    angle, square = rng.uniform(0, 2 * np.pi, rays), rng.uniform(0, 1, rays)
    across, along = np.array([0, 1.0, 0]), np.cross(normal, [0, 1.0, 0])
    disc = np.sqrt(square)[:, None] * (np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * along)
    way = disc + np.sqrt(1 - square)[:, None] * normal
    with np.errstate(divide="ignore"):
        length = (SIDE_X - start[:, 0]) / way[:, 0] if from_wall else (WALL_Z - start[:, 2]) / way[:, 2]
    hit = (length > 0) & np.isfinite(length)
    start, way, length = start[hit], way[hit], length[hit]
    end = start + length[:, None] * way
    other, rho_other = (np.array([-1.0, 0, 0]), RHO_SIDE) if from_wall else (np.array([0, 0, -1.0]), RHO_WALL)

    def in_view(at):
        inside = (np.abs(at[:, 0]) <= reach_x * at[:, 2]) & (np.abs(at[:, 1]) <= reach_y * at[:, 2])
        return inside & (at[:, 2] > 0) & (at[:, 2] <= WALL_Z + 1e-9) & (at[:, 0] <= SIDE_X + 1e-9)

    seen = in_view(start) & in_view(end)
    start, end, length = start[seen], end[seen], length[seen]
    r_start, r_end = np.linalg.norm(start, axis=1), np.linalg.norm(end, axis=1)
    sent = rho * np.abs(start @ normal) / r_start**3 * area / rays
    # Pixels by area of surface: f² cosθ / (r² cos³α).
    pixels = matrix[0, 0] * matrix[1, 1] * np.abs(end @ other) / r_end**3 * (r_end / end[:, 2]) ** 3
    return sent * rho_other * pixels, r_start + length + r_end


@pytest.mark.parametrize("from_wall", [True, False])
@pytest.mark.parametrize(("cells", "near"), [(10_000, 0.03), (bounce.CELLS, 0.12)])
def test_two_plates_exchange_what_drawn_rays_carry(corner, from_wall, cells, near, monkeypatch):
    """By pixels within a few parts in a hundred, which the disc at the fold misses; by patches, a tenth."""
    monkeypatch.setattr(bounce, "CELLS", cells)
    weight, path = drawn_bounces(corner, from_wall, 400_000, np.random.default_rng(3))
    lattice = corner.clock.lattice
    found = bounces(corner.light, corner.footprints, corner.clock, 0.0, 0.0)[0, 1 if from_wall else 0]
    statistics = np.sqrt(np.square(weight).sum()) / weight.sum()
    assert found.sum() == pytest.approx(weight.sum(), rel=near + 4 * statistics)
    paths = C * (lattice.first_s + lattice.step_s * np.arange(lattice.size) - 2e-9)
    edges = np.arange(1.5, 3.3, 0.06)
    drawn = np.histogram(path, edges, weights=weight)[0]
    mine = np.histogram(paths, edges, weights=found)[0]
    assert np.abs(np.cumsum(mine - drawn)).max() < (near + 4 * statistics) * drawn.sum()


def test_zones_that_begin_later_get_the_same_later(corner):
    width = corner.clock.lattice.step_s
    zeros = np.broadcast_to(corner.clock.time_zero_s, 2) + np.array([0.0, 7.3 * width])
    found = bounces(corner.light, corner.footprints, corner.clock, 0.0, 0.0)[0]
    later = bounces(corner.light, corner.footprints, replace(corner.clock, time_zero_s=zeros), 0.0, 0.0)[0]
    np.testing.assert_allclose(later[0], found[0], atol=1e-15)
    np.testing.assert_allclose(later[1, 8:], 0.7 * found[1, 1:-7] + 0.3 * found[1, :-8], atol=1e-9 * found.max())
    assert not later[1, :7].any()


def test_a_flat_wall_lights_nothing_and_zones_that_see_nothing_receive_nothing(corner):
    flat = direct_light(np.ones((1, *corner.shape)), corner.matrix)
    assert bounces(flat, corner.footprints, corner.clock, 0.0, 0.0).max() < 1e-9
    half = corner.footprints.changed(lambda weights: weights * np.array([1.0, 0])[:, None, None])
    found = bounces(corner.light, half, corner.clock, 0.0, 0.0)
    assert found[0, 0].sum() > 0
    assert found[0, 1].sum() == 0


def test_a_source_aimed_where_the_zones_look_lights_that_alone(corner, monkeypatch):
    monkeypatch.setattr(bounce, "CELLS", 10_000)
    scene = corner.light, corner.footprints, corner.clock
    np.testing.assert_allclose(bounces(*scene, 1.0, 0.0), bounces(*scene, 0.0, 0.0), rtol=1e-9, atol=1e-15)
    # Of the corner's two plates zones see one: nothing else is lit, and one plate alone does not light itself.
    one = corner.footprints.changed(lambda weights: weights * np.array([1.0, 0])[:, None, None])
    assert bounces(corner.light, one, corner.clock, 0.0, 0.0).max() > 1e-6
    assert bounces(corner.light, one, corner.clock, 1.0, 0.0).max() < 1e-9


def test_zones_that_moved_see_bounces_where_they_did_and_zones_that_changed_where_they_do(corner):
    x, y = (a.ravel() for a in np.meshgrid([-50.0, 900.0], [-50.0, 530.0]))
    sloping = ResponseMaps(np.array([[[0.2, 1, 0.2, 1], [1, 0.2, 1, 0.2]]]), x, y, np.arange(4).astype(str))
    where = footprints(sloping, corner.shape)
    still = bounces(corner.light, where, corner.clock, 0.0, 0.0)
    moved = where.moved(150.0, 0.0)
    assert np.abs(moved.weights - where.weights).max() > 0.1
    np.testing.assert_array_equal(bounces(corner.light, moved, corner.clock, 0.0, 0.0), still)
    changed = where.changed(lambda weights: weights[..., ::-1, :, :])
    exchanged = bounces(corner.light, changed, corner.clock, 0.0, 0.0)
    np.testing.assert_allclose(exchanged, still[:, ::-1], rtol=1e-6)
    both = bounces(corner.light, changed.moved(150.0, 0.0), corner.clock, 0.0, 0.0)
    assert np.abs(both - exchanged).max() > 0.1 * still.max()


def test_rough_surfaces_exchange_light_whichever_way_they_face(corner, monkeypatch):
    monkeypatch.setattr(bounce, "CELLS", 60)
    found = bounces(corner.light, corner.footprints, corner.clock, 0.0, 1.0)[0]
    made = patches(corner.light, 0)
    weights = corner.footprints.weights * corner.light.reflectance[0]
    expected, paths = np.zeros(2), np.zeros(2)
    away = np.linalg.norm(made.point_m, axis=1)
    for i in range(len(made.area_m2)):
        for j in set(range(len(made.area_m2))) - {i}:
            apart = np.linalg.norm(made.point_m[i] - made.point_m[j])
            given = made.sent_sr[i] / 4 / (np.pi * apart**2 + made.area_m2[i]) * weights[:, made.label == j].sum(axis=1)
            expected += given
            paths += given * (away[i] + apart + away[j])
    np.testing.assert_allclose(found.sum(axis=1), expected, rtol=1e-5)
    lattice = corner.clock.lattice
    arrival = (
        lattice.first_s + lattice.step_s * np.arange(lattice.size) - np.broadcast_to(corner.clock.time_zero_s, 2)[0]
    )
    np.testing.assert_allclose(found @ arrival * C, paths, rtol=1e-5)
    # A wall that lights nothing if it is matt does if it is rough.
    flat = direct_light(np.ones((1, *corner.shape)), corner.matrix)
    assert bounces(flat, corner.footprints, corner.clock, 0.0, 1.0).max() > 1e-6


def test_patches_do_not_hang_between_the_two_sides_of_an_edge(corner):
    depth = np.where(np.arange(corner.shape[1]) < 20, 0.5, 1.5) * np.ones((1, *corner.shape))
    depth[0, :3] = np.nan
    made = patches(direct_light(depth, corner.matrix, 0.4), 0)
    assert (np.minimum(np.abs(made.point_m[:, 2] - 0.5), np.abs(made.point_m[:, 2] - 1.5)) < 1e-6).all()
    assert (made.label[:3] == OUTSIDE).all()
    assert (made.label[3:] != OUTSIDE).all()
    np.testing.assert_allclose(made.normal, np.broadcast_to([0, 0, -1.0], made.normal.shape), atol=1e-5)
    pixel = 1 / (corner.matrix[0, 0] * corner.matrix[1, 1])
    assert made.area_m2.sum() == pytest.approx(34 * pixel * (20 * 0.5**2 + 33 * 1.5**2), rel=1e-6)


def test_a_plane_outside_the_view_is_an_image_of_the_sensor_behind_it():
    """A wall before the sensor, lit a second time from a place beside it: the inverse square and Lambert's cosine."""
    shape, matrix, (where, clock) = (30, 40), pinhole((30, 40)), sensor_of((30, 40))
    v, u = np.mgrid[:30, :40]
    point = np.stack([(u - 19.5) / matrix[0, 0], (v - 14.5) / matrix[1, 1], np.ones(shape)], axis=-1) * 0.9
    light = direct_light(np.full((1, *shape), 0.9), matrix, 0.6)
    direction = np.array([np.cos(np.radians(30)), np.sin(np.radians(30)), 0])
    mirrored = point + 2 * (1.2 - point @ direction)[..., None] * direction
    r, far = np.linalg.norm(point, axis=-1), np.linalg.norm(mirrored, axis=-1)
    np.testing.assert_allclose(np.linalg.norm(point - 2.4 * direction, axis=-1), far)
    second = Return(((r + far) / 2)[None].astype(np.float32), (0.2 * 0.6 * 0.9 / far**3)[None].astype(np.float32))
    closed = ForwardModel(replace(light, returns=(*light.returns, second)), where, clock).expected(1e3)
    setting = effect.at(**{**NONE, "outside": 0.2}, outside_distance=1.2, outside_azimuth=30)
    found = ForwardModel(light, where, clock).expected(1e3, [setting])
    np.testing.assert_allclose(found, closed, atol=1e-5 * closed.max())


def test_what_stands_behind_the_outside_plane_gets_nothing_of_it():
    light, (where, clock) = direct_light(np.ones((1, 30, 40)), pinhole((30, 40)), 0.6), sensor_of((30, 40))
    right = where.changed(lambda weights: weights * (np.arange(40) > 30))
    model = ForwardModel(light, right, clock)
    setting = effect.at(**{**NONE, "outside": 1}, outside_distance=0.2, outside_azimuth=0)
    np.testing.assert_allclose(model.expected(1e3, [setting]), model.expected(1e3), atol=1e-9)
    assert model.expected(1e3, [setting.with_value("outside_azimuth", 180)]).sum() > 1.01 * model.expected(1e3).sum()


def test_a_plane_that_leans_is_an_image_of_the_sensor_too():
    """Half the path is half of what it is to the mirror image, wherever the plane stands."""
    light, tilt = direct_light(np.full((1, 9, 9), 0.8), pinhole((9, 9)), 0.5), np.radians(25)
    half, strength = by_way_of_plane(light, 0.9, 90.0, 25.0)
    image = 1.8 * np.array([0, np.cos(tilt), np.sin(tilt)])
    point = light.rays * 0.8
    r, far = np.linalg.norm(point, axis=-1), np.linalg.norm(point - image, axis=-1)
    np.testing.assert_allclose(half[0], (r + far) / 2, rtol=1e-6)
    # A wall at right angles to z: the cosine is the way along z.
    cosine = np.clip(0.8 - image[2], 0, None) / far
    np.testing.assert_allclose(strength[0], 0.5 * cosine / far**2, rtol=1e-4)


def test_a_plane_that_goes_along_with_the_sensor_is_as_far_in_every_frame():
    """And what is dimmed as direct light is goes with it, whatever the way."""
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 0, 3] = 0.3
    still = direct_light(np.full((2, 9, 9), 0.8), pinhole((9, 9)), 0.5)
    moved = replace(still, motion=Motion.of([0.0, 1.0], poses), time_s=np.array([0.0, 1.0]))
    half, strength = by_way_of_plane(moved, 0.9, 0.0, 10.0, False, True)
    np.testing.assert_allclose(half[1], half[0])
    np.testing.assert_allclose(half, by_way_of_plane(still, 0.9, 0.0, 10.0)[0])
    assert np.abs(by_way_of_plane(moved, 0.9, 0.0, 10.0)[0][1] - half[1]).max() > 0.1
    np.testing.assert_allclose(strength, moved.returns[0].strength, rtol=1e-6)


def test_it_suggests_planes_by_how_late_the_light_is():
    light, (where, clock) = direct_light(np.full((1, 30, 40), 0.9), pinhole((30, 40)), 0.6), sensor_of((30, 40))
    model = ForwardModel(light, where, clock)
    nominal = model.expected(1e5)
    truth = effect.at(outside=0.3, outside_distance=0.8, outside_azimuth=180)
    excess = model.expected(1e5, [truth]) - nominal
    starts = effect.starts(excess, nominal, Rendering(light, where, clock, 1e5))
    planes = [start for start in starts if "outside_azimuth" in start]
    assert {start["outside_azimuth"] for start in planes} == {0.0, 90.0, 180.0, -90.0}
    assert min(abs(start["outside_distance"] - 0.8) for start in planes) < 0.2


@pytest.mark.parametrize(("moves", "ways"), [(True, {(1, 0), (0, 1), (0, 0)}), (False, {(1, 0), (0, 1)})])
def test_a_plane_that_goes_along_may_send_on_its_own_light_where_it_is_known_to_go(moves, ways):
    """Over a floor a robot goes on, which tells by how bright it is; where nothing moves it is one that stands."""
    still, (where, clock) = direct_light(np.full((2, 30, 40), 0.9), pinhole((30, 40)), 0.6), sensor_of((30, 40))
    poses = np.stack([np.eye(4), np.eye(4)])
    poses[1, 1, 3] = -0.3
    times = np.array([0.0, 1.0])
    light = replace(still, time_s=times, motion=Motion.of([0.0, 1.0], poses) if moves else None)
    model = ForwardModel(light, where, clock)
    nominal = model.expected(1e5)
    truth = effect.at(outside=0.3, outside_distance=0.5, outside_azimuth=90, outside_stands=0, outside_dimmed=0)
    excess = model.expected(1e5, [truth]) - nominal
    starts = effect.starts(excess, nominal, Rendering(light, where, clock, 1e5))
    planes = [start for start in starts if "outside_azimuth" in start]
    assert {(start["outside_stands"], start["outside_dimmed"]) for start in planes} == ways

    def gained(start):
        change = model.expected(1e5, [effect.at(outside=0.1, **start)]) - nominal
        return float((change * excess).sum() ** 2 / (change**2).sum())

    best = max(planes, key=gained)
    assert best["outside_azimuth"] == 90
    assert not moves or best["outside_stands"] == 0


def test_walls_all_around_are_a_source_farther_off():
    light = direct_light(np.full((1, 30, 40), 0.9), pinhole((30, 40)), 0.6)
    where, clock = sensor_of((30, 40))
    values = effect.at(around=0.3, around_distance=0.8).values
    direct, by_wall = effect.light(values, Rendering(light, where, clock, 1.0)).returns
    straight = direct.range_m
    far = np.sqrt(straight**2 + 1.6**2)
    np.testing.assert_allclose(2 * by_wall.range_m, straight + far, rtol=1e-6)
    np.testing.assert_allclose(by_wall.strength, 0.3 * 0.6 * (0.9 / straight) / far**2, rtol=1e-5)


@pytest.mark.parametrize("z", [0.2, 0.4])
def test_the_sensors_face_is_a_second_lamp(z):
    """Over a wall at z: irradiance of the face in closed integral, its lamp's cosine, and nothing before 4 z / c."""
    shape, matrix, (where, clock) = (30, 40), pinhole((30, 40)), sensor_of((30, 40))
    light = direct_light(np.full((1, *shape), z), matrix, 0.6)
    model = ForwardModel(light, where, clock)
    echo = (model.expected(1e3, [effect.at(**{**NONE, "sensor": 1e-3})]) - model.expected(1e3))[0, 0]
    x, y = 20 / matrix[0, 0], 15 / matrix[1, 1]
    # A wall of radiance L = ρ cosθ / (π r²) seen from its foot: ∫ L cosα dΩ, with cosθ = cosα and r = z / cosα.
    face = dblquad(lambda b, a: 0.6 / np.pi / z**2 * (1 + a * a + b * b) ** -3.5, -x, x, -y, y)[0]
    v, u = np.mgrid[:30, :40]
    cosine = (1 + ((u - 19.5) / matrix[0, 0]) ** 2 + ((v - 14.5) / matrix[1, 1]) ** 2) ** -0.5
    closed = 1e3 * (0.6 * cosine**3 / z**2 * cosine).sum() * 1e-3 * face / np.pi
    assert echo.sum() == pytest.approx(closed, rel=2e-3)
    first = np.flatnonzero(echo > 1e-6 * echo.max())[0] * clock.bin_width_s - 2e-9
    assert first == pytest.approx(4 * z / C, abs=clock.bin_width_s)


def test_the_lens_sends_light_back_to_where_it_came_from(small):
    """A scene of two returns, the second from twice as far and of the square's strength."""
    direct = small.light.returns[0]
    second = Return(2 * direct.range_m, 0.03 * direct.strength**2)
    lit = replace(small.light, returns=(direct, second))
    closed = ForwardModel(lit, small.footprints, small.clock).expected(1e3)
    found = ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [effect.at(retro=0.03)])
    np.testing.assert_allclose(found, closed, rtol=1e-5)


@pytest.mark.parametrize("spreading", [0.0, 1.5])
def test_a_mirror_sends_the_same_light_once_more(small, spreading):
    """A scene of two returns, the second from twice as far and weaker by a power of range."""
    direct = small.light.returns[0]
    second = Return(2 * direct.range_m, 0.07 * direct.strength / direct.range_m**spreading)
    closed = ForwardModel(replace(small.light, returns=(direct, second)), small.footprints, small.clock).expected(1e3)
    mirrored = effect.at(mirrored=0.07, spreading=spreading)
    found = ForwardModel(small.light, small.footprints, small.clock).expected(1e3, [mirrored])
    np.testing.assert_allclose(found, closed, rtol=1e-5)


def test_the_ways_add_up(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    ways = [{"between": 0.7}, {"sensor": 1e-2}, {"outside": 0.3}, {"retro": 1e-2}]
    alone = [model.expected(1e3, [effect.at(**{**NONE, **way})]) - model.expected(1e3) for way in ways]
    assert all(way.max() > 1e-2 for way in alone)
    assert all((way > -1e-9).all() for way in alone)
    together = model.expected(1e3, [effect.at(between=0.7, sensor=1e-2, outside=0.3, retro=1e-2)]) - model.expected(1e3)
    np.testing.assert_allclose(together, sum(alone), atol=1e-9 * together.max())


def test_a_cavity_that_holds_light_longer_than_it_is_wide_is_a_stretched_name():
    one = {"cavity": 0.1, "cavity_breadth": 0.5}
    assert not effect.strained(effect.at(**one, cavity_late=0.5).values, None)
    assert effect.strained(effect.at(**one, cavity_late=1.5).values, None)
    assert effect.strained(effect.at(cavity=0.1, cavity_late=0.5, cavity_breadth=1.6).values, None)
    assert not effect.strained(effect.at(between=1.0, cavity=0.0, cavity_late=1.5).values, None)
