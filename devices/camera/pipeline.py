"""Find a RealSense, say in one sentence why it cannot be had, start its streams."""

from pathlib import Path
from typing import Any

import pyrealsense2 as rs

from calibrate.rig import CameraSetup
from devices.camera.settings import set_up
from devices.camera.source import Source
from devices.captures import DeviceLost
from recordings.refusal import Refusal

MAKER = "8086"  # USB vendor of the D400 cameras
UDEV = "install the udev rules of librealsense (99-realsense-libusb.rules) and plug the camera in again"
SETTLING = 30  # frames until automatic exposure has settled
FIRST_FRAME_S = 5.0
USB_DEVICES = Path("/sys/bus/usb/devices")


class Pipeline:
    """The streams of a real camera; see `Source`."""

    clock_rate = 1.0

    def __init__(self, pipeline: Any, active: Any) -> None:
        self._pipeline = pipeline
        self.device = active.get_device()
        self.colour = active.get_stream(rs.stream.color).as_video_stream_profile()
        self.depth = active.get_stream(rs.stream.depth).as_video_stream_profile()

    def drain(self) -> None:
        """Drop the frames that already wait."""
        try:
            while self._pipeline.poll_for_frames().size():
                pass
        except RuntimeError as wrong:
            raise DeviceLost(f"the RealSense stopped: {wrong}") from None

    def wait(self, timeout_s: float) -> Any:
        """The next set of frames."""
        try:
            came, frames = self._pipeline.try_wait_for_frames(int(timeout_s * 1e3))
        except RuntimeError as wrong:
            raise DeviceLost(f"the RealSense stopped: {wrong}") from None
        if not came:
            raise DeviceLost(f"the RealSense sent no frame for {timeout_s:g} s")
        return frames

    def clock_ms(self) -> float | None:
        """The camera's clock, asked over USB."""
        try:
            return self.device.get_device_time_ms()
        except RuntimeError:
            return None

    def close(self) -> None:
        """Stop streaming."""
        try:
            self._pipeline.stop()
        except RuntimeError:  # stopped already, or pulled out
            return


def open_pipeline(setup: CameraSetup) -> Pipeline:
    """Start colour (RGB8) and depth (Z16), both of `setup.size` at `setup.fps`; `Refusal` says what to do."""
    device = choose(list(rs.context().query_devices()), setup.device, named_on_usb())
    serial = device.get_info(rs.camera_info.serial_number)
    width, height = setup.size
    wanted = rs.config()
    wanted.enable_device(serial)
    wanted.enable_stream(rs.stream.color, width, height, rs.format.rgb8, setup.fps)
    wanted.enable_stream(rs.stream.depth, width, height, rs.format.z16, setup.fps)
    pipeline = rs.pipeline()
    try:
        asked_of(device, setup)
        set_up(device, setup)
        source = Pipeline(pipeline, pipeline.start(wanted))
    except RuntimeError as wrong:
        raise Refusal(why_not(str(wrong), serial)) from None
    warm_up(source, serial, 1 if setup.exposure_us else SETTLING)
    return source


def warm_up(source: Source, serial: str, frames: int) -> None:
    """Let this many frames go by; `Refusal` where a camera that started sends none."""
    try:
        for _ in range(frames):
            source.wait(FIRST_FRAME_S)
    except DeviceLost as lost:
        source.close()
        raise Refusal(f"RealSense {serial} started, but {lost}: plug it into another USB 3 port, or {UDEV}") from None


def choose(devices: list[Any], serial: str, on_usb: list[str]) -> Any:
    """The device of that serial number, or the first for ""; `on_usb` names cameras that the system sees."""
    if not devices:
        if on_usb:
            raise Refusal(f"{on_usb[0]} is plugged in, but this user may not open it: {UDEV}")
        raise Refusal("no RealSense found, expected one on a USB 3 port: check its cable, and that its light is on")
    known = [device.get_info(rs.camera_info.serial_number) for device in devices]
    if serial and serial not in known:
        raise Refusal(f"camera.device is {serial!r}, expected the serial number of a camera here: {', '.join(known)}")
    return devices[known.index(serial) if serial else 0]


def named_on_usb(folder: Path = USB_DEVICES) -> list[str]:
    """Names of the RealSense cameras that the operating system sees, whether or not they may be opened."""
    found = []
    for maker in sorted(folder.glob("*/idVendor")):
        product = maker.with_name("product")
        try:
            name = product.read_text().strip()
            if maker.read_text().strip() == MAKER and "RealSense" in name:
                found.append(name)
        except OSError:  # unplugged meanwhile, or without a name
            continue
    return found


def asked_of(device: Any, setup: CameraSetup) -> None:
    """Refuse a size and rate at which the device does not have both streams."""
    have = {rs.stream.color: set(), rs.stream.depth: set()}
    for sensor in device.query_sensors():
        for profile in sensor.get_stream_profiles():
            if profile.stream_type() in have and profile.is_video_stream_profile():
                video = profile.as_video_stream_profile()
                have[profile.stream_type()].add((video.width(), video.height(), profile.fps()))
    both = have[rs.stream.color] & have[rs.stream.depth]
    width, height = setup.size
    if (width, height, setup.fps) in both:
        return
    name = device.get_info(rs.camera_info.name)
    usb = said_by(device, rs.camera_info.usb_type_descriptor)
    slow = f" on USB {usb}; use a USB 3 port and cable, or" if usb.startswith("2") else ";"
    listed = ", ".join(f"{w}x{h} at {fps}" for w, h, fps in sorted(both, reverse=True)[:12]) or "none"
    asked = f"{width}x{height} at {setup.fps} fps"
    raise Refusal(f"{name} has no colour and depth of {asked}{slow} set camera.size and camera.fps to one of: {listed}")


def said_by(device: Any, info: Any) -> str:
    """One of the texts by which a device describes itself, "" where it does not."""
    return device.get_info(info) if device.supports(info) else ""


def why_not(message: str, serial: str) -> str:
    """One sentence for what the SDK says when streams do not start."""
    low = message.lower()
    if "busy" in low:
        return f"RealSense {serial} is in use by another program: close it (also realsense-viewer), then try again"
    if "permission" in low or "access" in low:
        return f"RealSense {serial} may not be opened by this user: {UDEV}"
    if "resolve" in low or "no device" in low:
        return f"RealSense {serial} went away while it was opened ({message}): check its cable and the port's power"
    return f"RealSense {serial} did not start ({message}): unplug it, plug it in again"
