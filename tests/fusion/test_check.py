"""Maps that are right, and maps that are wrong in known ways, against recordings whose light nobody guessed right."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from fusion.check import check
from physics.effects import (
    cover_glass_crosstalk,
    gain_drift,
    impulse_tail,
    parallax,
    pile_up,
    time_zero_drift,
    time_zero_offset,
    zone_gain,
)
from physics.presets import preset
from physics.scene.camera import pinhole
from physics.scene.view import View, Views
from physics.sensor import SensorModel
from physics.simulate import simulate
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

SIZE = (106, 60)
SENSOR = preset("tmf8828-3x3-wide-long")
ZONE_DELAYS_S = np.array([6, -5, 0, 8, -7, 3, -4, 5, -6]) * 1e-11


@pytest.fixture(scope="module")
def maps():
    """Nine bells, 200 by 120 px apart, in an image of 848 × 480."""
    rng = np.random.default_rng(0)
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(10, 838, 32), np.linspace(10, 470, 18)))
    x, y = np.array([x, y]) + rng.uniform(-2, 2, (2, x.size))
    bells = [np.exp(-(((x - a) / 110) ** 2) - ((y - b) / 70) ** 2) for b in (120, 240, 360) for a in (224, 424, 624)]
    level = rng.uniform(0.6, 1.0, (9, 1))
    return ResponseMaps((np.stack(bells) * level * 1e3).reshape(3, 3, -1), x, y, np.arange(x.size).astype(str))


def rooms(rng, frames=5):
    """(F, H, W) depth: boards at random places and distances before a wall that slants."""
    v, u = np.mgrid[: SIZE[1], : SIZE[0]] * 1.5
    depth = np.empty((frames, *v.shape), np.float32)
    for image in depth:
        image[:] = 3.5 + rng.uniform(-0.005, 0.005) * (u - 80) + rng.uniform(-0.01, 0.01) * (v - 45)
        for far in np.sort(rng.uniform(0.8, 3.2, 9))[::-1]:
            left, top = rng.uniform(0, 130), rng.uniform(0, 70)
            wide, high = rng.uniform(15, 50, 2)
            image[(u > left) & (u < left + wide) & (v > top) & (v < top + high)] = far
    return depth


def recorded(depth, maps, seed, realistic=True):
    """A recording, with reflectance as somebody may guess it and not as it is."""
    rng = np.random.default_rng(seed)
    effects = (
        impulse_tail.effect.at(share=0.12, tau=4e-10),
        time_zero_offset.effect.at(delay=8e-11 + rng.normal(0, 3e-11, 9)),
        gain_drift.effect.at(),
        zone_gain.effect.at(factor=rng.uniform(0.8, 1.2, 9)),
        pile_up.effect.at(),
        cover_glass_crosstalk.effect.at(share=2e-3),
    )
    blobs = [gaussian_filter(rng.standard_normal(image.shape), 8) for image in depth]
    true = [np.clip(0.4 * np.exp(0.4 * blob / blob.std()), 0.02, 1).astype(np.float32) for blob in blobs]
    views = [View(i / 10, image, albedo) for i, (image, albedo) in enumerate(zip(depth, true, strict=True))]
    sensor = replace(SENSOR, effects=effects) if realistic else SENSOR
    stream, _ = simulate(Views(pinhole(SIZE, 69.4), iter(views), len(views), None, {}), maps, sensor, rng)
    whole = stream.collect()
    return replace(whole, reflectance=np.full(depth.shape, 0.4, np.float32) if realistic else whole.reflectance)


def reordered(maps, order):
    zones = maps.responses.reshape(9, -1)[list(order)]
    return replace(maps, responses=zones.reshape(maps.responses.shape))


def turned(maps, degrees):
    """Footprints turned about the middle of the image, as of a sensor that is mounted askew."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y = maps.xs - 424, maps.ys - 240
    return replace(maps, xs=424 + cosine * x - sine * y, ys=240 + sine * x + cosine * y)


WRONG = {
    "mirrored": [
        lambda m: replace(m, responses=m.responses[:, ::-1].copy()),
        lambda m: replace(m, responses=m.responses[::-1].copy()),
        lambda m: replace(m, responses=m.responses[::-1, ::-1].copy()),
        lambda m: replace(m, responses=m.responses.swapaxes(0, 1).copy()),
        lambda m: replace(m, xs=847 - m.xs),
    ],
    "shifted": [lambda m: replace(m, xs=m.xs + 12), lambda m: replace(m, ys=m.ys - 12)],
    "exchanged": [
        lambda m: reordered(m, (0, 2, 1, 3, 4, 5, 6, 7, 8)),
        lambda m: reordered(m, (0, 1, 2, 3, 8, 5, 6, 7, 4)),
    ],
    "another rig": [
        lambda m: turned(m, 12),
        lambda m: replace(m, xs=424 + 1.6 * (m.xs - 424), ys=240 + 1.6 * (m.ys - 240)),
        lambda m: replace(m, xs=424 + 0.6 * (m.xs - 424), ys=240 + 0.6 * (m.ys - 240)),
        lambda m: replace(m, xs=424 + 1.2 * (m.xs - 424), ys=240 + 1.2 * (m.ys - 240)),
    ],
}


@pytest.fixture(scope="module")
def scene(maps):
    return recorded(rooms(np.random.default_rng(7)), maps, 7)


def verdict(recording, maps, seed=0):
    return check(recording, maps, SensorModel.of(recording), np.random.default_rng(seed))


def test_right_maps_are_fine(scene, maps):
    found = verdict(scene, maps)
    assert found.kind == "fine", found.sentence
    assert found.departures == ()
    assert min(zone.cosine for zone in found.zones) > 0.8


def test_bias_is_that_of_the_clock(maps):
    """A clock that is 0.2 ns late: 30 mm too far."""
    recording = recorded(rooms(np.random.default_rng(2), 2), maps, 2, realistic=False)
    late = replace(recording, time_zero_s=recording.time_zero_s - 2e-10)
    found = verdict(late, maps)
    assert found.bias_m == pytest.approx(0.03, abs=0.005)
    assert min(zone.cosine for zone in found.zones) > 0.7


@pytest.mark.parametrize(("kind", "way"), [("mirrored", 4), ("shifted", 0), ("exchanged", 1), ("another rig", 0)])
def test_wrong_maps_are_told(scene, maps, kind, way):
    found = verdict(scene, WRONG[kind][way](maps))
    assert found.kind == kind, found.sentence
    if kind == "shifted":
        (one,) = found.departures
        assert one.values["shift_px"] == pytest.approx([(12, 0), (0, -12)][way], abs=5)
    if kind == "exchanged":
        assert found.departures[0].values["zones"] == [[[1, 2]], [[4, 8]]][way]


@pytest.mark.slow
def test_a_shift_beyond_what_is_tried_at_once_is_one(scene, maps):
    found = verdict(scene, replace(maps, xs=maps.xs - 34))
    assert found.kind == "shifted"
    (one,) = found.departures
    assert one.values["shift_px"] == pytest.approx((-34, 0), abs=5)


def test_a_session_that_drifts_is_compared_at_its_own_times(maps):
    """A clock that is later by 2 ps every second, in frames a minute apart: 36 mm on average, if nobody knew."""
    effects = (time_zero_drift.effect.at(rate=2e-12),)
    views = [View(60.0 * i, image) for i, image in enumerate(rooms(np.random.default_rng(4)))]
    grid = pinhole(SIZE, 69.4)
    drifting = replace(SENSOR, effects=effects)
    stream, _ = simulate(Views(grid, iter(views), len(views), None, {}), maps, drifting, np.random.default_rng(4))
    recording = stream.collect()
    known = check(recording, maps, replace(SensorModel.of(recording), effects=effects), np.random.default_rng(0))
    assert known.kind == "fine"
    assert known.bias_m == pytest.approx(0, abs=0.005)


def test_delays_of_zones_are_not_taken_for_light(maps):
    """In short range 50 ps are half a bin: shifts of maps are known about as well as without."""
    depth = 0.4 * rooms(np.random.default_rng(9))
    views = [View(i / 10, image) for i, image in enumerate(depth)]
    known = {}
    for name, effects in (("none", ()), ("delays", (time_zero_offset.effect.at(delay=ZONE_DELAYS_S),))):
        sensor = replace(preset("tmf8828-3x3-wide-short"), effects=effects)
        scene = Views(pinhole(SIZE, 69.4), iter(views), len(views), None, {})
        recording = simulate(scene, maps, sensor, np.random.default_rng(9))[0].collect()
        found = verdict(recording, maps)
        assert found.kind == "fine", found.sentence
        known[name] = max(found.resolution_px)
    assert known["delays"] < 1.5 * known["none"]


@pytest.mark.slow
def test_mirrored_and_shifted_at_once(scene, maps):
    both = replace(maps, responses=maps.responses[:, ::-1].copy(), ys=maps.ys + 18)
    found = verdict(scene, both)
    assert found.kind in ("mirrored and shifted", "shifted and mirrored")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_no_false_alarm_and_no_miss(maps, seed):
    """Other scenes, other light: right maps are never blamed, wrong ones never praised."""
    recording = recorded(rooms(np.random.default_rng(100 + seed)), maps, seed)
    assert verdict(recording, maps, seed).kind in ("fine", "cannot tell")
    for kind, ways in WRONG.items():
        for wrong in ways:
            found = verdict(recording, wrong(maps), seed).kind
            assert found == kind or (kind in ("shifted", "another rig") and found == "cannot tell"), (kind, found)


@pytest.mark.parametrize("wrong", [lambda m: m, WRONG["mirrored"][0]])
def test_a_flat_wall_cannot_tell(maps, wrong):
    wall = np.full((3, SIZE[1], SIZE[0]), 2.0, np.float32)
    found = verdict(recorded(wall, maps, 1), wrong(maps))
    assert found.kind == "cannot tell"
    assert "too flat" in found.sentence


@pytest.mark.slow
def test_the_same_seed_gives_the_same(scene, maps):
    assert verdict(scene, maps).as_dict() == verdict(scene, maps).as_dict()


@pytest.mark.slow
def test_a_zone_that_is_dead_is_not_blamed(scene, maps):
    counts = scene.counts.copy()
    counts[:, 4] = 0
    found = verdict(replace(scene, counts=counts), maps)
    assert found.kind in ("fine", "cannot tell")
    assert found.zones[4].bias_m is None


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"depth_m": None, "reflectance": None, "incidence_cosine": None}, "depth_m is missing"),
        ({"counts": "zeros"}, "no frame has both counts and depth"),
        ({"depth_m": "far"}, "no light of any frame"),
    ],
)
def test_refusals(scene, maps, change, said):
    made = {"zeros": np.zeros_like(scene.counts), "far": np.full_like(scene.depth_m, 80.0)}
    fields = {name: made.get(value, value) if isinstance(value, str) else value for name, value in change.items()}
    with pytest.raises(Refusal, match=said):
        verdict(replace(scene, **fields), maps)


def test_maps_of_other_zones_are_refused(scene, maps):
    other = replace(maps, responses=maps.responses[:2])
    with pytest.raises(Refusal, match="2 x 3 zones, expected 9 as recorded"):
        verdict(scene, other)


def test_a_lidar_beside_the_camera_is_not_taken_for_a_shift(maps):
    """On a grid so fine that the comparison takes every other pixel."""
    mount = np.eye(4)
    mount[:2, 3] = -0.06, 0.02
    there = replace(maps, meta_json=json.dumps({"lidar_from_camera": mount.tolist(), "calibration_range_m": 0.6}))
    depth = rooms(np.random.default_rng(5), 3).repeat(4, axis=1).repeat(4, axis=2)
    views = [View(i / 10, image) for i, image in enumerate(depth)]
    sensor = replace(SENSOR, effects=(parallax.effect.at(x=0.06, y=-0.02),))
    grid = pinhole((depth.shape[2], depth.shape[1]), 69.4)
    stream, _ = simulate(Views(grid, iter(views), len(views), None, {}), there, sensor, np.random.default_rng(5))
    assert verdict(stream.collect(), there).kind == "fine"
