"""The program on a UR controller that takes our orders."""

import time

import numpy as np

from calibrate.rig import ArmSetup
from devices.arm.dashboard import Dashboard
from devices.arm.link import Link
from devices.arm.preflight import check_model
from devices.arm.stops import explain, program_stop, safety_stop
from devices.captures import ArmStopped, DeviceLost

# A program that was sent runs some cycles later; a tool that was set is in the states of the cycles after.
STARTS_S, CYCLES = 5.0, 5


def run_program(link: Link, dashboard: Dashboard, setup: ArmSetup) -> None:
    """Have it run, with the patch as its tool and the watchdog on.

    Raises `ArmStopped`, `DeviceLost`, and `Refusal` where the rig file describes another arm than is there.
    """
    if program_stop(link.state()) is not None or not link.ask("running"):
        try:
            dashboard.ask("stop")
        except OSError as error:
            raise DeviceLost(f"the arm's dashboard is gone ({error}): check its cable") from None
        link.ask("start")
    end = time.monotonic() + STARTS_S
    while program_stop(state := link.state()) is not None or not link.ask("running"):
        stop = safety_stop(state)
        if stop is not None or time.monotonic() > end:
            raise stop or program_stop(state) or ArmStopped("program", "the arm's controller runs no program of ours")
    if not link.ask("set_up", list(setup.tool)):
        explain(link)
    state = [link.state() for _ in range(CYCLES)][-1]
    check_model(setup, np.array(state.joints), np.array(state.pose))
