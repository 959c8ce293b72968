"""The dashboard of an emulated controller: a line of text in, a line out.

Universal Robots, "Dashboard Server e-Series"; the answers are the real one's, as far as they are published.
"""

from collections.abc import Callable

from devices.emulated.ur.controller import Controller
from devices.emulated.ur.safety import PAUSED, ROBOT_MODES, SAFETY

GREETING = b"Connected: Universal Robots Dashboard Server\n"
# Orders that the real one obeys in remote control only.
ORDERS = ("stop", "pause", "power on", "power off", "brake release", "unlock protective stop", "restart safety")


def answer(controller: Controller, line: str) -> str:
    """What the dashboard says to a line."""
    e_series = controller.version[0] >= 5
    asked: dict[str, Callable[[], str]] = {
        "robotmode": lambda: f"Robotmode: {ROBOT_MODES[controller.robot_mode]}",
        "safetymode": lambda: f"Safetymode: {SAFETY[controller.safety_mode]}",
        "safetystatus": lambda: f"Safetystatus: {SAFETY[controller.safety_mode]}",
        "running": lambda: f"Program running: {str(controller.playing).lower()}",
        "programState": lambda: f"{_program(controller)} <unnamed>",
        "get robot model": lambda: controller.model.removesuffix("e"),
        "PolyscopeVersion": lambda: f"URSoftware {'.'.join(map(str, controller.version))} (Feb 01 2022)",
        "get serial number": lambda: "20195500001" if e_series else "2014300001",
        "close safety popup": lambda: "closing safety popup",
        "close popup": lambda: "closing popup",
        "stop": lambda: _done(controller.stop_program, "Stopped"),
        "pause": lambda: _done(controller.pause_program, "Pausing program"),
        "power on": lambda: _done(controller.power_on, "Powering on"),
        "power off": lambda: _done(controller.power_off, "Powering off"),
        "brake release": lambda: _done(controller.release_brakes, "Brake releasing"),
        "restart safety": lambda: _done(controller.release, "Restarting safety"),
        "unlock protective stop": controller.unlock,
    }
    if e_series:
        asked["is in remote control"] = lambda: str(controller.remote).lower()
    if line not in asked:
        return f"could not understand: '{line}'"
    if line in ORDERS and not controller.remote:
        return "Command is not allowed due to safety reasons. (Requires remote control)"
    said = asked[line]()
    controller.stirred = True
    return said


def _program(controller: Controller) -> str:
    return "PLAYING" if controller.playing else "PAUSED" if controller.runtime_state == PAUSED else "STOPPED"


def _done(action: Callable[[], None], said: str) -> str:
    action()
    return said
