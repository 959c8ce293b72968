"""A sensor as sensor.json: readable, with a version, and every number checked."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from physics.effects import find_effect
from physics.json_values import a_list, a_number, a_text, a_whole_number, an_object, numbers, one_or_more
from physics.pulse import ImpulseResponse
from physics.pulse_shape import PulseShape, Tail
from physics.sensor import SensorModel
from physics.setting import OF_EVERY, Setting
from recordings.atomic import written_aside
from recordings.refusal import Refusal
from recordings.relations import check_irf
from recordings.untrusted import reading

FORMAT = "difflidar-sensor/1"
# Field -> whether it must be there.
OPTIONAL = ("mode", "laser_cycles", "laser_hz", "background_counts", "effects", "sources")
NEEDED = ("format", "name", "zone_grid", "bins", "bin_width_s", "time_zero_s", "pulse")
SENSOR = {**dict.fromkeys(NEEDED, True), **dict.fromkeys(OPTIONAL, False)}
SHAPE = {"rise_s": True, "fall_s": True, "tails": False}
SAMPLED = {"time_s": True, "probability": True}
TAIL = {"tau_s": True, "share": True}
EFFECT = {"id": True, "parameters": False}
PARAMETER = {"name": True, "value": True, "unit": True, "sigma": False}


def load_sensor(path: str | Path) -> SensorModel:
    """The sensor in a file; refuses, in one sentence that names the field, whatever is not as it should be."""
    path = Path(path)
    with reading(path, "sensor.json"):
        return sensor_of(json.loads(path.read_text(encoding="utf-8")))


def save_sensor(sensor: SensorModel, path: str | Path) -> None:
    """Write a sensor so that `load_sensor` finds the same."""
    with written_aside(path) as aside:
        aside.write_text(json.dumps(sensor_to_json(sensor), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def sensor_of(said: Any) -> SensorModel:
    """The sensor that a JSON object describes."""
    if isinstance(said, dict) and said.get("format") != FORMAT:
        raise Refusal(f"format is {said.get('format')!r}, expected {FORMAT!r}")
    # null stands for a number that is not known.
    known = {name: value for name, value in an_object(said, SENSOR, "sensor").items() if value is not None}
    rows, columns = a_list(known.get("zone_grid"), "zone_grid", 2)
    width = a_number(known.get("bin_width_s"), "bin_width_s")
    read = {"laser_cycles": a_whole_number, "laser_hz": a_number, "background_counts": one_or_more}
    effects = enumerate(a_list(known.get("effects", []), "effects"))
    sources = known.get("sources", {})
    return SensorModel(
        name=a_text(known.get("name"), "name"),
        mode=a_text(known.get("mode", ""), "mode"),
        zone_grid=(a_whole_number(rows, "zone_grid[0]"), a_whole_number(columns, "zone_grid[1]")),
        bins=a_whole_number(known.get("bins"), "bins"),
        bin_width_s=width,
        time_zero_s=one_or_more(known.get("time_zero_s"), "time_zero_s"),
        pulse=_pulse(known.get("pulse"), width),
        effects=tuple(_setting(item, f"effects[{i}]") for i, item in effects),
        sources={
            n: a_text(v, f"sources.{n}") for n, v in an_object(sources, dict.fromkeys(sources), "sources").items()
        },
        **{name: reader(known[name], name) for name, reader in read.items() if name in known},
    )


def sensor_to_json(sensor: SensorModel) -> dict[str, Any]:
    """What `sensor_of` reads."""
    pulse = sensor.pulse
    if isinstance(pulse, PulseShape):
        tails = [{"tau_s": tail.tau_s, "share": tail.share} for tail in pulse.tails]
        shape = {"rise_s": pulse.rise_s, "fall_s": pulse.fall_s, "tails": tails}
    else:
        shape = {"time_s": pulse.time_s.tolist(), "probability": pulse.probability.tolist()}
    return {
        "format": FORMAT,
        "name": sensor.name,
        "mode": sensor.mode,
        "zone_grid": [int(n) for n in sensor.zone_grid],
        "bins": int(sensor.bins),
        "bin_width_s": float(sensor.bin_width_s),
        "time_zero_s": sensor.time_zero_s.tolist(),
        "pulse": shape,
        "laser_cycles": sensor.laser_cycles,
        "laser_hz": sensor.laser_hz,
        "background_counts": sensor.background_counts.tolist(),
        "effects": [_setting_to_json(setting) for setting in sensor.effects],
        "sources": sensor.sources,
    }


def _setting_to_json(setting: Setting) -> dict[str, Any]:
    return {
        "id": setting.effect.id,
        "parameters": [
            {"name": p.name, "value": np.asarray(setting.values[p.name]).tolist(), "unit": p.unit}
            for p in (*setting.effect.parameters, *(p for p in OF_EVERY if setting.values[p.name] != p.start))
        ],
    }


def _setting(said: Any, place: str) -> Setting:
    known = an_object(said, EFFECT, place)
    effect = find_effect(a_text(known["id"], f"{place}.id"))
    values = {}
    for j, item in enumerate(a_list(known.get("parameters", []), f"{place}.parameters")):
        there = f"{place}.parameters[{j}]"
        given = an_object(item, PARAMETER, there)
        parameter = effect.parameter(a_text(given["name"], f"{there}.name"))
        if given["unit"] != parameter.unit:
            raise Refusal(f"{there}: {parameter.name} has the unit {given['unit']!r}, expected {parameter.unit!r}")
        if parameter.name in values:
            raise Refusal(f"{there}: {parameter.name} is given twice, expected once")
        values[parameter.name] = one_or_more(given["value"], f"{there}.value")
    return effect.at(**values)


def _pulse(said: Any, bin_width_s: float) -> PulseShape | ImpulseResponse:
    if isinstance(said, dict) and "time_s" in said:
        known = an_object(said, SAMPLED, "pulse")
        times = numbers(known["time_s"], "pulse.time_s")
        probability = numbers(known["probability"], "pulse.probability", len(times))
        if (probability < 0).any():
            i = int(np.argmin(probability))
            raise Refusal(f"pulse.probability[{i}] is {probability[i]:g}, expected 0 or more")
        try:
            check_irf(times, probability, bin_width_s)
        except Refusal as wrong:
            # In a recording the two have other names.
            sentence = str(wrong).replace("irf_time_s", "pulse.time_s").replace("irf ", "pulse.probability ")
            raise Refusal(sentence) from None
        return ImpulseResponse(times, probability)
    known = an_object(said, SHAPE, "pulse")
    tails = [
        an_object(item, TAIL, f"pulse.tails[{i}]")
        for i, item in enumerate(a_list(known.get("tails", []), "pulse.tails"))
    ]
    return PulseShape(
        a_number(known["rise_s"], "pulse.rise_s"),
        a_number(known["fall_s"], "pulse.fall_s"),
        tuple(Tail(*(a_number(t[n], f"pulse.tails[{i}].{n}") for n in TAIL)) for i, t in enumerate(tails)),
    )
