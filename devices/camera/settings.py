"""Give a RealSense its settings, read them back."""

from typing import Any

import pyrealsense2 as rs

from calibrate.rig import CameraSetup
from recordings.refusal import Refusal

COLOUR_STEP_US = 100  # the colour sensor's exposure is told in steps of 100 us, that of the depth sensor in us
READ_BACK = (
    "enable_auto_exposure",
    "exposure",
    "gain",
    "enable_auto_white_balance",
    "white_balance",
    "auto_exposure_priority",
    "emitter_enabled",
    "laser_power",
    "global_time_enabled",
    "asic_temperature",
    "projector_temperature",
)


def set_up(device: Any, setup: CameraSetup) -> None:
    """Set projector, exposure and clock; `Refusal` where the camera cannot have that exposure.

    The projector (about 850 nm) is just outside of the LiDAR's filter (894 to 986 nm) and leaks into it.
    """
    for sensor in device.query_sensors():
        # The SDK's own conversion to the host's time would hide the camera's clock.
        _put(sensor, rs.option.global_time_enabled, 0)
        if sensor.supports(rs.option.emitter_enabled):
            _put(sensor, rs.option.emitter_enabled, int(setup.emitter))
        if any(profile.stream_type() == rs.stream.color for profile in sensor.get_stream_profiles()):
            _put(sensor, rs.option.auto_exposure_priority, 0)  # auto exposure must not lower the frame rate
            _expose(sensor, setup.exposure_us)


def settings(device: Any) -> dict[str, dict[str, float]]:
    """What each sensor of the device says its options are."""
    said = {}
    for sensor in device.query_sensors():
        options = {name: getattr(rs.option, name) for name in READ_BACK}
        have = {name: option for name, option in options.items() if sensor.supports(option)}
        said[sensor.get_info(rs.camera_info.name)] = {name: _got(sensor, option) for name, option in have.items()}
    return said


def temperature_c(device: Any) -> float | None:
    """Of the camera's processor, where it tells."""
    for sensor in device.query_sensors():
        if sensor.supports(rs.option.asic_temperature):
            return _got(sensor, rs.option.asic_temperature)
    return None


def _put(sensor: Any, option: Any, value: float) -> None:
    if sensor.supports(option) and not sensor.is_option_read_only(option):
        sensor.set_option(option, value)


def _got(sensor: Any, option: Any) -> float | None:
    try:
        return sensor.get_option(option)
    except RuntimeError:  # a temperature that is known only while the projector is on
        return None


def _expose(sensor: Any, exposure_us: int) -> None:
    _put(sensor, rs.option.enable_auto_exposure, 0 if exposure_us else 1)
    if not exposure_us or not sensor.supports(rs.option.exposure):
        return
    can = sensor.get_option_range(rs.option.exposure)
    steps = round(exposure_us / COLOUR_STEP_US)
    if not can.min <= steps <= can.max:
        low, high = int(can.min * COLOUR_STEP_US), int(can.max * COLOUR_STEP_US)
        raise Refusal(f"camera.exposure_us is {exposure_us}, expected {low} to {high}, or 0 for the camera's choice")
    sensor.set_option(rs.option.exposure, steps)
