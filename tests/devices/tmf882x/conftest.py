"""An emulated sensor at a port, many times as fast as a real one."""

from contextlib import ExitStack

import numpy as np
import pytest

from calibrate.rig import LidarSetup
from devices.emulated.tmf882x.faults import NO_FAULTS
from devices.emulated.tmf882x.firmware import Firmware
from devices.emulated.tmf882x.terminal import Terminal

SPEED = 200


class Port:
    """A port that sensors can be plugged into, one after another."""

    def __init__(self, link, stack):
        self.name = str(link)
        self._stack = stack

    def plug(self, firmware=None, *, source=None, faults=NO_FAULTS, speed=SPEED):
        firmware = Firmware(source, np.random.default_rng(0)) if firmware is None else firmware
        return self._stack.enter_context(Terminal(firmware, self.name, speed=speed, faults=faults))

    def setup(self, **values):
        return LidarSetup(port=self.name, **values)


@pytest.fixture
def port(tmp_path):
    with ExitStack() as stack:
        yield Port(tmp_path / "port", stack)
