import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from calibrate.calibration import calibrate
from calibrate.grid import map_images
from calibrate.plan import ScanPlan
from calibrate.simulated_scan import simulate_scan
from viewers.scan_session import save_scan_session


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    simulated = simulate_scan(ScanPlan(28, 16), rng=np.random.default_rng(0))
    scan = simulated.patch.collect()
    result = calibrate(scan, simulated.background.collect())
    path = tmp_path_factory.mktemp("session") / "session.rrd"
    save_scan_session(path, scan, result, map_images(result.kernel, result.maps), ["One sentence."])
    return path, scan, result


def test_is_a_sound_file_with_a_blueprint(session):
    rerun = Path(sys.executable).with_name("rerun")
    subprocess.run([rerun, "rrd", "verify", session[0]], check=True, capture_output=True)
    assert RrdReader(session[0]).blueprints()
    assert [p.name for p in session[0].parent.iterdir()] == ["session.rrd"]


def test_holds_what_the_layout_shows(session):
    rows = {}
    for chunk in RrdReader(session[0]).stream():
        rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + chunk.to_record_batch().num_rows
    positions = len(session[2].maps.xs)
    assert rows["/camera/scanned"] == positions
    assert rows["/camera/rgb"] == min(len(session[1].rgb), 360)
    for zone in ("0_0", "1_1", "2_2"):
        assert rows[f"/response/{zone}"] == positions + 1
        assert rows[f"/maps/{zone}"] == 1
        assert rows[f"/camera/maps/{zone}"] == 1
        assert rows[f"/lidar/zone/{zone}"] == rows["/camera/rgb"]
    assert "/summary" in rows
