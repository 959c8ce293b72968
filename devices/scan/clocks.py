"""How far the camera's clock and the LiDAR's are apart, from when their messages arrived during a scan."""

from typing import Any

from devices.clock import DeviceClock, between
from devices.scan.journal import Journal
from recordings.refusal import Refusal


def clocks_apart(journal: Journal) -> dict[str, Any] | None:
    """What the camera's clock shows less what the LiDAR's does at the end of the patch pass; None where unknown.

    offset_s, sigma_s: seconds, and the standard error by the scatter of arrivals. systematic_s: what the least
    latencies of both may hide besides, None where nothing bounds them. lidar_skew, camera_skew: rates less 1. at_s:
    seconds since the epoch.
    """
    camera, lidar, at_s = DeviceClock("camera"), DeviceClock("LiDAR"), 0.0
    for sample in journal.samples("patch", pictures=False):
        for frame, ticks, picture in zip(sample.frames, sample.said["device_s"], sample.said["camera"], strict=True):
            lidar.heard(ticks, frame.time_s)
            at_s = frame.time_s
            if picture is not None:
                camera.heard(picture["device_s"], picture["host_s"])
                if "clock_read" in picture:
                    camera.asked(*picture["clock_read"])
    try:
        one, other = camera.relation(), lidar.relation()
    except Refusal:
        return None
    apart = between(one, other, at_s)
    hidden = apart.systematic_s
    return {
        "at_s": at_s,
        "offset_s": apart.offset_s,
        "sigma_s": apart.sigma_s,
        "systematic_s": hidden if hidden < float("inf") else None,
        "camera_skew": one.skew,
        "lidar_skew": other.skew,
    }
