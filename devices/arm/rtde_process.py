"""ur_rtde in a process of its own, asked by `devices.arm.link`: python -m devices.arm.rtde_process ADDRESS WATCHDOG_S.

ur_rtde never returns from a command whose answer is lost, and would repeat the command once it has connected again;
here it can be ended. A line of standard input is a JSON list of a number, a verb and its arguments; the line that
answers it repeats the number. When input ends, because the scan ended or died, the arm is brought to rest.
"""

import json
import os
import select
import signal
import sys
import time
from contextlib import suppress
from typing import Any

# The speed of a stop; the longest that `state` waits for the next one.
STOP_M_S2, NEXT_S, POLL_S = 2.0, 0.05, 0.0005
PLAYING = 2


class Driver:
    """What can be asked for; each public method is a verb."""

    def __init__(self, address: str, watchdog_s: float) -> None:
        from rtde_control import RTDEControlInterface
        from rtde_receive import RTDEReceiveInterface

        self._watchdog_s, self._last = watchdog_s, -1.0
        self._receive = RTDEReceiveInterface(address)
        # The program is sent by `start`, not by whoever connects: nothing may move because a line came back.
        self._control = RTDEControlInterface(address, -1.0, RTDEControlInterface.FLAG_NO_WAIT)

    def state(self, following: bool) -> dict[str, Any]:
        """The state that the controller streamed last, or the next one, if it comes soon."""
        end = time.monotonic() + following * NEXT_S
        while self._receive.getTimestamp() == self._last and time.monotonic() < end:
            time.sleep(POLL_S)
        receive, self._last = self._receive, self._receive.getTimestamp()
        return {
            "time_s": self._last,
            "pose": receive.getActualTCPPose(),
            "speed": receive.getActualTCPSpeed(),
            "joints": receive.getActualQ(),
            "safety_bits": receive.getSafetyStatusBits(),
            "robot_mode": receive.getRobotMode(),
            "runtime_state": receive.getRuntimeState(),
            "operating": self._control.getAsyncOperationProgressEx().isAsyncOperationRunning(),
            "connected": receive.isConnected() and self._control.isConnected(),
        }

    def start(self) -> bool:
        """Send the program that takes commands; it runs some cycles later."""
        return self._control.reuploadScript()

    def running(self) -> bool:
        """Whether it runs."""
        return self._control.isProgramRunning()

    def set_up(self, tool: list[float]) -> bool:
        """The tool in the flange's frame, and the watchdog."""
        watched = self._watchdog_s <= 0 or self._control.setWatchdog(1 / self._watchdog_s)
        return self._control.setTcp(tool) and watched

    def move(self, pose: list[float], speed: float, acceleration: float) -> bool:
        """Set off in a straight line."""
        return self._control.moveL(pose, speed, acceleration, True)

    def stop(self) -> None:
        """Come to rest, if a program of ours runs."""
        if self._receive.getRuntimeState() == PLAYING:
            self._control.stopL(STOP_M_S2)

    def finish(self) -> None:
        """Come to rest and end our program."""
        if self._control.isConnected() and self._control.isProgramRunning():
            self.stop()
            self._control.stopScript()

    def kick(self) -> None:
        """Tell the controller's watchdog that we are here."""
        with suppress(RuntimeError):
            if self._control.isConnected() and self._control.isProgramRunning():
                self._control.kickWatchdog()


def main() -> None:
    """Answer until input ends."""
    address, watchdog_s = sys.argv[1], float(sys.argv[2])
    # An interrupt from the keyboard is for whoever asks us; it ends our input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # ur_rtde prints to where we answer.
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        driver = Driver(address, watchdog_s)
    except (RuntimeError, ValueError) as error:
        answers.write(json.dumps({"number": 0, "error": str(error)}) + "\n")
        return
    answers.write('{"number": 0}\n')
    heard, kicked = b"", time.monotonic()
    every_s = watchdog_s / 4 if watchdog_s > 0 else 1e9
    while True:
        if time.monotonic() - kicked >= every_s:
            driver.kick()
            kicked = time.monotonic()
        ready, _, _ = select.select([0], [], [], every_s)
        if not ready:
            continue
        read = os.read(0, 1 << 16)
        *lines, heard = (heard + read).split(b"\n")
        for line in lines:
            number, verb, *arguments = json.loads(line)
            try:
                said = {"number": number, "said": getattr(driver, verb)(*arguments)}
            except RuntimeError as error:
                said = {"number": number, "error": str(error)}
            with suppress(BrokenPipeError):
                answers.write(json.dumps(said) + "\n")
        if not read:
            with suppress(RuntimeError):
                driver.finish()
            # Its destructor sleeps, and its threads may hang on a dead line.
            os._exit(0)


if __name__ == "__main__":
    main()
