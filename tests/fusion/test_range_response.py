"""Histograms by range against overlaps of pulse and bin written out, and against formulas of the effects."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.range_response import range_response, window_ranges
from physics.effects import find_effect
from recordings.refusal import Refusal

C = 299_792_458.0


def share_in_bins(range_m, zero_s, sensor):
    """(T,) share of a pulse in each bin: every step of the response against every bin."""
    pulse = sensor.pulse
    step = pulse.time_s[1] - pulse.time_s[0]
    shares = np.zeros(sensor.bins)
    for time, probability in zip(pulse.time_s, pulse.probability, strict=True):
        low = zero_s + 2 * range_m / C + time - step / 2
        for t in range(sensor.bins):
            edge = t * sensor.bin_width_s
            shares[t] += probability * max(0, min(low + step, edge + sensor.bin_width_s) - max(low, edge)) / step
    return shares


def test_a_nominal_sensor_spreads_one_count_over_its_pulse(rig):
    response, sensor = rig.response, rig.sensor
    for p, b in ((0, 3), (1, 20), (2, 41), (3, 60)):
        expected = share_in_bins(float(response.range_m[b]), sensor.time_zero_s[p], sensor)
        np.testing.assert_allclose(response.counts[p, b], expected, atol=1e-5)
    assert not response.lossy
    np.testing.assert_allclose(response.pedestal, 3.0)


def test_the_finer_table_holds_the_coarse_one_and_what_lies_between(rig):
    response, sensor = rig.response, rig.sensor
    for p, r in ((0, 14), (1, 81), (3, 202)):
        expected = share_in_bins(float(response.fine_m[r]), sensor.time_zero_s[p], sensor)
        np.testing.assert_allclose(response.fine_counts[p, r], expected, atol=1e-5)
    same = np.searchsorted(response.fine_m, response.range_m - 1e-9)
    np.testing.assert_allclose(response.fine_m[same], response.range_m)
    np.testing.assert_allclose(response.fine_counts[:, same], response.counts, atol=1e-9)


def test_ranges_are_half_a_bin_apart_up_to_the_end_of_the_window(rig):
    ranges, sensor = window_ranges(rig.sensor), rig.sensor
    np.testing.assert_allclose(np.diff(ranges), sensor.bin_width_s * C / 4)
    end = (sensor.bins * sensor.bin_width_s - sensor.time_zero_s.max()) * C / 2
    assert end - sensor.bin_width_s * C / 4 <= ranges[-1] <= end


def test_bands_hold_all_of_a_response(rig):
    for p, b in ((0, 0), (2, 30), (3, len(rig.response.range_m) - 1)):
        first, last = rig.response.bands[p, b]
        counts = rig.response.counts[p, b]
        assert counts[first:last].sum() == pytest.approx(counts.sum(), rel=1e-4)


def test_the_sum_and_the_whole_model_agree_where_nothing_is_lost(rig):
    light = np.random.default_rng(0).uniform(0, 40, (2, 4, len(rig.response.range_m)))
    level = np.array([[1.0, 3, 5, 2], [3, 3, 3, 3]])
    np.testing.assert_allclose(rig.response.expected(light, level), rig.response.linear(light, level), rtol=1e-5)


def test_pile_up_is_that_of_first_photons(rig):
    sensor = replace(rig.sensor, effects=(find_effect("pile_up").at(share=1.0),))
    response = range_response(sensor)
    assert response.lossy
    light = np.zeros((1, 4, len(response.range_m)))
    light[0, 1, 20] = 4e4
    made = rig.response.linear(light, np.full((1, 4), 3.0))[0, 1] / sensor.laser_cycles
    # The chance that a bin's photon is the first of its shot.
    first = np.exp(-np.concatenate([[0], np.cumsum(made)[:-1]])) - np.exp(-np.cumsum(made))
    found = response.expected(light, np.full((1, 4), float(response.flat[1])))[0, 1]
    # The level is what is seen of the background where it is dimmest.
    np.testing.assert_allclose(found, sensor.laser_cycles * first, rtol=2e-3, atol=0.1)


def test_light_that_strays_is_left_to_the_whole_model(rig):
    response = range_response(replace(rig.sensor, effects=(find_effect("stray_light").at(share=0.02),)))
    np.testing.assert_allclose(response.counts, rig.response.counts, atol=1e-9)
    light = np.zeros((1, 4, len(response.range_m)))
    light[0, 0, 30] = 1000
    assert response.lossy
    assert (response.expected(light, np.full((1, 4), 3.0))[0, 3] - 3).sum() == pytest.approx(20, rel=1e-3)


def test_crosstalk_is_in_the_pedestal(rig):
    setting = find_effect("cover_glass_crosstalk").at(share=1e-3, delay=0.0)
    response = range_response(replace(rig.sensor, effects=(setting,)))
    np.testing.assert_allclose(response.pedestal.sum(axis=1), 48 * 3 + 1e-3 * 100_000, rtol=1e-6)
    np.testing.assert_allclose(response.flat, 3, rtol=1e-6)


@pytest.mark.parametrize("ranges", [[0.5, 0.4], [0.0, 1.0], [[0.1, 0.2]], [np.nan, 1.0]])
def test_ranges_that_cannot_be_are_refused(rig, ranges):
    with pytest.raises(Refusal, match="ascending metres"):
        range_response(rig.sensor, np.array(ranges))


def test_a_window_without_range_is_refused(rig):
    with pytest.raises(Refusal, match="its window ends"):
        range_response(replace(rig.sensor, time_zero_s=np.full(4, 47.5 * 2.6e-10)))


def test_a_pane_is_the_sensors_and_one_translucent_thing_the_scenes(rig):
    pane, thing = (
        range_response(replace(rig.sensor, effects=(find_effect("second_surface").at(spacing=0.3, **which),)))
        for which in ({"passed": 0.2}, {"one": 0.2})
    )
    np.testing.assert_allclose(thing.counts, rig.response.counts, atol=1e-9)
    assert np.abs(pane.counts - rig.response.counts).max() > 0.05 * rig.response.counts.max()
