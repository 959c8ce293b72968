"""A response that nobody recorded, of recordings in which not every zone sees the scene in every frame."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mismatch.estimated_sensor import _seeing, estimated_sensor
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
