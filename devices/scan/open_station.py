"""The devices of a rig, opened, and what they say of themselves."""

from collections.abc import Callable
from typing import Any

from calibrate.plan import ScanPlan
from calibrate.rig import Rig
from devices.scan.kept import Kept
from devices.scan.motion_plan import MotionPlan
from devices.scan.station import Station


def open_station(rig: Rig, plan: MotionPlan, tell: Callable[[str], None]) -> tuple[Station, dict[str, dict[str, Any]]]:
    """All three devices ready, and device -> what it said; the arm has not moved, and can reach all of the plan.

    Raises `Refusal` where a device is not there or a position is out of reach; nothing stays open then.
    """
    from devices.arm.reach import check_reach
    from devices.arm.ur import open_arm
    from devices.camera.open import open_camera
    from devices.tmf882x.driver import open_tmf882x

    motion = {"speed_m_s": plan.speed_m_s, "acceleration_m_s2": plan.acceleration_m_s2}
    arm = Kept("arm", lambda: open_arm(rig.arm, **motion), tell)
    lidar = Kept("LiDAR", lambda: open_tmf882x(rig.lidar), tell)
    camera = Kept("camera", lambda: open_camera(rig.camera), tell)
    station = Station(arm, lidar, camera, plan.settle_s, tell)
    try:
        visits = ScanPlan(plan.columns, plan.rows).cells @ [1, plan.columns]
        said = {"lidar": lidar.device.said, "camera": camera.device.said, "arm": arm.device.said}
        check_reach(plan.poses(visits), rig.arm, arm.device.joints)
    except BaseException:
        station.close()
        raise
    return station, said
