"""The demo's beginning: a rig that is not there, scanned through the drivers of the real one."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from calibrate.calibration import Calibration
from calibrate.rig import LidarSetup, load_rig
from devices.scan.conduct import conduct
from devices.scan.motion_plan import load_plan
from devices.scan.visit import Seen
from recordings.refusal import Refusal

SPEED = 50.0
STARTS_S, LOOK_S = 60.0, 0.1


@contextmanager
def rehearsed(folder: Path, grid: str, seed: int) -> Iterator[None]:
    """A rehearsal in a process of its own, which leaves rig.json and plan.json in `folder`."""
    for name in ("rig.json", "plan.json"):
        (folder / name).unlink(missing_ok=True)
    command = [sys.executable, "-m", "difflidar", "rehearse", str(folder), "--grid", grid, "--order", "adaptive"]
    command += ["--speed", str(SPEED), "--seed", str(seed), "--host", free_host()]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as rehearsal:
        try:
            given_up = time.monotonic() + STARTS_S
            while not (folder / "plan.json").exists():
                if rehearsal.poll() is not None or time.monotonic() > given_up:
                    rehearsal.kill()
                    raise Refusal(f"the rehearsal did not start: {rehearsal.communicate()[1].strip() or 'no answer'}")
                time.sleep(LOOK_S)
            yield
        finally:
            rehearsal.terminate()


def free_host() -> str:
    """A loopback address for the arm's controller, whose ports are fixed; only Linux has more than one."""
    if not sys.platform.startswith("linux"):
        return "127.0.0.1"
    number = os.getpid()
    return f"127.{1 + number // 65536 % 250}.{number // 256 % 256}.{1 + number % 254}"


def scan_rehearsed(
    out: Path, grid: str, seed: int, tell: Callable[[str], None], watch: Callable[[Seen], None]
) -> tuple[dict[str, Path], dict]:
    """Scan such a rig into scan.rrd and scan-background.rrd; pass -> file, and the tally."""
    for old in out.glob("scan*.rrd*"):
        old.unlink()
    with rehearsed(out / "rig", grid, seed):
        plan, rig = load_plan(out / "rig" / "plan.json"), load_rig(out / "rig" / "rig.json")
        return conduct(plan, rig, out / "scan.rrd", ask=tell, tell=tell, watch=watch)


def against_truth(result: Calibration, grid: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """(K,) pixels by which positions of the maps are off, and (P,) cosines of the maps to the truth of the bench."""
    from scipy.spatial import cKDTree

    from calibrate.consistency import cosines
    from calibrate.plan import ScanPlan
    from devices.rehearsal.bench_scene import BenchScene
    from devices.rehearsal.rehearsal import KILO

    size = ScanPlan.parse(grid)
    scene_rng, *_ = np.random.default_rng(seed).spawn(3)
    scene = BenchScene(LidarSetup(kilo_iterations=KILO), scene_rng)
    plan = scene.plan(size.columns, size.rows)
    poses = plan.poses(np.arange(plan.size))
    places = np.stack([scene.bench.project(scene.position_m(pose)) for pose in poses])
    found = np.stack([result.maps.xs, result.maps.ys], axis=1)
    off, cell = cKDTree(places).query(found)
    return off, cosines(scene.truth(poses[cell], KILO), result.maps.by_zone.astype(float))
