"""The checks of a rig, one device after another; each finding says what was measured and what to do about it."""

import os
import shutil
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from calibrate.rig import Rig
from devices.arm.reach import check_reach
from devices.arm.ur import open_arm
from devices.camera.open import open_camera
from devices.clock import DeviceClock, between
from devices.scan.motion_plan import MotionPlan
from devices.tmf882x.driver import Tmf882x, open_tmf882x
from physics.timing import LASER_HZ

MEASUREMENTS, PICTURES = 24, 30
# The sensor's RC oscillator is within 3 % (datasheet); more is another clock, or lost ticks.
MOST_SKEW = 0.04
LEAST_RATE, MOST_LOST = 0.8, 0.02
# Of 255: a picture whose middle half is darker or brighter shows no patch.
DARK, BRIGHT = 10, 240
# A frame of a scan on disk, its journal and its recording together.
BYTES_A_POSITION = 250_000
READ_OUT_S = 0.15


@dataclass(frozen=True)
class Finding:
    """What a check came to. good: None where it could not be judged. remedy: what to do, "" where all is well."""

    what: str
    good: bool | None
    said: str
    remedy: str = ""


@dataclass
class Examination:
    """Devices that are open, and clocks that were heard, on the way from one check to the next."""

    rig: Rig
    plan: MotionPlan | None
    out: Path
    lidar: Tmf882x | None = None
    camera: Any = None
    clocks: dict[str, DeviceClock] = field(default_factory=dict)


def lidar(patient: Examination) -> Iterator[Finding]:
    """Whether it answers, and what it says it is."""
    patient.lidar = open_tmf882x(patient.rig.lidar)
    said = patient.lidar.said
    yield Finding("LiDAR", True, f"{said['firmware']} at {said['port']}, {said['mode']}, {said['ranging']} range")
    pages = said.get("factory_calibration") or {}
    if pages.get("zone_zero_bins") is None:
        yield Finding(
            "LiDAR's factory calibration",
            None,
            "could not be read",
            "histograms need none; the distances that the chip finds do: calibrate it in its housing, keep the page",
        )


def lidar_rate(patient: Examination) -> Iterator[Finding]:
    """Rate, losses and light of some measurements."""
    if patient.lidar is None:
        return
    clock = patient.clocks["LiDAR"] = DeviceClock("LiDAR")
    frames = patient.lidar.frames()
    seen = [next(frames) for _ in range(MEASUREMENTS)]
    frames.close()
    for one in seen:
        clock.heard(one.device_s, one.host_s)
    period = float(np.median(np.diff([one.host_s for one in seen])))
    kilo = patient.lidar.said.get("kilo_iterations") or patient.rig.lidar.kilo_iterations
    expected = 1024 * kilo / LASER_HZ + READ_OUT_S if kilo else None
    asked = f", {expected:.2f} s expected" if expected else ""
    slow = bool(expected is not None and period > expected / LEAST_RATE)
    yield Finding(
        "LiDAR's rate",
        not slow,
        f"a measurement every {period:.3f} s{asked}",
        "" if not slow else "I2C at 400 kHz, chunks as large as the board allows, no other load on the board",
    )
    missed = seen[-1].number - seen[0].number + 1 - len(seen)
    share = missed / max(seen[-1].number - seen[0].number + 1, 1)
    yield Finding(
        "LiDAR's lines",
        share <= MOST_LOST,
        f"{missed} of {len(seen) + missed} measurements lost or damaged",
        "" if share <= MOST_LOST else "another USB cable or port, no hub; lower other load on this computer",
    )
    counts = np.stack([one.counts for one in seen])
    dead = [int(zone) for zone in np.flatnonzero(counts.sum(axis=(0, 2)) == 0)]
    yield Finding(
        "LiDAR's light",
        not dead,
        f"zones {dead} count nothing" if dead else f"{counts.sum(axis=2).mean():,.0f} counts a zone and measurement",
        "remove what covers the sensor; check the SPAD map" if dead else "",
    )


def camera(patient: Examination) -> Iterator[Finding]:
    """Size, rate, lens and light of some pictures."""
    patient.camera = open_camera(patient.rig.camera)
    said = patient.camera.said
    name = said.get("name") or said.get("kind") or "camera"
    clock = patient.clocks["camera"] = DeviceClock("camera")
    began = time.monotonic()
    seen = [patient.camera.capture() for _ in range(PICTURES)]
    rate = PICTURES / (time.monotonic() - began)
    for one in seen:
        clock.heard(one.device_s, one.host_s)
        if "clock_read" in one.said:
            clock.asked(*one.said["clock_read"])
    height, width = seen[-1].rgb.shape[:2]
    good = (width, height) == tuple(patient.rig.camera.size)
    yield Finding(
        "camera",
        good,
        f"{name}, {width} x {height}, {rate:.0f} pictures a second one by one",
        "" if good else f"rig.camera.size says {patient.rig.camera.size[0]} x {patient.rig.camera.size[1]}",
    )
    lens = said.get("intrinsics") is not None
    yield Finding(
        "camera's lens",
        lens,
        "known" if lens else "unknown",
        "" if lens else "give fx, fy, cx, cy in camera.intrinsics",
    )
    level = float(np.mean(seen[-1].rgb[height // 4 : -height // 4, width // 4 : -width // 4]))
    lit = bool(DARK < level < BRIGHT)
    yield Finding(
        "camera's light",
        lit,
        f"the middle of the picture is at {level:.0f} of 255",
        "" if lit else "switch the light on, or set camera.exposure_us",
    )


def clocks(patient: Examination) -> Iterator[Finding]:
    """The LiDAR's clock against this computer's, and both clocks together."""
    if "LiDAR" in patient.clocks:
        skew = patient.clocks["LiDAR"].relation().skew
        good = bool(abs(skew) < MOST_SKEW)
        yield Finding(
            "LiDAR's clock",
            good,
            f"off by {100 * skew:+.2f} % against this computer's",
            "" if good else "ticks are lost: check the lines above, and the firmware's clock correction",
        )
    if len(patient.clocks) == 2:
        apart = between(patient.clocks["camera"].relation(), patient.clocks["LiDAR"].relation(), time.time())
        known = np.isfinite(apart.systematic_s)
        besides = f", and up to {1e3 * apart.systematic_s:.1f} ms of latency" if known else ", and the least latencies"
        yield Finding(
            "clocks together",
            True,
            f"the camera's is {apart.offset_s:+.4f} s from the LiDAR's, to {1e3 * apart.sigma_s:.2f} ms{besides}",
        )


def arm(patient: Examination) -> Iterator[Finding]:
    """Whether it can be driven, and reaches all of the plan."""
    with open_arm(patient.rig.arm) as driven:
        x, y, z = driven.pose[:3]
        yield Finding(
            "arm", True, f"{driven.said['model']}, {driven.said.get('controller', '')}: at {x:.3f} {y:.3f} {z:.3f} m"
        )
        if patient.plan is not None:
            cells = np.arange(patient.plan.size)
            path = check_reach(patient.plan.poses(cells), patient.rig.arm, driven.joints)
            yield Finding("arm's reach", True, f"all {len(cells)} positions, {path.metres:.1f} m in rows")


def room(patient: Examination) -> Iterator[Finding]:
    """Whether a scan fits on the disk."""
    free = shutil.disk_usage(patient.out).free
    passes = 2 if patient.plan is None or patient.plan.passes != "patch only" else 1
    size = 3600 if patient.plan is None else patient.plan.size * patient.plan.repeats
    wanted = passes * size * BYTES_A_POSITION
    good = free > wanted and os.access(patient.out, os.W_OK)
    yield Finding(
        "room on the disk",
        good,
        f"{free / 1e9:.1f} GB in {patient.out.resolve()}, a scan takes up to {wanted / 1e9:.1f}",
        "" if good else "make room, or scan into another folder",
    )
