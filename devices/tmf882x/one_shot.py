"""One measurement of a sensor that takes commands, known to be over before it is read out.

In modes of one burst the sensor sends nothing until it has integrated: at the first line of a measurement whoever waits
for it may move on, while the lines come.
"""

import time

from devices.captures import DeviceLost
from devices.tmf882x.connection import Connection
from devices.tmf882x.dialogue import ask
from recordings.importers.tmf882x.assemble import Assembled
from recordings.importers.tmf882x.layout import LAYOUTS


def is_single(link: Connection, mode: str) -> bool:
    """Whether a measurement's first line says that it was taken."""
    return link.started is not None and LAYOUTS[mode].bursts == 1


def await_integrated(link: Connection) -> None:
    """Wait for the first line since measuring began; raises `DeviceLost` where none comes."""
    if not link.reader.next_data(time.monotonic() + link.silence_s):
        raise DeviceLost(f"nothing came from the LiDAR for {link.silence_s:.1f} s")


def read_out(link: Connection) -> Assembled | None:
    """The measurement whose lines come, None where it is not whole; the sensor is at rest then."""
    frame = link.reader.first_frame(link.silence_s)
    ask(link.reader, "s", state="stopped")
    return frame
