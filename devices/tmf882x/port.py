"""The serial port: which it could be, and what is wrong where it does not open."""

import errno
from collections.abc import Callable

import serial
from serial.tools import list_ports

from recordings.refusal import Refusal

# Reads return at least so often, so that a reader can be told to end.
READ_TIMEOUT_S = 0.2
WRITE_TIMEOUT_S = 2.0


def usb_ports() -> list[str]:
    """Serial ports that are on USB, as all boards that carry this sensor are; others are never written to."""
    return sorted(port.device for port in list_ports.comports() if port.vid is not None)


def candidates(port: str, find: Callable[[], list[str]] = usb_ports) -> list[str]:
    """The port that was named, or all that could be it; `Refusal` if there is none."""
    found = [port] if port else find()
    if not found:
        raise Refusal(
            "lidar.port is empty and no USB serial port is there: plug the sensor's board in, with a cable that "
            "carries data, or name its port"
        )
    return found


def open_port(port: str, baud: int) -> serial.Serial:
    """The port, for this program alone; `Refusal` says why it does not open and what to do about it."""
    try:
        return serial.Serial(port, baud, timeout=READ_TIMEOUT_S, write_timeout=WRITE_TIMEOUT_S, exclusive=True)
    except (OSError, ValueError, OverflowError) as failure:
        raise Refusal(f"lidar.port {port}: {_why(failure, baud)}") from failure


def _why(failure: Exception, baud: int) -> str:
    number = getattr(failure, "errno", None)
    if number in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
        there = ", ".join(usb_ports()) or "none"
        return f"is not there, plug the sensor's board in or name another port; USB serial ports now: {there}"
    if number in (errno.EACCES, errno.EPERM):
        return (
            "no permission to open it; add yourself to the group that owns it (sudo usermod -aG dialout $USER, then "
            "log in anew) or give the board a udev rule"
        )
    if number in (errno.EBUSY, errno.EAGAIN):
        return "another program has it; close that one (a serial monitor, another scan, ModemManager)"
    if isinstance(failure, ValueError | OverflowError) and not isinstance(failure, OSError):
        return f"does not run at {baud} baud; correct lidar.baud"
    return f"is no serial port that works ({failure}); name the port of the sensor's board"
