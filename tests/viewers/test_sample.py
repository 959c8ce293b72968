import subprocess
import sys
from pathlib import Path

from rerun.chunk import RrdReader

SAMPLE = Path(__file__).parents[2] / "recordings" / "samples" / "room.rrd"
MOST_BYTES = 3_000_000


def test_the_sample_is_small_sound_and_opens_laid_out():
    assert SAMPLE.stat().st_size < MOST_BYTES
    rerun = Path(sys.executable).with_name("rerun")
    subprocess.run([rerun, "rrd", "verify", SAMPLE], check=True, capture_output=True)
    reader = RrdReader(SAMPLE)
    assert reader.blueprints()
    there = {chunk.entity_path for chunk in reader.stream()}
    assert {"/world/cloud", "/world/rig/camera/rgb", "/fused/depth", "/fused/sigma", "/residual", "/about"} <= there
    assert {f"/lidar/zone/{row}_{column}" for row in range(3) for column in range(3)} <= there
