"""The command alone: what it calls is tested in its own rooms."""

import json
import os
from types import SimpleNamespace

import numpy as np
import pytest

from difflidar.cli import main
from mismatch.places import Place
from mismatch.verdict import Alternative, Deviance, Estimate, Named, NotVisible, Verdict
from physics.presets import preset
from physics.sensor_file import load_sensor
from recordings.refusal import Refusal

FILES = {"verdict.json", "report.html", "residuals.rrd", "sensor.json"}
PLACE = Place((1,), (3, 9), (0, 7), "range", 1.0, 1e-9, 50.0, "zone 1, bins 3 to 9, going with range")
DELAYS = tuple(Estimate(f"delay[{p}]", 1e-11 * p, 2e-12, "s") for p in range(9))
NAMED = Named(
    "time_zero_offset", "All is late.", DELAYS, 90.0, 1e-9, 95.0, (Alternative("range_walk", 0.1, "Less light."),)
)
VERDICT = Verdict(
    "unknown", (PLACE,), (NAMED,), Deviance(2.0, 1.2, 1.0), Deviance(2.1, 1.25, 1.0), 0.77, (PLACE,),
    (NotVisible("parallax", float("inf"), "m"),), "Move [bold]closer[/bold].", 1.5, ("Assumed.",),
)  # fmt: skip


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture
def calls(monkeypatch):
    """What the command hands on; nothing is computed."""
    made = {}

    def open_simulation(path, maps, sensor, *, mesh=None, zones=None):
        made["opened"] = [None if p is None else p.name for p in (path, maps, sensor, mesh, zones)]
        return "simulation", preset("tmf8828-3x3-wide-long"), ("Assumed.",)

    def explain(simulation, notes):
        made["explained"] = simulation, notes
        return SimpleNamespace(verdict=VERDICT)

    monkeypatch.setattr("mismatch.open_simulation.open_simulation", open_simulation)
    monkeypatch.setattr("mismatch.explain.explain", explain)
    monkeypatch.setattr("mismatch.improved.improved_sensor", lambda sensor, found: sensor)
    monkeypatch.setattr("viewers.explain_report.write_report", lambda found, path, name: path.write_text(name))
    monkeypatch.setattr("viewers.residual_session.write_residuals", lambda found, path: path.write_text("rrd"))
    return made


def test_a_summary(calls, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    files = ("--calibration", "m.npz", "--sensor", "s.json", "--mesh", "a.stl", "--zones", "z.json")
    assert run("explain", "scan.rrd", *files) == 0
    said = capsys.readouterr()
    assert said.err == ""
    for words in ("no known effect explains", "time zero offset", "20.0 ± 2.0 ps", "and 5 more", "range walk (0.1)"):
        assert words in said.out
    assert "left: zone 1, bins 3 to 9, going with range" in said.out
    assert "Move [bold]closer[/bold]." in said.out
    assert calls["opened"] == ["scan.rrd", "m.npz", "s.json", "a.stl", "z.json"]
    assert calls["explained"] == ("simulation", ("Assumed.",))


def test_as_json_and_nothing_else(calls, capsys):
    assert run("explain", "scan.rrd", "--json") == 0
    said = capsys.readouterr()
    assert said.out == VERDICT.text()
    assert said.err == ""
    assert json.loads(said.out)["not_visible"][0]["smallest_visible"] is None
    assert calls["opened"] == ["scan.rrd", None, None, None, None]


def test_a_folder_receives_everything(calls, tmp_path, capsys):
    out = tmp_path / "new" / "verdict"
    assert run("explain", "scan.rrd", "--out", out, "--json") == 0
    assert capsys.readouterr().out == VERDICT.text()
    assert set(os.listdir(out)) == FILES
    assert (out / "verdict.json").read_text() == VERDICT.text()
    assert (out / "report.html").read_text() == "scan.rrd"
    assert np.array_equal(load_sensor(out / "sensor.json").zone_grid, (3, 3))
    assert run("explain", "scan.rrd", "--out", out) == 0
    assert str(out / "report.html") in capsys.readouterr().out
    assert set(os.listdir(out)) == FILES


@pytest.mark.parametrize("there", [False, True])
def test_all_or_nothing(calls, tmp_path, capsys, monkeypatch, there):
    def fails(found, path):
        path.write_text("half")
        raise Refusal("residuals: no room")

    monkeypatch.setattr("viewers.residual_session.write_residuals", fails)
    out = tmp_path / "new" / "verdict"
    if there:
        out.mkdir(parents=True)
        (out / "report.html").write_text("old")
    assert run("explain", "scan.rrd", "--out", out) == 2
    assert capsys.readouterr().err == "difflidar: residuals: no room\n"
    if there:
        assert [(p.name, p.read_text()) for p in out.iterdir()] == [("report.html", "old")]
    else:
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("out", "sentence"), [("file", "is a file"), ("file/below", "is a file"), ("full", "is a folder")]
)
def test_a_place_that_cannot_be_written_is_refused_early(calls, tmp_path, capsys, out, sentence):
    (tmp_path / "file").write_text("")
    (tmp_path / "full" / "sensor.json").mkdir(parents=True)
    assert run("explain", "scan.rrd", "--out", tmp_path / out) == 2
    said = capsys.readouterr()
    assert (said.out, said.err.count("\n")) == ("", 1)
    assert sentence in said.err
    assert calls == {}


def test_what_is_no_recording_is_refused(tmp_path, capsys):
    (tmp_path / "a.npz").write_bytes(b"PK\x03\x04 no archive")
    assert run("explain", tmp_path / "a.npz") == 2
    said = capsys.readouterr()
    assert (said.out, said.err.count("\n")) == ("", 1)
