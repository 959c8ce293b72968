"""The command alone: what it calls is tested in its own room."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from difflidar.cli import main
from fusion.check import Check, ZoneAgreement
from physics.presets import preset
from recordings.refusal import Refusal

FOUND = Check(
    "shifted",
    "the maps are shifted by dx = +12 ± 2 px (right) and dy = +0 ± 2 px (down)",
    ("put right, the log-likelihood rises by 40",),
    (),
    (ZoneAgreement(0, 0.98, 0.0123, 0.02), ZoneAgreement(1, 0.5, None, None)),
    0.0123,
    (0, 3),
    (2.0, 2.0),
    0.3,
)


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture
def calls(monkeypatch):
    """What the command hands on; nothing is computed."""
    made = {}

    def check(recording, maps, sensor, rng):
        made.update(recording=recording, maps=maps, sensor=sensor, drawn=rng.integers(1000))
        return FOUND

    monkeypatch.setattr("fusion.check.check", check)
    monkeypatch.setattr("recordings.files.load", lambda path: path.name)
    monkeypatch.setattr("recordings.maps_file.load_maps", lambda path: SimpleNamespace(name=path.name))
    monkeypatch.setattr("physics.sensor_choice.choose_sensor", lambda name, path, maps: preset("tmf8828-3x3-wide-long"))
    return made


def test_a_verdict_in_words(calls, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    assert run("check", "scan.rrd", "--calibration", "m.npz", "--seed", "5") == 0
    said = capsys.readouterr().out
    assert said.startswith(f"scan.rrd: {FOUND.sentence}\n{FOUND.evidence[0]}\n")
    assert "2 frames, maps as they are" in said
    assert "0.980" in said
    assert "12" in said
    assert (calls["recording"], calls["maps"].name) == ("scan.rrd", "m.npz")
    assert calls["drawn"] == np.random.default_rng(5).integers(1000)


def test_json_and_nothing_else(calls, capsys):
    assert run("check", "scan.rrd", "--calibration", "m.npz", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found == json.loads(json.dumps(FOUND.as_dict()))
    assert found["verdict"] == "shifted"
    assert found["zones"][1] == {"zone": 1, "cosine": 0.5, "bias_m": None, "error_m": None}


def test_a_refusal_is_one_sentence(calls, capsys, monkeypatch):
    def refused(*given):
        raise Refusal("depth_m is missing")

    monkeypatch.setattr("fusion.check.check", refused)
    assert run("check", "scan.rrd", "--calibration", "m.npz") == 2
    assert capsys.readouterr().err == "difflidar: depth_m is missing\n"


def test_maps_are_needed(capsys):
    assert run("check", "scan.rrd") == 2
    assert "--calibration" in capsys.readouterr().err
