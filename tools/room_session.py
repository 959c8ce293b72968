"""Makes recordings/samples/room.rrd again: a simulated rig calibrates itself, looks round a room, and fuses it.

    .venv/bin/python tools/room_session.py recordings/samples/room.rrd [--still docs/session.png]

Nothing in it is recorded by a real sensor. A still needs Debian's xvfb, libvulkan1 and mesa-vulkan-drivers.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

from calibrate.calibration import calibrate
from calibrate.plan import ScanPlan
from calibrate.simulated_scan import simulate_scan
from difflidar.demo_fused import see_room
from difflidar.view_recording import open_recording
from fusion.fuse import METHODS
from recordings.files import save
from recordings.maps_file import save_maps
from viewers.fusion_session import saved_session

SEED, PLAN = 0, ScanPlan(40, 22)
POINTS = 6000  # of a cloud, so that the file stays small
WINDOW, SCREEN = (1500, 900), "4000x2400x24"
VULKAN = "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json"


def make(out: Path, folder: Path) -> None:
    """Scan, calibrate, simulate the room with the parallax that the mount has, fuse, and write the session."""
    rng = np.random.default_rng(SEED)
    scan = simulate_scan(PLAN, rng=rng)
    maps = calibrate(scan.patch.collect(), scan.background.collect()).maps
    save_maps(maps, folder / "maps.npz")
    save(see_room(maps, rng), folder / "room.npz")
    rig, frames, _ = open_recording(folder / "room.npz", folder / "maps.npz", None, METHODS[-1])
    with saved_session(out, rig, most_points=POINTS) as push:
        for frame in frames:
            push(frame)


def still(session: Path, out: Path) -> None:
    """A picture of how the session opens, without a display."""
    large = out.with_suffix(".large.png")
    viewer = Path(sys.executable).with_name("rerun")
    size = "x".join(str(n) for n in WINDOW)
    # The pointer rests in the middle of the screen, where there is no window.
    command = ["xvfb-run", "-a", "-s", f"-screen 0 {SCREEN}", viewer, session, "--port", "auto"]
    options = ["--screenshot-to", large, "--window-size", size]
    subprocess.run([*command, *options], check=True, env={**os.environ, "VK_ICD_FILENAMES": VULKAN})
    try:
        picture = cv2.resize(cv2.imread(str(large)), WINDOW, interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(out), picture, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    finally:
        large.unlink()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--still", type=Path, metavar="PNG")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        make(given.out, Path(folder))
    if given.still is not None:
        still(given.out, given.still)
