import os
import subprocess
import sys

import numpy as np
import pytest

from difflidar.cli import main
from recordings.files import load
from recordings.rrd.writer import RrdWriter


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture
def broken(tmp_path):
    """A recording of 20 frames in blocks of 5, cut off inside the third block."""
    path = tmp_path / "scan.rrd"
    with RrdWriter(path, {"zone_grid": [1, 1], "bin_width_s": 1e-10, "time_zero_s": 0.0}) as writer:
        sizes = []
        for i in range(20):
            writer.append({"counts": np.full((1, 64), i, np.uint32), "timestamp_s": float(i)})
            if i % 5 == 4:
                writer.flush()
                sizes.append(writer.partial.stat().st_size)
    path.write_bytes(path.read_bytes()[: sizes[2] - 10])
    return path


def test_what_is_whole_is_saved_and_what_is_lost_is_said(broken, tmp_path, capsys):
    assert run("repair", broken, tmp_path / "saved.rrd") == 0
    said = capsys.readouterr().out
    assert f"wrote {tmp_path / 'saved.rrd'}: 10 frames recovered" in said
    assert "lost: the last" in said
    assert np.array_equal(load(tmp_path / "saved.rrd").counts[:, 0, 0], np.arange(10))


def test_nothing_to_save_is_one_sentence_and_leaves_nothing(tmp_path):
    (tmp_path / "a.rrd").write_bytes(b"RRF2" + bytes(200))
    command = [sys.executable, "-m", "difflidar", "repair", tmp_path / "a.rrd", tmp_path / "b.rrd"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "nothing can be read of its 204 bytes" in done.stderr
    assert os.listdir(tmp_path) == ["a.rrd"]


def test_a_cut_file_tells_what_to_run(broken, capsys):
    assert run("info", broken) == 2
    assert "difflidar repair" in capsys.readouterr().err
