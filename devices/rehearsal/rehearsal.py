"""Emulated sensor, arm and camera before one simulated bench, at addresses where drivers find them."""

import json
import shutil
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from calibrate.rig import ArmSetup, CameraSetup, LidarSetup
from devices.arm.kinematics import inverse, links, transform
from devices.emulated.pictures import serve_pictures
from devices.emulated.tmf882x.faults import Faults
from devices.emulated.tmf882x.firmware import Firmware
from devices.emulated.tmf882x.setting import Setting
from devices.emulated.tmf882x.terminal import Terminal
from devices.emulated.ur.arm import EmulatedController
from devices.rehearsal.bench_scene import BenchScene
from devices.rehearsal.control import Control
from devices.rehearsal.person import Person
from recordings.atomic import written_aside
from recordings.refusal import Refusal

RIG, PLAN, PORT = "rig.json", "plan.json", "lidar"
# A person inspects a protective stop before releasing it; the controller wants five seconds.
RELEASED_AFTER_S = 6.0
MODEL = "UR10"
# What the reference firmware offers in 3 x 3 zones.
KILO = 10_000


@dataclass(frozen=True)
class Trouble:
    """What goes wrong. lidar: in the sensor and its cable. stops: number of a move -> "protective", "emergency", ...

    released_after_s: how long a stopped arm waits for the person who releases it, seconds of the controller's clock.
    """

    lidar: Faults = field(default_factory=Faults)
    stops: tuple[tuple[int, str], ...] = ()
    released_after_s: float = RELEASED_AFTER_S


class Rehearsal:
    """Serves the three devices from entering the context until leaving it.

    folder: gets rig.json and plan.json, which say where the devices are, and the serial port. columns, rows: of the
    plan, `more`: its other fields. speed: how many times faster than real the clocks run. host: loopback address of the
    arm's controller, whose ports are fixed.
    """

    def __init__(
        self,
        folder: str | Path,
        columns: int = 80,
        rows: int = 45,
        *,
        rng: np.random.Generator,
        lidar: LidarSetup | None = None,
        speed: float = 1.0,
        host: str = "127.0.0.1",
        trouble: Trouble | None = None,
        **more,
    ) -> None:
        self.folder, self.speed, self._host, self._trouble = Path(folder), speed, host, trouble or Trouble()
        if not (np.isfinite(speed) and speed > 0):
            raise Refusal(f"speed is {speed}, expected a number above 0")
        scene_rng, self._firmware_rng, self._port_rng = rng.spawn(3)
        self._lidar = lidar or LidarSetup(kilo_iterations=KILO)
        self.scene = BenchScene(self._lidar, scene_rng)
        self.plan = self.scene.plan(columns, rows, **more)
        self._stack = ExitStack()

    def __enter__(self) -> "Rehearsal":
        try:
            self._start()
        except BaseException:
            self._stack.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def failure(self) -> Exception | None:
        """What ended the emulated sensor, where something did that nobody asked for."""
        return self.terminal.failure

    def _start(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        # Small products in many threads cost more in waiting than they take.
        self._stack.enter_context(threadpool_limits(1))
        # Paths of sockets may have about a hundred characters, those of folders more.
        sockets = Path(tempfile.mkdtemp(prefix="difflidar-"))
        self._stack.callback(shutil.rmtree, sockets, ignore_errors=True)
        pictures, self.control = sockets / "camera", sockets / "control"
        size = self.scene.bench.image_size
        camera = CameraSetup("rehearsed", str(pictures), size)
        lidar = replace(self._lidar, port=str((self.folder / PORT).resolve()))
        self.rig = self.scene.rig(lidar, camera=camera, arm=ArmSetup(self._host, MODEL), control=str(self.control))
        self.arm = self._stack.enter_context(
            EmulatedController(self._host, MODEL, self._start_joints(), self.speed, dict(self._trouble.stops))
        )
        firmware = Firmware(self._seen, self._firmware_rng)
        port = self.folder / PORT
        self.terminal = self._stack.enter_context(
            Terminal(firmware, port, speed=self.speed, faults=self._trouble.lidar, rng=self._port_rng)
        )
        bench = self.scene.bench
        lens = (bench.focal_px, bench.focal_px, *bench.principal_px)
        looked = serve_pictures(str(pictures), self._looked, size, intrinsics=lens, depth=False, speed=self.speed)
        self._stack.enter_context(looked)
        self._stack.callback(Control(self.control, self._orders()).close)
        self._stack.callback(Person(self.arm, self._trouble.released_after_s).close)
        for name, text in ((RIG, self.rig.text()), (PLAN, self.plan.text())):
            with written_aside(self.folder / name) as aside:
                aside.write_text(text, encoding="utf-8")

    def _start_joints(self) -> np.ndarray:
        """Joints that hold the tool before the middle of the grid."""
        middle = self.plan.poses(np.array([self.plan.middle]))
        found = inverse(links(MODEL), transform(middle)).joints[0]
        return found[np.isfinite(found).all(axis=1)][0]

    def _seen(self, setting: Setting) -> np.ndarray:
        """(sets, 10, 128) counts, for the firmware."""
        channels = self.scene.counts(self.arm.tool_pose, setting.kilo_iterations)
        reference, zones = channels[:1], channels[1:]
        sets = (
            [zones[i : i + 9] for i in range(0, len(zones), 9)]
            if setting.sets == 1
            else np.array_split(zones, setting.sets)
        )
        full = np.zeros((len(sets), 10, zones.shape[1]), np.uint32)
        for one, part in zip(full, sets, strict=True):
            one[0], one[1 : 1 + len(part)] = reference[0], part
        return full

    def _looked(self) -> tuple[np.ndarray, None]:
        """A picture, for the camera; no depth: its projector is off."""
        return self.scene.picture(self.arm.tool_pose), None

    def _orders(self) -> dict[str, Callable[..., str | None]]:
        """What may be asked of a rehearsal while it runs."""

        def patch(state: str) -> None:
            if state not in ("on", "off"):
                raise ValueError(f"{state!r} found, expected on or off")
            self.scene.patch = state == "on"

        def status() -> str:
            return json.dumps({"patch": self.scene.patch, "arm": self.arm.state()})

        return {
            "patch": patch,
            "unplug": lambda seconds="2": self.terminal.unplug(float(seconds)),
            "arm": self.arm.interrupt,
            "status": status,
        }
