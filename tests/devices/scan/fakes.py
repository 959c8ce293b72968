"""Devices in memory before the simulated bench, which go wrong when they are told to."""

import time
from collections.abc import Callable
from functools import cache

import numpy as np

from calibrate.rig import LidarSetup
from devices.captures import ArmStopped, DeviceLost, Measurement, Picture, Settled
from devices.rehearsal.bench_scene import BenchScene
from devices.scan.kept import Kept
from devices.scan.station import Station
from devices.scan.survey import survey

KILO = 400


class World:
    """The bench, where the arm is, and what is to go wrong: device -> calls of its verb at which it does."""

    def __init__(self, seed: int = 0, goes_wrong: dict[str, set[int]] | None = None) -> None:
        self.scene = BenchScene(LidarSetup(), np.random.default_rng(seed))
        self.pose = np.zeros(6)
        self.goes_wrong = goes_wrong or {}
        self.calls = {"arm": 0, "lidar": 0, "camera": 0, "reading": 0, "line": 0}
        self.moved_to: list[np.ndarray] = []
        self.opened: list[str] = []
        self.resumed = 0
        self.now_s = 1e9

    def wrong(self, device: str) -> bool:
        self.calls[device] += 1
        return self.calls[device] in self.goes_wrong.get(device, ())


class FakeArm:
    def __init__(self, world: World) -> None:
        self.world, self.said = world, {"model": "UR10"}
        world.opened.append("arm")

    def move(self, pose):
        if self.world.wrong("arm"):
            raise ArmStopped("protective", "The arm ran into something.")
        self.world.pose = np.array(pose)
        self.world.moved_to.append(np.array(pose))
        return Settled(np.array(pose), np.zeros(6), self.world.now_s, 0.5)

    def resume(self):
        self.world.resumed += 1

    def stop(self):
        pass

    def close(self):
        pass


class FakeLidar:
    def __init__(self, world: World) -> None:
        self.world, self.said = world, {"firmware": "fake", "kilo_iterations": KILO}
        world.opened.append("lidar")

    def measure(self):
        if self.world.wrong("lidar"):
            raise DeviceLost("the cable was pulled")
        self.world.now_s += 0.25
        counts = self.world.scene.counts(self.world.pose, KILO)
        number = self.world.calls["lidar"]
        return Measurement(counts[1:], counts[:1], None, None, 30.0, number, np.nan, self.world.now_s)

    def integrate(self):
        self.taken = self.measure()

    def read(self):
        if self.world.wrong("reading"):
            raise DeviceLost("the cable was pulled")
        return None if self.world.wrong("line") else self.taken

    def close(self):
        pass


def lens(world: World) -> dict[str, float]:
    bench = world.scene.bench
    return {"fx": bench.focal_px, "fy": bench.focal_px, "ppx": bench.principal_px[0], "ppy": bench.principal_px[1]}


class FakeCamera:
    def __init__(self, world: World) -> None:
        self.world = world
        self.said = {"intrinsics": lens(world)}
        world.opened.append("camera")

    def capture(self):
        if self.world.wrong("camera"):
            raise DeviceLost("the camera went away")
        rgb = self.world.scene.picture(self.world.pose)
        return Picture(rgb, None, time.monotonic(), self.world.now_s, self.world.calls["camera"])

    def close(self):
        pass


class FakeHolder:
    """Does what it is asked, unless it is told not to."""

    def __init__(self, world: World, obeys: bool = True) -> None:
        self.world, self.obeys, self.asked = world, obeys, []

    def show(self, patch):
        self.asked.append(patch)
        if self.obeys:
            self.world.scene.patch = patch


def station(world: World, tell: Callable[[str], None] = lambda sentence: None) -> Station:
    arm = Kept("arm", lambda: FakeArm(world), tell, again_s=0)
    lidar = Kept("LiDAR", lambda: FakeLidar(world), tell, again_s=0)
    camera = Kept("camera", lambda: FakeCamera(world), tell, again_s=0)
    return Station(arm, lidar, camera, 0.0, tell)


@cache
def known_survey(columns: int, rows: int) -> dict:
    """What a survey of a grid on the bench finds, which takes longer than the scan of a small one."""
    world = World()
    plan = world.scene.plan(columns, rows)
    return survey(plan, lambda cell: world.scene.picture(plan.poses(np.array([cell]))[0])).to_json()
