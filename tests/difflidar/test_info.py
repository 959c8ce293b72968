import json

import numpy as np
import pytest

from difflidar.cli import main
from recordings.files import save
from recordings.recording import Recording


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture(params=["scan.rrd", "scan.npz"])
def scan(tmp_path, request):
    path = tmp_path / request.param
    counts = np.ones((31, 6, 16), np.uint32)
    meta = json.dumps({"sensor": "TMF8828", "mode": "[bold]3x3"})
    save(Recording(counts, [2, 3], 100e-12, 0.0, np.arange(31) / 30, patch_px=np.ones((31, 2)), meta_json=meta), path)
    return path


def test_a_recording_is_described(scan, capsys):
    assert run("info", scan) == 0
    said = capsys.readouterr().out
    for figure in ("TMF8828", "6 (2 x 3)", "100 ps, 14.99 mm", "31 in 1 s, 30 Hz", "31 x 6 x 16 uint32", "patch_px"):
        assert figure in said
    assert "[bold]3x3" in said


def test_as_json(scan, capsys):
    assert run("info", scan, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["kind"], said["frames"], said["zone_grid"]) == ("recording", 31, [2, 3])
    assert said["meta"]["sensor"] == "TMF8828"


def test_published_maps_say_that_they_are_true_in_the_image_plane_only(published_maps, capsys):
    path = published_maps / "spad_calib_3x3_longrange_bins15_35.npz"
    assert run("info", path, "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["kind"], said["positions"], said["image_plane_only"]) == ("response maps", 3600, True)
    assert run("info", path) == 0
    assert "in the image plane only" in capsys.readouterr().out


def test_what_is_no_recording_is_refused(tmp_path, capsys):
    (tmp_path / "a.npz").write_bytes(b"PK\x03\x04 no archive")
    assert run("info", tmp_path / "a.npz") == 2
    assert capsys.readouterr().err.count("\n") == 1
