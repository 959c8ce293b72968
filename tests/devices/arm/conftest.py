import os
from contextlib import contextmanager
from itertools import count

import pytest

from devices.arm import link
from devices.emulated.ur.arm import EmulatedController
from recordings.refusal import Refusal

_TRIED = count(1)


def started(**settings) -> EmulatedController:
    """An emulated controller at some free address of this machine; each process of the tests looks elsewhere."""
    while True:
        number = next(_TRIED)
        host = f"127.{64 + os.getpid() % 128}.{os.getpid() // 128 % 256}.{number}"
        try:
            return EmulatedController(host, **settings).start()
        except Refusal:
            if number > 100:
                raise


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    """Nobody here is dead, only slow: a busy machine keeps a process waiting for seconds."""
    for name, seconds in {"ANSWERS_S": 12.0, "CONNECTS_S": 60.0, "SILENT_S": 6.0}.items():
        monkeypatch.setattr(link, name, seconds)


@pytest.fixture
def impatient(monkeypatch):
    """A context in which whoever is lost is given up soon."""

    @contextmanager
    def context():
        with monkeypatch.context() as patched:
            patched.setattr(link, "ANSWERS_S", 0.5)
            yield

    return context


@pytest.fixture(scope="module")
def controller_of_module():
    controller = started(speed=50)
    yield controller
    controller.close()


@pytest.fixture
def controller(controller_of_module):
    """An emulated UR10 at fifty times the speed, as if it had been switched on just now."""
    controller_of_module.interrupt("restart")
    return controller_of_module


@pytest.fixture
def e_series():
    """An emulated UR5e."""
    controller = started(model="UR5e", speed=50)
    yield controller
    controller.close()
