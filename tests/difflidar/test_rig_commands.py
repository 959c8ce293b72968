"""`doctor`, `record`, `live` and `scan` on a rehearsed rig, as a user types them."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from calibrate.rig import load_rig
from devices.rehearsal.rehearsal import Rehearsal
from difflidar.cli import main
from difflidar.demo_rehearsed import free_host
from recordings.files import load
from recordings.maps import ResponseMaps
from recordings.maps_file import save_maps
from viewers.live_scan import LiveScan


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """Folder with rig.json and plan.json of devices that are served."""
    folder = tmp_path_factory.mktemp("rig")
    rng = np.random.default_rng(0)
    with Rehearsal(folder, 5, 4, rng=rng, speed=1.0, host=free_host(), settle_s=0.0):
        yield folder


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    """Each zone sees a box of the image."""
    ys, xs = (a.ravel() for a in np.mgrid[0:480:20, 0:848:20].astype(np.float32))
    zone = np.minimum(ys // 160, 2) * 3 + np.minimum(xs // 283, 2)
    responses = (zone == np.arange(9)[:, None]).astype(np.float32).reshape(3, 3, -1)
    path = tmp_path_factory.mktemp("maps") / "maps.npz"
    save_maps(ResponseMaps(responses, xs, ys, np.array([f"{i:04d}" for i in range(len(xs))])), path)
    return path


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    return ended.value.code


def test_doctor_finds_a_rehearsed_rig_ready_and_says_what_it_measured(rig, capsys):
    assert run("doctor", rig / "rig.json", "--plan", rig / "plan.json", "--out", rig) == 0
    said = capsys.readouterr().out
    assert "wrong" not in said
    for words in (
        "LiDAR: ams Arduino driver",
        "LiDAR's lines: 0 of",
        "848 x 480",
        "LiDAR's clock: off by",
        "clocks together",
        "all 20 positions",
        "room on the disk",
        "The rig is ready.",
    ):
        assert words in said


def test_doctor_says_what_is_missing_and_what_to_do(rig, tmp_path, capsys):
    text = (rig / "rig.json").read_text()
    (tmp_path / "rig.json").write_text(text.replace(str(load_rig(rig / "rig.json").lidar.port), "/dev/nowhere"))
    assert run("doctor", tmp_path / "rig.json", "--out", tmp_path) == 2
    said = capsys.readouterr()
    assert "/dev/nowhere is not there" in " ".join(said.out.replace("\n", " ").split())
    assert "checks failed, see above for what to do about each" in said.err


def test_a_scan_takes_the_rig_file_beside_its_plan(rig, tmp_path, capsys):
    plan = tmp_path / "plan.json"
    plan.write_bytes((rig / "plan.json").read_bytes())
    assert run("scan", plan, "--out", tmp_path / "s.rrd") == 2
    assert f"{tmp_path / 'rig.json'}: no such file" in " ".join(capsys.readouterr().err.split())


def test_what_is_recorded_is_a_recording_of_the_rig(rig, tmp_path, capsys):
    assert run("record", "--rig", rig / "rig.json", "--out", tmp_path / "seen.rrd", "--frames", "3") == 0
    assert "3 frames" in capsys.readouterr().out
    seen = load(tmp_path / "seen.rrd")
    setup = load_rig(rig / "rig.json")
    assert seen.counts.shape == (3, 9, 128)
    assert seen.rgb.shape == (3, 480, 848, 3)
    np.testing.assert_allclose(seen.lidar_from_camera, setup.lidar_from_camera)
    assert seen.laser_cycles == 1024 * 10_000
    assert seen.meta["lidar"]["mode"] == "3x3"


def test_live_writes_a_session_that_opens(rig, maps, tmp_path):
    out = tmp_path / "live.rrd"
    arguments = ["--calibration", maps, "--save", out, "--frames", "3"]
    assert run("live", "--rig", rig / "rig.json", *arguments) == 0
    rerun = Path(sys.executable).with_name("rerun")
    subprocess.run([rerun, "rrd", "verify", out], check=True, capture_output=True)


def test_a_scan_that_is_watched_grows_its_maps(tmp_path):
    import rerun as rr

    session = rr.RecordingStream("difflidar")
    session.save(str(tmp_path / "scan.rrd"))
    view, rng = LiveScan(session, (3, 3)), np.random.default_rng(0)
    for i in range(12):
        counts = rng.poisson(20, (9, 128)).astype(np.uint32)
        counts[i % 9, 30] += 5000
        rgb = np.zeros((48, 84, 3), np.uint8) if i % 2 else None
        view.push(counts, rgb, (10.0 * i, 20.0, 5.0) if i != 3 else None, "patch")
    session.flush()
    session.disconnect()
    program = Path(sys.executable).with_name("rerun")
    subprocess.run([program, "rrd", "verify", tmp_path / "scan.rrd"], check=True, capture_output=True)
    listed = subprocess.run(
        [program, "rrd", "print", tmp_path / "scan.rrd"], check=True, capture_output=True, text=True
    )
    assert "/maps/0_0" in listed.stdout
