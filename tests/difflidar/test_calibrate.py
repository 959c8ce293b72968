from dataclasses import replace

import numpy as np
import pytest

from calibrate.plan import ScanPlan
from calibrate.simulated_scan import simulate_scan
from difflidar.cli import main
from recordings.files import load, save
from recordings.maps_file import load_maps


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scan")
    scan = simulate_scan(ScanPlan(28, 16), rng=np.random.default_rng(0))
    save(scan.patch, folder / "scan.rrd")
    background = scan.background.collect()
    save(background, folder / "background.npz")
    save(
        replace(background, counts=background.counts[:-1], timestamp_s=background.timestamp_s[:-1], meta_json="{}"),
        folder / "short.npz",
    )
    save(replace(background, counts=0 * background.counts), folder / "dark.npz")
    blind = load(folder / "scan.rrd")
    save(replace(blind, rgb=np.zeros((480, 848, 3), np.uint8)), folder / "blind.npz")
    return folder


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


def test_scan_and_background_become_maps_and_a_picture(folder, tmp_path, capsys):
    maps, picture = tmp_path / "maps.npz", tmp_path / "overlay.png"
    files = folder / "scan.rrd", "--background", folder / "background.npz"
    assert run("calibrate", *files, "--out", maps, "--picture", picture) == 0
    assert "Patch seen at 448 positions" in capsys.readouterr().out
    found = load_maps(maps)
    assert found.responses.shape == (3, 3, 448)
    assert found.meta["background_subtracted"]
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["maps.npz", "overlay.png"]


def test_a_window_of_the_users_own(folder, tmp_path):
    maps = tmp_path / "maps.npz"
    assert run("calibrate", folder / "scan.rrd", "--out", maps, "--window", "20:33", "--grid", "28x16") == 0
    meta = load_maps(maps).meta
    assert (meta["bin_min"], meta["bin_max"], meta["window_chosen_by"]) == (20, 33, "user")
    assert not meta["background_subtracted"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["scan.rrd", "--background", "short.npz"], "same captures"),
        (["dark.npz"], "all are 0"),
        (["background.npz"], "neither rgb"),
        (["blind.npz"], "one picture"),
        (["scan.rrd", "--window", "120:130"], "window"),
        (["scan.rrd", "--grid", "80x45"], "3600 frames"),
        (["scan.rrd", "--grid", "80 by 45"], "80x45"),
        (["gone.rrd"], "gone.rrd"),
    ],
)
def test_refusals_leave_nothing(folder, tmp_path, capsys, arguments, says):
    paths = [folder / a if a.endswith((".rrd", ".npz")) else a for a in arguments]
    assert run("calibrate", *paths, "--out", tmp_path / "maps.npz") == 2
    said = capsys.readouterr()
    assert says in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""
    assert list(tmp_path.iterdir()) == []
