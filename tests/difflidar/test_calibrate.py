from dataclasses import replace

import numpy as np
import pytest

from calibrate.plan import ScanPlan
from calibrate.simulated_scan import simulate_scan
from difflidar.cli import main
from difflidar.commands.calibrate import command
from recordings.files import load, save
from recordings.maps_file import load_maps
from recordings.refusal import Refusal


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


def test_a_rig_file_puts_the_maps_into_space(folder, tmp_path):
    """A rotation about z by 90 degrees: the camera's x is the LiDAR's −y, its y the LiDAR's x."""
    rig, maps = tmp_path / "rig.json", tmp_path / "maps.npz"
    rig.write_text(
        '{"lidar_position_m": [0.1, 0.2, 0.3], "lidar_rotation_deg": [0, 0, 90], "patch_distance_m": 0.75}',
    )
    assert run("calibrate", folder / "scan.rrd", "--rig", rig, "--out", maps) == 0
    meta = load_maps(maps).meta
    there = [[0, 1, 0, -0.2], [-1, 0, 0, 0.1], [0, 0, 1, -0.3], [0, 0, 0, 1]]
    assert np.allclose(meta["lidar_from_camera"], there)
    assert (meta["frame"], meta["calibration_range_m"]) == ("lidar", 0.75)


def test_options_win_over_the_rig_file(folder, tmp_path, monkeypatch):
    def stop(recording, background, **asked):
        raise Refusal(f"{asked['baseline_m']} {asked['patch_depth_m']}")

    monkeypatch.setattr("calibrate.calibration.calibrate", stop)
    rig = tmp_path / "rig.json"
    rig.write_text('{"lidar_position_m": [0.1, 0.2, 0.3], "patch_distance_m": 0.75}')
    options = "--baseline", "0.01,0.02,0.03", "--patch-distance", "0.5"
    with pytest.raises(Refusal, match=r"\(0.01, 0.02, 0.03\) 0.5"):
        command.main(
            [str(folder / "scan.rrd"), "--rig", str(rig), "--out", str(tmp_path / "maps.npz"), *options],
            standalone_mode=False,
        )


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
        (["scan.rrd", "--rig", "gone.json"], "gone.json"),
    ],
)
def test_refusals_leave_nothing(folder, tmp_path, capsys, arguments, says):
    paths = [folder / a if a.endswith((".rrd", ".npz", ".json")) else a for a in arguments]
    assert run("calibrate", *paths, "--out", tmp_path / "maps.npz") == 2
    said = capsys.readouterr()
    assert says in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""
    assert list(tmp_path.iterdir()) == []
