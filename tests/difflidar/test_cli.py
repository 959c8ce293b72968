import json
import subprocess
import sys

import numpy as np
import pytest

from calibrate.space import ScanGeometry
from difflidar.cli import main
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps, save_maps


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


def refused(capsys, *arguments):
    """The one sentence of a refusal."""
    assert run(*arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("difflidar: ")
    assert said.err.count("\n") == 1
    assert "Traceback" not in said.err
    return said.err


@pytest.fixture
def maps(tmp_path):
    rng = np.random.default_rng(0)
    x, y = (g.ravel() for g in np.meshgrid(np.arange(100.0, 700, 20), np.arange(60.0, 420, 20)))
    values = 1e4 * np.stack([np.exp(-(((x - a) / 80) ** 2) - ((y - 240) / 80) ** 2) for a in (300, 500)])
    values += rng.random(values.shape)
    intrinsics = np.array([[612.0, 0, 424], [0, 612, 240], [0, 0, 1]])
    meta = ScanGeometry(intrinsics, np.eye(4), 0.6).to_meta() | {"patch_radius_px": 18.0, "frame": "lidar"}
    ids = np.array([f"{i:04d}" for i in range(len(x))])
    path = tmp_path / "maps.npz"
    save_maps(ResponseMaps(values[None].astype(np.float32), x, y, ids, json.dumps(meta)), path)
    return path


def test_published_figures_at_the_command_line(published_maps, capsys):
    names = "spad_calib_3x3_longrange_bins15_35.npz", "spad_calib_3x3_shortrange_bins45_75.npz"
    assert run("compare", *(published_maps / name for name in names), "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert {name: round(value, 3) for name, value in found["mean"].items()} == {
        "iou": 0.915,
        "displacement_px": 2.942,
        "cosine": 0.984,
    }
    assert len(found["iou_over_thresholds"]["threshold"]) == 19


def test_compare_and_its_picture(maps, tmp_path, capsys):
    assert run("compare", maps, maps, "--picture", tmp_path / "curve.png") == 0
    assert "1.000 ± 0.000" in capsys.readouterr().out
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_sparse(maps, tmp_path, capsys):
    assert run("sparse", maps, "--points", 100, "--points", 50, "--picture", tmp_path / "sparse.png") == 0
    assert "50" in capsys.readouterr().out
    assert (tmp_path / "sparse.png").exists()


def test_move(maps, tmp_path, capsys):
    assert run("move", maps, 1.2, "--out", tmp_path / "far.npz") == 0
    near, far = load_maps(maps), load_maps(tmp_path / "far.npz")
    assert far.meta["calibration_range_m"] == 1.2
    np.testing.assert_allclose(far.xs, near.xs, atol=1e-3)  # no baseline, no parallax
    assert (far.responses < near.responses).all()


@pytest.mark.parametrize("more", [[], ["--deconvolved"]])
def test_grid(maps, tmp_path, capsys, more):
    assert run("grid", maps, "--out", tmp_path / "grid.npz", "--step", 8, *more) == 0
    with np.load(tmp_path / "grid.npz") as grid:
        assert grid["response"].shape == grid["sigma"].shape == grid["support"].shape == (1, 2, 60, 106)
        # The bells of the fixture: exp(−r²/80²) reaches a tenth within r² = 80² ln 10.
        area = np.pi * 80**2 * np.log(10) / 64
        assert grid["support"].sum(axis=(2, 3))[0] == pytest.approx([area, area], rel=0.12)
        row, column = np.unravel_index(np.nanargmax(grid["response"][0, 0]), (60, 106))
        assert (column * 8 + 3.5, row * 8 + 3.5) == pytest.approx((300, 240), abs=8)
        assert (grid["sigma"][grid["support"]] > 0).all()


def test_rays(maps, tmp_path, capsys):
    assert run("rays", maps, "--out", tmp_path / "rays.npz") == 0
    there = load_maps(maps)
    with np.load(tmp_path / "rays.npz") as rays:
        expected = np.stack([(there.xs - 424) / 612, (there.ys - 240) / 612, np.ones(len(there.xs))], axis=1)
        expected /= np.linalg.norm(expected, axis=1, keepdims=True)
        np.testing.assert_allclose(rays["directions"], expected, atol=1e-6)
        assert rays["weights"].shape == there.responses.shape


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["compare", "nothing.npz", "nothing.npz"], "nothing.npz"),
        (["compare", "MAPS", "MAPS", "--threshold", "2"], "threshold"),
        (["sparse", "MAPS", "--points", "100000"], "points"),
        (["move", "MAPS", "-1", "--out", "x.npz"], ""),
        (["move", "MAPS", "0", "--out", "x.npz"], "distance"),
        (["baseline", "MAPS", "MAPS", "--distances", "0.5,0.5", "--intrinsics", "612,612,424,240"], "distances"),
        (["baseline", "MAPS", "MAPS", "--distances", "0.5,1", "--intrinsics", "0,0,0,0"], "focal lengths"),
        (["sparse", "MAPS", "--patch-radius", "-3"], "patch radius"),
        (["grid", "MAPS", "--out", "x.npz", "--step", "0"], "step"),
        (["grid", "MAPS", "--out", "x.npz", "--threshold", "0"], "threshold"),
        (["rays", "MAPS", "--out", "nowhere/x.npz"], "folder"),
        (["sparse", "MAPS", "--patch-radius", "nan"], "patch radius"),
        (["calibrate", "MAPS", "--out", "x.npz", "--threshold", "7"], "threshold"),
        (["baseline", "MAPS", "MAPS", "--distances", "0.5", "--intrinsics", "612,612,424,240"], "expected 2 numbers"),
        (["calibrate", "MAPS", "--out", "nowhere/x.npz"], "folder"),
        (["calibrate", "MAPS", "--out", "x.npz", "--window", "fifteen"], "window"),
        (["calibrate", "MAPS"], "--out"),
        (["calibrated"], "calibrated"),
        (["demo", "--grid", "0x3"], "columns"),
        (["demo", "--grid", "9x9"], "81 positions"),
        (["scan", "p.json", "--rig", "r.json", "--out", "s.npz"], "expected a name that ends in .rrd"),
        (["scan", "p.json", "--rig", "r.json", "--out", "s.rrd"], "p.json: no such file"),
        (["rehearse", "r", "--host", "8.8.8.8"], "expected a loopback address"),
        (["rehearse", "r", "--host", "robot"], "expected a loopback address"),
        (["rehearse", "r", "--grid", "0x3"], "columns"),
        (["rehearse", "r", "--lose", "2"], "expected a share from 0 to below 1"),
        (["rehearse", "r", "--speed", "0"], "--speed: 0.0 found, expected a number above 0"),
        (["doctor", "r.json"], "r.json: no such file"),
        (["doctor"], "rig.json: no such file"),
        (["live", "--calibration", "MAPS"], "rig.json: no such file"),
        (["record", "--out", "s.rrd"], "rig.json: no such file"),
        (["live", "--rig", "r", "--calibration", "MAPS", "--save", "a.rrd", "--connect", "x"], "--save and --connect"),
        (["live", "--rig", "r.json", "--calibration", "MAPS"], "r.json: no such file"),
        (["live", "--rig", "r.json", "--calibration", "MAPS", "--method", "magic"], "method"),
        (["mount", "r.json", "--out", "parts"], "r.json: no such file"),
    ],
)
def test_refusals_are_one_sentence(maps, tmp_path, monkeypatch, capsys, arguments, says):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.iterdir())
    assert says in refused(capsys, *(maps if a == "MAPS" else a for a in arguments))
    assert sorted(tmp_path.iterdir()) == before


def test_as_a_process_of_its_own():
    found = subprocess.run([sys.executable, "-m", "difflidar", "compare", "a", "b"], capture_output=True, text=True)
    assert found.returncode == 2
    assert found.stderr.count("\n") == 1
    assert found.stdout == ""


def test_help_names_every_command(capsys):
    assert run("--help") == 0
    said = capsys.readouterr().out
    for name in (
        "baseline",
        "calibrate",
        "compare",
        "convert",
        "demo",
        "doctor",
        "grid",
        "info",
        "live",
        "mount",
        "move",
        "rays",
        "record",
        "rehearse",
        "repair",
        "scan",
        "sparse",
    ):
        assert name in said
