"""Whether a rig is ready: every device asked, every figure that a scan rests on measured, each with what to do."""

from collections.abc import Callable, Iterator
from pathlib import Path

from calibrate.rig import Rig
from devices.captures import ArmStopped, DeviceLost
from devices.examination import Examination, Finding, arm, camera, clocks, lidar, lidar_rate, room
from devices.scan.motion_plan import MotionPlan
from recordings.refusal import Refusal

CHECKS: dict[str, Callable[[Examination], Iterator[Finding]]] = {
    "LiDAR": lidar,
    "LiDAR's rate": lidar_rate,
    "camera": camera,
    "clocks": clocks,
    "arm": arm,
    "room on the disk": room,
}


def examine(rig: Rig, plan: MotionPlan | None = None, out: Path = Path()) -> Iterator[Finding]:
    """Check after check, as they are done; no arm moves. out: folder in which a scan would be written."""
    patient = Examination(rig, plan, out)
    try:
        for what, check in CHECKS.items():
            yield from _judged(what, check, patient)
    finally:
        for device in (patient.lidar, patient.camera):
            if device is not None:
                device.close()


def _judged(what: str, check: Callable[[Examination], Iterator[Finding]], patient: Examination) -> Iterator[Finding]:
    """The findings of a check; what ends it is one, too. A refusal says what to do about it itself."""
    try:
        yield from check(patient)
    except (Refusal, DeviceLost, ArmStopped) as wrong:
        said, _, remedy = str(wrong).partition(": ")
        yield Finding(what, False, str(wrong) if not remedy else said, remedy)
    except OSError as wrong:
        yield Finding(what, False, str(wrong), "see to the device's cable and to your permissions")
