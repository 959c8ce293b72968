"""From a port to a sensor that can measure: opened, recognised, set up."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from calibrate.rig import LidarSetup
from devices.captures import DeviceLost
from devices.tmf882x.identify import COMMANDS, identify
from devices.tmf882x.port import candidates, open_port, usb_ports
from devices.tmf882x.reader import Reader
from devices.tmf882x.settings import measurement_s
from devices.tmf882x.start import Started, start
from recordings.importers.tmf882x.assemble import Assembler
from recordings.refusal import Refusal

ANSWER_S = 6.0
# Of firmware that does not say what it is set to, the longest measurement is expected that any takes. One is begun.
MOST_KILO_ITERATIONS = 10_000
MORE = 2
# Beyond what a measurement should take.
SPARE_S = 2.0


@dataclass(frozen=True)
class Connection:
    """An open port with a sensor that is set up. started: None where the firmware takes no commands.

    ranging: None where it is not known. silence_s: for how long nothing may come while it measures.
    assembler: makes the reader's measurements.
    """

    port: str
    reader: Reader
    assembler: Assembler
    firmware: str
    started: Started | None
    ranging: str | None
    silence_s: float

    def same(self) -> dict[str, Any]:
        """What must be as before where a sensor comes back."""
        return {"firmware": self.firmware} | ({} if self.started is None else self.started.same())


def connect(
    setup: LidarSetup, assembler: Assembler | None = None, find: Callable[[], list[str]] = usb_ports
) -> Connection:
    """The sensor at the port of `setup`, or at the first that answers; `Refusal` says what is wrong.

    assembler: of a connection that was lost, which goes on to count.
    """
    ports = candidates(setup.port, find)
    refused: list[str] = []
    for port in ports:
        try:
            return _connect(port, setup, assembler)
        except (Refusal, DeviceLost) as no:
            if len(ports) == 1:
                raise
            refused.append(str(no))
    raise Refusal(f"none of the {len(ports)} USB serial ports has the LiDAR: {'; '.join(refused)}")


def _connect(port: str, setup: LidarSetup, assembler: Assembler | None) -> Connection:
    reader = Reader(open_port(port, setup.baud))
    try:
        firmware, ranging = identify(reader, port, setup.baud, ANSWER_S)
        if firmware != COMMANDS:
            return _listen(port, reader, setup, assembler, firmware, ranging)
        started = start(reader, setup)
        kilo = started.setting.kilo_iterations
        assembler = _assemble(reader, assembler, setup.mode, kilo)
        silence_s = 2 * measurement_s(setup.mode, kilo, started.setting.period_ms) + SPARE_S
        return Connection(port, reader, assembler, firmware, started, started.ranging, silence_s)
    except BaseException:
        reader.close()
        raise


def _assemble(reader: Reader, assembler: Assembler | None, mode: str, kilo_iterations: int | None) -> Assembler:
    """Have the reader make measurements; as before, if there was a connection before."""
    if assembler is None:
        assembler = Assembler(mode, kilo_iterations)
    assembler.reset()
    reader.assemble(assembler)
    return assembler


def _listen(
    port: str, reader: Reader, setup: LidarSetup, assembler: Assembler | None, firmware: str, ranging: str | None
) -> Connection:
    """Firmware that takes no commands is as it is: that must be what was asked for."""
    if ranging not in (None, setup.ranging):
        raise Refusal(
            f"lidar.ranging is {setup.ranging!r}, but the firmware at {port} runs in {ranging} range and takes no "
            f"commands; set lidar.ranging to {ranging!r}, or load the reference firmware onto the board"
        )
    if setup.factory_calibration:
        raise Refusal(
            f"lidar.factory_calibration is {setup.factory_calibration}, but the firmware at {port} takes no commands "
            "and can load none; leave it empty, or load the reference firmware onto the board"
        )
    assembler = _assemble(reader, assembler, setup.mode, setup.kilo_iterations or None)
    silence_s = 2 * measurement_s(setup.mode, setup.kilo_iterations or MOST_KILO_ITERATIONS, 0) + SPARE_S
    first = reader.next_frame(time.monotonic() + MORE * silence_s)
    if first is None or isinstance(first, str):
        reasons = ", ".join(f"{count} x {why}" for why, count in assembler.tally.reasons.most_common(3)) or "none came"
        raise Refusal(
            f"lidar.mode is {setup.mode!r}, but no whole measurement of that mode came from the firmware at {port}, "
            f"which takes no commands ({reasons}); set lidar.mode to the mode it measures in"
        )
    return Connection(port, reader, assembler, firmware, None, ranging, silence_s)
