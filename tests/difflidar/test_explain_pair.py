"""The command on two calibrations: what it writes, all of it or nothing. What it calls is tested in its own room."""

import json
import os
from types import SimpleNamespace

import numpy as np
import pytest

from difflidar.cli import main
from mismatch.calibrations.verdict import Figures
from mismatch.verdict import Estimate, Named
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps, save_maps
from recordings.refusal import Refusal

FIGURES = Figures(1.25, 0.0125, (0.1,), (0.9,))
BLUR = Named("footprint_blur", "Blurred.", (Estimate("variance", 15.0, 1.0, "px²"),), 9.0, 1e-9, 9.0)


def maps(level):
    x, y = (g.ravel() for g in np.meshgrid(np.arange(3.0), np.arange(3.0)))
    return ResponseMaps(np.full((1, 2, 9), level, np.float32), x, y, np.arange(9).astype(str))


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture
def pair(tmp_path, monkeypatch):
    """Two files, and a verdict on them that nothing was computed for."""
    files = tmp_path / "long.npz", tmp_path / "short.npz"
    for path, level in zip(files, (1.0, 2.0), strict=True):
        save_maps(maps(level), path)

    def explain_calibrations(a, b):
        return SimpleNamespace(
            a=a, b=b, verdict="explained", effects=(BLUR,), multiples=(0.9,), positions=(20, 18), before=FIGURES,
            after=FIGURES, floor=FIGURES, unexplained=(), notes=("A [note].",),
            text=lambda: json.dumps({"verdict": "explained"}) + "\n",
        )  # fmt: skip

    monkeypatch.setattr("mismatch.calibrations.explain.explain_calibrations", explain_calibrations)
    return files


def test_a_folder_receives_the_verdict_and_both_maps(pair, tmp_path, capsys):
    out = tmp_path / "new" / "out"
    assert run("explain", *pair, "--out", out) == 0
    said = capsys.readouterr().out
    assert "footprint_blur: variance 15 ± 1 px²" in said
    assert "A [note]." in said
    assert set(os.listdir(out)) == {"a.npz", "b.npz", "verdict.json"}
    assert json.loads((out / "verdict.json").read_text()) == {"verdict": "explained"}
    np.testing.assert_array_equal(load_maps(out / "a.npz").responses, maps(1.0).responses)
    np.testing.assert_array_equal(load_maps(out / "b.npz").responses, maps(2.0).responses)


def test_as_json_and_nothing_else(pair, capsys):
    assert run("explain", *pair, "--json") == 0
    assert json.loads(capsys.readouterr().out) == {"verdict": "explained"}


@pytest.mark.parametrize("there", [False, True])
def test_all_or_nothing(pair, tmp_path, capsys, monkeypatch, there):
    def fails(found, path):
        path.write_bytes(b"half")
        if found.responses[0, 0, 0] == 2:
            raise Refusal("maps: no room")

    monkeypatch.setattr("recordings.maps_file.save_maps", fails)
    out = tmp_path / "new" / "out"
    if there:
        out.mkdir(parents=True)
        (out / "a.npz").write_text("old")
    assert run("explain", *pair, "--out", out) == 2
    assert capsys.readouterr().err == "difflidar: maps: no room\n"
    if there:
        assert [(p.name, p.read_text()) for p in out.iterdir()] == [("a.npz", "old")]
    else:
        assert not (tmp_path / "new").exists()


def test_a_place_that_is_taken_is_refused_early(pair, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("mismatch.calibrations.explain.explain_calibrations", None)
    (tmp_path / "out" / "b.npz").mkdir(parents=True)
    assert run("explain", *pair, "--out", tmp_path / "out") == 2
    assert "b.npz: is a folder" in capsys.readouterr().err
    assert os.listdir(tmp_path / "out") == ["b.npz"]
