"""A response that nobody recorded, of recordings in which not every zone sees the scene in every frame."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mismatch.estimated_sensor import _cut_off_level, _seeing, estimated_sensor, quiet_pedestal
from mismatch.open_simulation import OWN_PEDESTAL, simulation_of
from physics.sensor import SensorModel
from physics.sensor_file import load_sensor, save_sensor
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

from .conftest import BACKGROUND, WIDTH_S


@pytest.fixture(scope="module")
def apart(maps):
    """Maps of zones that see nothing of what the others do."""
    strong = maps.responses == maps.responses.max(axis=(0, 1))
    return ResponseMaps(np.where(strong, maps.responses, 0.0), maps.xs, maps.ys, maps.cap_ids)


def seen(rig, frames, zones, wider=0, seed=1):
    """A recording of the rig without a response, in some frames of which depth is unknown where some zones look.

    wider: pixels by which it is unknown beyond the middle, up to which maps are interpolated.
    """
    made = rig.recording(np.random.default_rng(seed).poisson(rig.expected()), irf=None, irf_time_s=None)
    depth = np.array(made.depth_m)
    rows, columns = depth.shape[1:]
    v, u = np.indices((rows, columns))
    # Zones look left and right, above and below.
    down, right = (v > rows / 2 - wider, v < rows / 2 + wider), (u > columns / 2 - wider, u < columns / 2 + wider)
    where = np.any([down[zone < 2] & right[zone % 2 == 0] for zone in zones] or [np.zeros(v.shape, bool)], axis=0)
    for i in frames:
        depth[i][where] = np.nan
    return rig.recording(made.counts, irf=None, irf_time_s=None, depth_m=depth)


def middle(sensor):
    """When the response of each zone arrives, as a mean, seconds."""
    return sensor.time_zero_s + (sensor.pulse.time_s * sensor.pulse.probability).sum()


@pytest.mark.parametrize(("frames", "zones"), [((1, 4, 7), (0,)), ((2, 9), (0, 1, 2, 3)), ((0, 1, 2, 3), (1, 2))])
def test_frames_that_some_zone_does_not_see_tell_nothing_of_it(rig, maps, frames, zones):
    whole, sentence = estimated_sensor(seen(rig, (), ()), maps)
    part, other = estimated_sensor(seen(rig, frames, zones), maps)
    np.testing.assert_allclose(middle(part), middle(whole), atol=0.1 * WIDTH_S)
    assert "estimated from" in sentence
    assert "estimated from" in other


def test_a_zone_that_sees_nothing_keeps_its_time_zero_and_counts(rig, apart):
    recording = seen(rig, range(24), (2,), wider=2)
    counts = np.array(recording.counts)
    counts[:, 2] = np.random.default_rng(3).poisson(BACKGROUND[2], counts[:, 2].shape)
    dark = rig.recording(counts, irf=None, irf_time_s=None, background_counts=None, depth_m=recording.depth_m)
    sensor, _ = estimated_sensor(dark, apart)
    assert sensor.time_zero_s[2] == dark.time_zero_s[2]
    assert sensor.background_counts[2] == pytest.approx(BACKGROUND[2], rel=0.1)


@pytest.mark.parametrize("assumed", [False, True])
def test_zones_are_late_only_where_time_zero_was_assumed(rig, maps, assumed):
    """One that whoever recorded it states holds; where there was no better than a table, zones are told apart."""
    meta = json.dumps({"assumed": ["bin_width_s and time_zero_s: typical"]} if assumed else {})
    recording = replace(seen(rig, (), ()), meta_json=meta)
    sensor, sentence = estimated_sensor(recording, maps)
    assert (sensor.time_zero_s != recording.time_zero_s).any() == assumed
    assert ("delays of zones" in sentence) == ("time_zero_s" in sensor.sources) == assumed


def test_where_no_zone_sees_anything_that_is_said(rig, maps):
    """Of the scene one corner is known, into which none looks."""
    narrow = np.where(maps.responses > 0.6 * maps.responses.max(), maps.responses, 0.0)
    recording = seen(rig, (), ())
    depth = np.full(np.shape(recording.depth_m), np.nan)
    depth[:, 0, 0] = 0.8
    corner = rig.recording(recording.counts, irf=None, irf_time_s=None, depth_m=depth)
    with pytest.raises(Refusal, match="no light of the scene reaches any zone"):
        estimated_sensor(corner, ResponseMaps(narrow, maps.xs, maps.ys, maps.cap_ids))


def test_zones_that_keep_others_from_being_seen_are_left_out():
    lit = np.ones((10, 4), bool)
    assert _seeing(lit) == [0, 1, 2, 3]
    lit[:4, 1] = False
    assert _seeing(lit) == [0, 1, 2, 3]
    lit[4:7, 3] = False
    # Each of the two is seen in most frames, both together in three.
    assert _seeing(lit) == [0, 2, 3]
    assert _seeing(np.zeros((10, 2), bool)) in ([0], [1])


@given(arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 6))))
def test_what_is_left_is_seen_at_once_or_is_one_zone(lit):
    zones = _seeing(lit)
    assert zones == sorted(set(zones))
    assert len(zones) == 1 or lit[:, zones].all(axis=1).mean() >= 0.5


@given(st.floats(0.5, 200), st.integers(0, 99))
def test_a_level_is_told_by_poisson_counts_that_are_cut_off(level, seed):
    counts = np.random.default_rng(seed).poisson(level, 4000)
    most = int(np.median(counts)) + 1
    # Of counts cut off about their median two thirds of the information are left.
    assert _cut_off_level(counts, most) == pytest.approx(level, abs=6 * np.sqrt(level / 4000) / 0.6)


@pytest.mark.parametrize("lamp", [1.0, 8.0])
def test_a_pedestal_is_this_recordings_own_though_light_is_there_that_the_model_lacks(rig, simulated, lamp):
    """A tenth of the light of all zones comes to each, in cells where hardly any is expected."""
    rng = np.random.default_rng(4)
    signal = rig.expected() - BACKGROUND[:, None]
    passed_on = 0.1 * signal.sum(axis=1, keepdims=True)
    simulation = simulated(rng.poisson(signal + passed_on + lamp * BACKGROUND[:, None]))
    np.testing.assert_allclose(quiet_pedestal(simulation), lamp * BACKGROUND, rtol=0.2)


def test_a_zone_that_is_lit_in_every_bin_keeps_the_pedestal_it_had(rig, simulated):
    simulation = simulated(np.random.default_rng(5).poisson(rig.expected()))
    none = replace(simulation, counts=np.zeros(simulation.counts.shape))
    np.testing.assert_array_equal(quiet_pedestal(none), BACKGROUND)


def test_a_sensor_found_elsewhere_brings_no_lamps_along(rig, tmp_path):
    """Nor where a pedestal was measured: that one holds, as does one that a recording has itself."""
    path, counts = tmp_path / "sensor.json", np.random.default_rng(6).poisson(rig.expected() + BACKGROUND[:, None])
    bare = rig.recording(counts, background_counts=None)
    sensor = replace(SensorModel.of(rig.recording(counts)), sources={"background_counts": "estimated from 9 frames"})
    save_sensor(sensor, path)
    simulation, assumed, notes = simulation_of(bare, rig.maps, load_sensor(path))
    np.testing.assert_allclose(simulation.background, 2 * BACKGROUND, rtol=0.1)
    np.testing.assert_array_equal(assumed.background_counts, simulation.background)
    assert OWN_PEDESTAL in notes
    measured = replace(sensor, sources={})
    np.testing.assert_array_equal(simulation_of(bare, rig.maps, measured)[0].background, BACKGROUND)
    held = simulation_of(rig.recording(counts), rig.maps, sensor)
    np.testing.assert_array_equal(held[0].background, BACKGROUND)
    assert OWN_PEDESTAL not in held[2]
