"""Waiting until somebody has released an arm that was stopped."""

import time
from contextlib import suppress

from devices.arm.dashboard import Dashboard
from devices.arm.link import Link
from devices.arm.stops import safety_stop
from devices.captures import ArmStopped, DeviceLost

ASK_AGAIN_S = 0.25


def await_release(link: Link, dashboard: Dashboard, unlock: bool, wait_s: float) -> None:
    """Return when safety lets the arm move and programs may come; `ArmStopped` where it does not within wait_s.

    unlock: ask the controller to release protective stops; it refuses that for 5 s after they happened.
    """
    end = time.monotonic() + wait_s
    while True:
        stop = safety_stop(link.state())
        try:
            if stop is None:
                if dashboard.remote:
                    return
                stop = ArmStopped("program", "the arm is in local mode: choose Remote Control on the pendant")
            elif unlock and dashboard.value("safetystatus") == "PROTECTIVE_STOP":
                with suppress(OSError):
                    dashboard.ask("close safety popup")
                dashboard.ask("unlock protective stop")
        except OSError as error:
            raise DeviceLost(f"the arm's dashboard is gone ({error}): check its cable") from None
        if time.monotonic() > end:
            raise stop
        time.sleep(ASK_AGAIN_S)
