"""Whether an arm can be driven, before anything moves; what is wrong is one sentence that says what to do."""

import socket
from typing import Any

import numpy as np

from calibrate.rig import ArmSetup
from devices.arm.dashboard import PORT, Dashboard
from devices.arm.kinematics import forward, links, pose_of, transform
from recordings.refusal import Refusal

# A robot's own calibration moves its tool by millimetres from the nominal; another model, by centimetres.
OTHER_MODEL_M = 0.01


def called(address: str) -> Dashboard:
    """The dashboard at an address, or why there is none."""
    if not address:
        raise Refusal("rig: arm.address is empty, expected the address that the pendant shows under Settings, Network")
    try:
        return Dashboard(address)
    except socket.gaierror:
        raise Refusal(f"arm: no machine is called {address}, expected the address that the pendant shows") from None
    except ConnectionRefusedError:
        raise Refusal(
            f"arm: {address} is there but does not answer on port {PORT}: is it the arm's controller, has it started, "
            "and are its services enabled (Settings, Security, Services)?"
        ) from None
    except OSError as error:
        raise Refusal(
            f"arm: nothing answers at {address} ({error}): check the network cable, the address on the pendant, that "
            "this computer is on the same network, and its firewall"
        ) from None


def check_ready(dashboard: Dashboard) -> dict[str, Any]:
    """What the controller says of itself; `Refusal` where it cannot be driven as it stands."""
    safety = dashboard.value("safetystatus")
    if "EMERGENCY" in safety:
        raise Refusal("arm: emergency stop: release the button, then switch the arm on and release its brakes")
    if safety not in ("NORMAL", "REDUCED"):
        raise Refusal(
            f"arm: stopped for safety ({safety.lower().replace('_', ' ')}): find out why, then release it on the "
            "pendant"
        )
    mode = dashboard.value("robotmode")
    if mode != "RUNNING":
        raise Refusal(
            f"arm: not ready to move ({mode.lower().replace('_', ' ')}): switch it on and release its brakes on the "
            "pendant"
        )
    if not dashboard.remote:
        raise Refusal("arm: in local mode: choose Remote Control in the upper right corner of the pendant")
    state = dashboard.ask("programState")
    if state.startswith("PLAYING"):
        raise Refusal(
            f"arm: a program is running on its controller ({state.removeprefix('PLAYING').strip()}): stop it on the "
            "pendant; where it is a scan that was killed just now, wait a few seconds"
        )
    return {"controller": dashboard.ask("PolyscopeVersion"), "serial": dashboard.ask("get serial number")}


def check_model(setup: ArmSetup, joints: np.ndarray, pose: np.ndarray) -> None:
    """Refuse a rig file that describes another arm: its joints (6,) would have the tool elsewhere than at pose (6,)."""
    tool = transform(np.array(setup.tool))
    expected = pose_of(forward(links(setup.model), joints) @ tool)
    apart = float(np.linalg.norm(expected[:3] - pose[:3]))
    if apart > OTHER_MODEL_M:
        raise Refusal(
            f"rig: arm.model {setup.model} has the tool {1000 * apart:.0f} mm from where the arm says it is: expected "
            "the model on the arm's name plate, and the tool that is mounted"
        )
