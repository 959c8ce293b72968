"""A rehearsed scan in which everything goes wrong: does it end, are its maps right, what does it cost?

    python bench/rehearsal.py [--grid 80x45] [--speed 50] [--calm]

Serial unplugged twice, 1 % of lines lost, two protective stops, the process killed three times, a full disk once: the
real drivers talk to emulated devices, and the maps are held against the truth of the simulated bench. `--calm` leaves
all that out, to measure what a scan costs beyond motion and integration.
"""

import argparse
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from calibrate.calibration import calibrate
from calibrate.consistency import cosines
from calibrate.rig import LidarSetup
from devices.rehearsal.bench_scene import BenchScene
from devices.rehearsal.rehearsal import KILO
from devices.scan.journal import SUFFIX
from recordings.files import load

TOOL = [str(Path(sys.executable).with_name("difflidar"))]
KILLED_AT = (0.15, 0.45, 0.8)
FULL_AT = 0.3
LOOK_S = 0.2


def main() -> None:
    """Run it, and print what it came to."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--grid", default="80x45")
    parser.add_argument("--speed", type=float, default=50.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--host", default="127.0.0.9")
    parser.add_argument("--calm", action="store_true")
    wanted = parser.parse_args()
    columns, rows = map(int, wanted.grid.split("x"))
    size = columns * rows
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        trouble = [] if wanted.calm else ["--lose", "0.01"]
        for what, shares in () if wanted.calm else (("unplug", (0.2, 1.3)), ("stop", (0.25, 0.9))):
            for share in shares:
                trouble += [f"--{what}-at", str(int(share * size))]
        rehearsed = [*TOOL, "rehearse", folder, "--grid", wanted.grid, "--speed", str(wanted.speed)]
        rehearsed += ["--seed", str(wanted.seed), "--host", wanted.host, *trouble]
        with subprocess.Popen(rehearsed, stdout=subprocess.DEVNULL) as rehearsal:
            try:
                began = time.monotonic()
                starts = scan_to_the_end(place, size, wanted.calm)
                took = time.monotonic() - began
            finally:
                rehearsal.send_signal(signal.SIGTERM)
        report(place, wanted, size, starts, took)


def scan_to_the_end(place: Path, size: int, calm: bool) -> list[str]:
    """Begin, and go on as often as it ends early; how each start ended."""
    while not (place / "rig.json").exists():
        time.sleep(LOOK_S)
    ends: list[str] = []
    kills = [] if calm else [int(2 * size * share) for share in KILLED_AT]
    full = None if calm else int(2 * size * FULL_AT)
    command = [*TOOL, "scan", str(place / "plan.json"), "--rig", str(place / "rig.json"), "--out", str(place / "s.rrd")]
    while not ends or ends[-1] != "done":
        here = command + (["--resume"] if ends else [])
        filled = full is not None and done(place) >= full
        limit = (lambda: limited(place)) if filled else None
        process = subprocess.Popen(here, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=limit)
        full = None if filled else full
        while process.poll() is None:
            time.sleep(LOOK_S)
            so_far = done(place)
            if kills and so_far >= kills[0] and not filled:
                kills.pop(0)
                os.kill(process.pid, signal.SIGKILL)
                break
            if full is not None and so_far >= full:
                process.send_signal(signal.SIGTERM)
                break
        said, wrong = process.communicate()
        print(said + wrong, flush=True)
        ends.append("done" if process.returncode == 0 else f"{process.returncode}")
        if len(ends) > 20:
            raise SystemExit("it does not end")
    return ends


def limited(place: Path) -> None:
    """No file may grow by more than a little: to a program, a full disk."""
    now = max((path.stat().st_size for path in place.glob(f"*{SUFFIX}*")), default=0)
    resource.setrlimit(resource.RLIMIT_FSIZE, (now + 2_000_000,) * 2)


def done(place: Path) -> int:
    """Samples in the journal, read beside whoever writes it."""
    import sqlite3

    path = place / f"s.rrd{SUFFIX}"
    if not path.exists():
        return 0
    try:
        with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as base:
            return base.execute("SELECT count(*) FROM samples WHERE pass <> 'monitor'").fetchone()[0]
    except sqlite3.Error:
        return 0


def report(place: Path, wanted: argparse.Namespace, size: int, ends: list[str], took: float) -> None:
    """Maps against the truth, and what the scan says of itself."""
    lit, dark = load(place / "s.rrd"), load(place / "s-background.rrd")
    result = calibrate(lit, dark)
    scene_rng, *_ = np.random.default_rng(wanted.seed).spawn(3)
    scene = BenchScene(LidarSetup(kilo_iterations=KILO), scene_rng)
    poses = np.array(lit.meta["arm_pose"])[result.positions.frames[:, 0]]
    agree = cosines(result.maps.by_zone.astype(float), scene.truth(poses, KILO))
    tally, lidar = lit.meta["tally"], lit.meta["lidar"]
    rest = tally["whole_s"] - tally["moving_s"] - tally["measuring_s"]
    print(f"starts that ended: {ends}; {took:.0f} s for {size} positions twice at speed {wanted.speed:g}")
    print(f"cosine to the truth: worst {agree.min():.5f}, mean {agree.mean():.5f} over {len(poses)} positions")
    print(f"last sitting: {json.dumps(tally)}; lidar: {json.dumps(lidar.get('lost', {}))}")
    share = rest / (tally["moving_s"] + tally["measuring_s"])
    print(f"beyond motion and measuring: {100 * share:.1f} %")
    print(f"children's largest memory: {resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
