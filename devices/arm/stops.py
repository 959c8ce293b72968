"""Why an arm does not move, from the states that its controller streams."""

import time

from devices.arm.link import Link, State
from devices.captures import ArmStopped

EXPLAINED_S = 0.2
PLAYING, RUNNING = 2, 7
PROTECTIVE, SAFEGUARD, EMERGENCY, VIOLATION, FAULT, STOPPED = (1 << bit for bit in (2, 4, 7, 8, 9, 10))
RUNTIMES = {0: "stopping", 1: "stopped", 3: "pausing", 4: "paused", 5: "resuming"}


def safety_stop(state: State) -> ArmStopped | None:
    """The stop that safety brought about, None where there is none."""
    bits = state.safety_bits
    if bits & EMERGENCY:
        return ArmStopped(
            "emergency",
            "the arm is in emergency stop: release the button, switch the arm on and release its brakes",
        )
    if bits & (VIOLATION | FAULT):
        return ArmStopped(
            "protective", "the arm reports a safety fault: read the pendant, and restart the safety system"
        )
    if bits & PROTECTIVE:
        return ArmStopped(
            "protective",
            "the arm is in protective stop: see what it ran into or could not reach, then release it",
        )
    if bits & SAFEGUARD:
        return ArmStopped("protective", "a safeguard holds the arm: close the door or leave the guarded area")
    if bits & STOPPED:
        return ArmStopped("protective", "the arm is stopped for safety: read the pendant, then release it")
    if state.robot_mode != RUNNING:
        return ArmStopped("emergency", "the arm has no power or its brakes are on: switch it on and release its brakes")
    return None


def program_stop(state: State) -> ArmStopped | None:
    """The stop of our program on the controller, None while it runs."""
    if state.runtime_state == PLAYING:
        return None
    return ArmStopped(
        "program",
        f"the program on the arm's controller is {RUNTIMES.get(state.runtime_state, 'gone')}: somebody stopped it on "
        "the pendant, the pose is out of reach, or this computer was silent for too long; clear that, then resume",
    )


def check_stops(link: Link, state: State) -> None:
    """Raise what stops the arm, if anything does."""
    stop = safety_stop(state)
    if stop is not None:
        raise stop
    if program_stop(state) is not None:
        explain(link)


def explain(link: Link) -> None:
    """Raise why the program ended or took no order; the reason may come to light later than the end."""
    end = time.monotonic() + EXPLAINED_S
    while True:
        state = link.state()
        stop = safety_stop(state)
        if stop is not None or time.monotonic() > end:
            none_seen = ArmStopped("not moved", "the arm took no order: read what the pendant says, then resume")
            raise stop or program_stop(state) or none_seen
