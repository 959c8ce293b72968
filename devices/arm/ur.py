"""Arms of Universal Robots, driven through ur_rtde."""

import time
from contextlib import suppress
from typing import Any

import numpy as np

from calibrate.rig import ArmSetup
from devices.arm.dashboard import Dashboard
from devices.arm.link import Link
from devices.arm.preflight import called, check_ready
from devices.arm.program import run_program
from devices.arm.release import await_release
from devices.arm.rest import Goal, watched
from devices.arm.stops import check_stops, explain
from devices.captures import ArmStopped, DeviceLost, Settled
from recordings.refusal import Refusal

TRIES_AGAIN_S = 0.25


def open_arm(
    setup: ArmSetup,
    *,
    speed_m_s: float = 0.25,
    acceleration_m_s2: float = 0.5,
    settled_m: float = 2e-4,
    settled_rad: float = 2e-3,
    watchdog_s: float = 1.0,
) -> "UrArm":
    """An arm that is ready to move; `Refusal` says why it cannot be had, and what to do.

    settled_m, settled_rad: how close to where it was sent the tool has to rest. watchdog_s: the controller stops the
    arm by itself when it has heard nothing for so long; 0 leaves the arm going to where it was sent.
    """
    if not (speed_m_s > 0 and acceleration_m_s2 > 0):
        raise Refusal(f"arm: speed {speed_m_s} m/s, acceleration {acceleration_m_s2} m/s^2: expected more than 0")
    return UrArm(setup, speed_m_s, acceleration_m_s2, Goal(settled_m, settled_rad), watchdog_s)


class UrArm:
    """An arm that carries the patch; leave its context, or `close` it, and it rests.

    said: model, controller's version, serial number, tool and the speed it moves at.
    """

    def __init__(
        self, setup: ArmSetup, speed_m_s: float, acceleration_m_s2: float, goal: Goal, watchdog_s: float
    ) -> None:
        self._setup, self._speed, self._acceleration = setup, speed_m_s, acceleration_m_s2
        self._goal, self._watchdog_s = goal, watchdog_s
        self._link: Link | None = None
        self._dashboard: Dashboard | None = called(setup.address)
        self.said: dict[str, Any] = {
            "model": setup.model,
            "tool": list(setup.tool),
            "speed_m_s": speed_m_s,
            "acceleration_m_s2": acceleration_m_s2,
        }
        try:
            self.said |= check_ready(self._dashboard)
            self._link = Link(setup.address, watchdog_s)
            run_program(self._link, self._dashboard, self._setup)
        except (OSError, DeviceLost, ArmStopped) as error:
            self.close()
            raise Refusal(
                f"arm: the controller at {setup.address} answers, but does not take commands: {error}; expected RTDE "
                "and the primary and secondary interfaces enabled, and no other program that uses them"
            ) from None
        except BaseException:
            self.close()
            raise

    @property
    def pose(self) -> np.ndarray:
        """(6,) of the tool, where it is now."""
        return self._there().state().pose

    @property
    def joints(self) -> np.ndarray:
        """(6,) radians, where they are now."""
        return self._there().state().joints

    def move(self, pose: np.ndarray) -> Settled:
        """Move the tool in a straight line to (6,) in the base's frame, and wait until it rests there.

        What it returns was read back. Raises `ArmStopped` where the arm was stopped or did not get there, `DeviceLost`
        where the controller is gone. The arm is stopped whenever this is left in another way than by returning.
        """
        link, target, began = self._there(), np.asarray(pose, float), time.monotonic()
        if target.shape != (6,) or not np.isfinite(target).all():
            raise Refusal(f"arm: cannot move to {target.tolist()}, expected metres and rotation vector, six numbers")
        check_stops(link, link.state(following=False))
        try:
            if not link.ask("move", target.tolist(), self._speed, self._acceleration):
                explain(link)
            reached, joints = watched(link, target, self._goal)
        except BaseException:
            with suppress(Exception):
                self.stop()
            raise
        return Settled(reached, joints, host_s=time.time(), moving_s=time.monotonic() - began)

    def stop(self) -> None:
        """Bring the arm to rest."""
        self._there().ask("stop")

    def resume(self, *, unlock: bool = False, wait_s: float = 3600.0) -> None:
        """Wait until somebody has released the arm, then make it ready to move again.

        unlock: release protective stops from here, 5 s after they happened; only where nobody can be hurt and what
        stopped it is known. Raises `ArmStopped` where it is still stopped after wait_s, `DeviceLost`.
        """
        await_release(self._there(), self._dashboard, unlock, wait_s)
        run_program(self._link, self._dashboard, self._setup)

    def reopen(self, wait_s: float = 60.0) -> None:
        """Connect anew after `DeviceLost`, as soon as the controller answers, for wait_s at most.

        Raises `DeviceLost` where it does not, `ArmStopped` where it is stopped: then `resume` goes on.
        """
        self._hang_up()
        end = time.monotonic() + wait_s
        while self._link is None:
            try:
                self._dashboard = called(self._setup.address)
                # What runs there is our program; it may not move once we are back.
                self._dashboard.ask("stop")
                self._link = Link(self._setup.address, self._watchdog_s)
            except (Refusal, OSError, DeviceLost) as error:
                self._hang_up()
                if time.monotonic() > end:
                    raise DeviceLost(str(error)) from None
                time.sleep(TRIES_AGAIN_S)
        run_program(self._link, self._dashboard, self._setup)

    def close(self) -> None:
        """Bring the arm to rest, end its program and let go of it."""
        self._hang_up()

    def __enter__(self) -> "UrArm":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _there(self) -> Link:
        if self._link is None:
            raise DeviceLost("the arm is not connected")
        return self._link

    def _hang_up(self) -> None:
        for line in (self._link, self._dashboard):
            if line is not None:
                line.close()
        self._link = self._dashboard = None
