"""Sensors, their files, their presets."""

import contextlib
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.effects import find_effect
from physics.presets import preset, preset_names
from physics.pulse import ImpulseResponse
from physics.pulse_shape import PulseShape, Tail
from physics.sensor_choice import choose_sensor
from physics.sensor_file import load_sensor, save_sensor, sensor_of, sensor_to_json
from recordings.refusal import Refusal

PLAIN = {
    "format": "difflidar-sensor/1",
    "name": "A",
    "zone_grid": [1, 2],
    "bins": 16,
    "bin_width_s": 1e-9,
    "time_zero_s": 2e-9,
    "pulse": {"rise_s": 2e-10, "fall_s": 4e-10, "tails": [{"tau_s": 5e-10, "share": 0.1}]},
}
PEDESTAL = {"id": "ambient_pedestal", "parameters": [{"name": "level", "value": 4, "unit": "counts", "sigma": 1}]}


@pytest.mark.parametrize("name", preset_names())
def test_every_preset_is_whole_and_says_where_its_numbers_come_from(name):
    sensor = preset(name)
    assert sensor.clock.lattice.error < 1e-9
    assert sensor.response.probability.sum() == pytest.approx(1)
    numbers = {"zone_grid", "bins", "bin_width_s", "time_zero_s", "pulse", "laser_cycles", "laser_hz"}
    assert numbers | {"background_counts"} == sensor.sources.keys()


def test_facts_of_the_datasheet():
    long, short = preset("tmf8828-3x3-wide-long"), preset("tmf8828-3x3-wide-short")
    assert long.bin_width_s * 299792458 / 2 == pytest.approx(0.057, rel=1e-3)
    assert 1 / (short.bin_width_s * 299792458 / 2) == pytest.approx(72.1, abs=1.5)
    assert long.time_zero_s[0] / long.bin_width_s == pytest.approx(15.455)
    assert long.laser_cycles / long.laser_hz == pytest.approx(0.0317, rel=1e-2)  # 550 k iterations: 32.2 ms a frame.
    assert preset("tmf8828-8x8-long").zones == 64
    assert not any(name.startswith("tmf8820-4x4") for name in preset_names())


def test_a_file_gives_back_the_same_sensor(tmp_path):
    later = find_effect("zone_gain").at(factor=0.9, since=2.5)
    fogs = find_effect("footprint_blur").at(variance=9.0, grows=0.2, strong_at=3.0, settling=7.0)
    effects = (find_effect("pile_up").at(share=0.3), find_effect("ambient_pedestal").at(level=np.arange(9.0)))
    for sensor in (
        replace(preset("tmf8820-3x3-normal-short"), effects=(*effects, later, fogs)),
        replace(preset("tmf8820-3x3-normal-short"), pulse=preset("tmf8820-3x3-normal-long").response, laser_hz=None),
    ):
        save_sensor(sensor, tmp_path / "sensor.json")
        back = load_sensor(tmp_path / "sensor.json")
        assert sensor_to_json(back) == sensor_to_json(sensor)
        np.testing.assert_array_equal(back.response.probability, sensor.response.probability)
        assert [s.key for s in back.effects] == [s.key for s in sensor.effects]


def test_verdicts_carry_sigma_and_one_value_does_for_all_zones():
    sensor = sensor_of(PLAIN | {"effects": [PEDESTAL]})
    plain = find_effect("ambient_pedestal").vanished().values
    assert {name: value for name, value in sensor.effects[0].values.items() if value != plain[name]} == {"level": 4.0}
    assert sensor.time_zero_s.tolist() == [2e-9, 2e-9]
    assert sensor.background_counts.tolist() == [0, 0]


def changed(path, value):
    """PLAIN with an effect, and one value replaced or added."""
    said = json.loads(json.dumps(PLAIN | {"effects": [PEDESTAL]}))
    place = said
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    return said


PARAMETER = ("effects", 0, "parameters", 0)


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        (("format",), "difflidar-sensor/9", "format is 'difflidar-sensor/9', expected 'difflidar-sensor/1'"),
        (("colour",), 1, "unknown field 'colour'"),
        (("bins",), 12.5, "bins is 12.5, expected a whole number"),
        (("bins",), 0, "bins is 0, expected 1 to 65536"),
        (("bins",), 1e12, r"bins is 1e\+12, expected"),
        (("zone_grid",), [1e9, 10], r"zone_grid is 1e\+09 x 10, expected 1 or more of each, 16384 in all at most"),
        (("bin_width_s",), "1 ns", "bin_width_s is the text '1 ns', expected a finite number"),
        (("bin_width_s",), -1e-9, "bin_width_s is -1e-09, expected positive"),
        (("bin_width_s",), None, "bin_width_s is null"),
        (("zone_grid",), [3], "zone_grid is a list of 1, expected a list of 2"),
        (("zone_grid",), [0, 2], "zone_grid is 0 x 2"),
        (
            ("time_zero_s",),
            [1e-9, 2e-9, 3e-9],
            r"time_zero_s has shape \(3,\), expected one value or one for each of 2",
        ),
        (("background_counts",), -3, "background_counts holds -3"),
        (("laser_cycles",), 0, "laser_cycles is 0"),
        (("pulse", "rise_s"), 0, "rise_s is 0.0, expected positive"),
        (("pulse", "tails", 0, "share"), 1.2, r"tails\[0\].share is 1.2, expected 0 to 1"),
        (("pulse", "tails", 0, "tau_ns"), 1, r"pulse.tails\[0\] has the unknown field 'tau_ns'"),
        (("pulse",), {"time_s": [0, 1e-10], "probability": [0.5, 0.4]}, "pulse.probability sums to 0.9, expected 1"),
        (("pulse",), {"time_s": [0, 1e-10], "probability": [1.5, -0.5]}, r"probability\[1\] is -0.5, expected 0"),
        (("pulse",), {"time_s": [0, 1e-10], "probability": [1]}, "probability is a list of 1, expected a list of 2"),
        (("effects", 0, "id"), "fog", "effect 'fog' is unknown"),
        ((*PARAMETER, "name"), "depth", "'depth' is no parameter of it, expected one of level"),
        ((*PARAMETER, "unit"), "counts/s", "level has the unit 'counts/s', expected 'counts'"),
        ((*PARAMETER, "value"), -1, "level is -1, expected 0 to 1e"),
        ((*PARAMETER, "value"), [1, 2, 3], "level has 3 values, expected one or 2"),
        ((*PARAMETER, "value"), True, "value is true|value is True"),
        (("effects", 0, "strength"), 1, r"effects\[0\] has the unknown field 'strength'"),
        (("sources",), {"pulse": 3}, "sources.pulse is 3, expected a text"),
        (("sources",), {"price": "a shop"}, "sources names 'price'"),
    ],
)
def test_what_is_wrong_is_refused_by_name(path, value, sentence, tmp_path):
    file = tmp_path / "sensor.json"
    file.write_text(json.dumps(changed(path, value)))
    with pytest.raises(Refusal, match=sentence) as refusal:
        load_sensor(file)
    assert str(refusal.value).startswith(str(file))


@pytest.mark.parametrize("text", ["", "{", "[]", "3", '{"format": NaN}', "\x00\xff"])
def test_what_is_no_sensor_at_all_is_refused(text, tmp_path):
    (tmp_path / "sensor.json").write_text(text)
    with pytest.raises(Refusal):
        load_sensor(tmp_path / "sensor.json")


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(),
        lambda x: st.lists(x) | st.dictionaries(st.sampled_from([*PLAIN, "effects", "rise_s", "id"]), x),
        max_leaves=8,
    )
)
def test_whatever_stands_in_a_field_is_read_or_refused(value):
    for name in PLAIN:
        with contextlib.suppress(Refusal):
            sensor_of(PLAIN | {name: value})


@given(st.floats(1e-11, 2e-9), st.floats(1e-11, 2e-9), st.floats(1e-11, 2e-9), st.floats(0, 1))
def test_a_shape_is_sampled_in_whole_steps_of_the_bin(rise, fall, tau, share):
    response = PulseShape(rise, fall, (Tail(tau, share), Tail(2 * tau, 0.5))).sampled(1e-9)
    assert response.probability.sum() == pytest.approx(1)
    assert 1e-9 / response.step_s == pytest.approx(round(1e-9 / response.step_s))
    core = PulseShape(rise, fall).sampled(1e-9)
    mean = response.probability @ response.time_s - core.probability @ core.time_s
    assert mean == pytest.approx(tau * (share + 1), rel=0.05, abs=0.05e-9)


def test_the_sensor_of_a_recording(shared_data):
    sensor = choose_sensor(None, shared_data / "conformance" / "recording.npz", None)
    assert sensor.bins == 128
    assert sensor.zones == 9
    assert sensor.background_counts[0] == pytest.approx(18.7175, abs=1e-4)
    assert isinstance(sensor.pulse, ImpulseResponse)


def test_a_sensor_is_chosen_by_name_or_by_the_maps(maps, tmp_path):
    three = replace(maps, responses=np.resize(maps.responses, (3, 3, len(maps.xs))))
    assert choose_sensor("tmf8820-3x3-wide-short", "x", maps).name == "TMF8820"
    assert choose_sensor(None, "folder", three).mode == "3x3-wide, long range"
    short = replace(three, meta_json='{"ranging": "shortrange"}')
    assert choose_sensor(None, "folder", short).mode == "3x3-wide, short range"
    with pytest.raises(Refusal, match="2 x 2 zones, of no preset"):
        choose_sensor(None, "folder", maps)
    with pytest.raises(Refusal, match="tmf9999: neither"):
        choose_sensor("tmf9999", "folder", maps)
    with pytest.raises(FileNotFoundError):
        choose_sensor(str(tmp_path / "none.json"), "folder", maps)
    with pytest.raises(Refusal, match="is no preset"):
        preset("tmf8828-5x5-long")


def test_no_effect_is_on_twice():
    with pytest.raises(Refusal, match="ambient_pedestal is named twice"):
        sensor_of(PLAIN | {"effects": [PEDESTAL, PEDESTAL]})


@pytest.mark.parametrize("part", ["rise_s", "fall_s"])
def test_a_pulse_far_longer_than_its_bins_is_refused(part):
    with pytest.raises(Refusal, match=f"{part} is 1 s, 1e.09 bins long, expected at most 1000 bins"):
        PulseShape(**({"rise_s": 1e-9, "fall_s": 1e-9} | {part: 1.0})).sampled(1e-9)
    with pytest.raises(Refusal, match=r"tails\[0\].tau_s is 1 s"):
        PulseShape(1e-9, 1e-9, (Tail(1.0, 0.1),)).sampled(1e-9)
