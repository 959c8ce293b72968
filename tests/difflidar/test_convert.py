import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

from difflidar.cli import main
from recordings.files import load, save
from recordings.maps_file import load_maps
from recordings.recording import Recording


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture
def scan(tmp_path):
    rng = np.random.default_rng(0)
    path = tmp_path / "scan.npz"
    rgb = rng.integers(0, 256, (40, 48, 64, 3), dtype=np.uint8)
    counts = rng.poisson(9, (40, 4, 16)).astype(np.uint32)
    save(Recording(counts, [2, 2], 1e-10, 0.0, np.arange(40) / 30, rgb=rgb, meta_json='{"sensor": "TMF8828"}'), path)
    return path


def test_there_and_back_is_the_same(scan, tmp_path, capsys):
    assert run("convert", scan, tmp_path / "a.rrd") == 0
    assert run("convert", tmp_path / "a.rrd", tmp_path / "b.npz") == 0
    assert capsys.readouterr().out == f"wrote {tmp_path / 'a.rrd'}\nwrote {tmp_path / 'b.npz'}\n"
    with np.load(scan) as first, np.load(tmp_path / "b.npz") as last:
        assert set(first) == set(last)
        for name in first:
            assert (first[name].dtype, first[name].tobytes()) == (last[name].dtype, last[name].tobytes())


def test_published_data_and_their_maps(shared_data, tmp_path, capsys):
    assert run("convert", shared_data / "tmf8820_plane_sweep" / "distance_data.json", tmp_path / "sweep.rrd") == 0
    assert "sweep.maps.npz" in capsys.readouterr().out
    assert load(tmp_path / "sweep.rrd").counts.shape == (159, 9, 128)
    assert load_maps(tmp_path / "sweep.maps.npz").zone_grid == (3, 3)


REFUSED = {
    "nothing there": (lambda p: None, "no such file"),
    "noise": (lambda p: p.write_bytes(bytes(range(256))), "is no .npz file"),
    "a cut archive": (lambda p: p.write_bytes(p.with_name("scan.npz").read_bytes()[:500]), "damaged .npz"),
    "a pickle": (lambda p: p.write_bytes(pickle.dumps([1])), "is no .npz file"),
    "objects": (lambda p: np.savez(p, counts=np.array([{}], object)), "Python objects"),
    "a missing array": (lambda p: np.savez(p, counts=np.ones((1, 1, 1), "u4")), "zone_grid is missing"),
    "a folder": (lambda p: p.mkdir(), "neither .rrd nor .npz"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_refusal_is_one_sentence_and_leaves_nothing(scan, tmp_path, case):
    """In a process of its own, so that what a library prints by itself is seen too."""
    spoil, sentence = REFUSED[case]
    spoil(tmp_path / "bad.npz")
    before = set(os.listdir(tmp_path))
    command = [sys.executable, "-m", "difflidar", "convert", tmp_path / "bad.npz", tmp_path / "out.rrd"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("difflidar: ")
    assert sentence in done.stderr
    assert set(os.listdir(tmp_path)) == before


FULL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), int(sys.argv[1])))
from difflidar.cli import main
main(sys.argv[2:])
"""


@pytest.mark.parametrize("name", ["out.rrd", "out.npz"])
@pytest.mark.parametrize("room", [100, 60_000])
def test_a_full_disk_is_one_sentence_and_leaves_nothing(scan, tmp_path, name, room):
    command = [sys.executable, "-c", FULL, str(room), "convert", scan, tmp_path / name]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith(f"difflidar: {tmp_path / name}: ")
    assert os.listdir(tmp_path) == ["scan.npz"]


@pytest.mark.parametrize("out", ["no/folder/a.rrd", "a.mp4", "scan.npz/a.rrd"])
def test_a_place_that_cannot_be_written_is_refused(scan, tmp_path, capsys, out):
    assert run("convert", scan, tmp_path / out) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert os.listdir(tmp_path) == ["scan.npz"]
