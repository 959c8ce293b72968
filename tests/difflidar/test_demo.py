import re
import subprocess
import sys
from pathlib import Path

import pytest

from difflidar.cli import main
from recordings.files import load
from recordings.maps_file import load_maps


@pytest.mark.slow  # `make demo` runs, too, wherever all tests do
def test_leaves_what_it_promises(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["demo", "--out", str(tmp_path / "demo"), "--grid", "32x18"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert "Held against the truth" in said
    cause, named = re.search(r"in which (\w+) was concealed: `difflidar explain` named ([\w, ]+);", said).groups()
    assert named == cause
    assert (tmp_path / "demo" / "explained" / "report.html").read_text().startswith("<!")
    assert (tmp_path / "demo" / "overlay.png").read_bytes().startswith(b"\x89PNG")
    assert load_maps(tmp_path / "demo" / "maps.npz").zone_grid == (3, 3)
    scan, background = (load(tmp_path / "demo" / name) for name in ("scan.rrd", "scan-background.rrd"))
    assert 40 <= len(scan.counts) == len(background.counts) < 32 * 18 / 3
    rerun = Path(sys.executable).with_name("rerun")
    for name in ("session.rrd", "scan.rrd"):
        subprocess.run([rerun, "rrd", "verify", tmp_path / "demo" / name], check=True, capture_output=True)
