"""The port of an emulated sensor, opened by nothing but the operating system's own calls."""

import os
import select
import termios
import time
import tty

import numpy as np
import pytest

from devices.emulated.tmf882x.faults import NO_FAULTS, Faults, damaged
from devices.emulated.tmf882x.firmware import Firmware
from devices.emulated.tmf882x.free_running import FreeRunning
from devices.emulated.tmf882x.terminal import Terminal

PATIENCE_S = 30.0
SPEED = 200


class Listener:
    """Whoever opens the port."""

    def __init__(self, link, baud=termios.B2000000):
        self.fd = os.open(link, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.fd, termios.TCSANOW)  # what was sent before stays
        shape = termios.tcgetattr(self.fd)
        shape[4] = shape[5] = baud
        termios.tcsetattr(self.fd, termios.TCSANOW, shape)
        self.heard = b""

    def until(self, ready):
        """Hear until it is enough."""
        while not ready(self.heard):
            assert select.select([self.fd], [], [], PATIENCE_S)[0], self.heard[-200:]
            data = os.read(self.fd, 65536)
            if not data:
                raise OSError("end of file")
            self.heard += data
        return self.heard

    def say(self, characters):
        os.write(self.fd, characters)


@pytest.fixture
def link(tmp_path):
    return tmp_path / "port"


def served(link, faults=NO_FAULTS, kind=Firmware):
    return Terminal(kind(None, np.random.default_rng(0)), link, speed=SPEED, faults=faults)


def reappeared(link):
    """Who opens the port as soon as it is there."""
    until = time.monotonic() + PATIENCE_S
    while True:
        try:
            return Listener(link)
        except FileNotFoundError:
            assert time.monotonic() < until


def test_commands_are_answered(link):
    with served(link) as terminal:
        listener = Listener(link)
        listener.say(b"d")
        assert listener.until(lambda heard: b"state=" in heard).endswith(b"TMF8828 state=disabled\n")
    assert not link.exists()
    assert terminal.failure is None


def test_a_reader_who_stalls_loses_nothing(link):
    """More than the buffer of the pseudo-terminal holds is printed before anything is read."""
    with served(link) as terminal:
        listener = Listener(link)
        listener.say(b"Ezm")
        listener.until(lambda heard: heard.count(b"#Obj") == 1)
        listener.say(b"h" * 50)
        listener.until(lambda heard: heard.count(b"#Obj") == 6)
        indices = [int(line.split(b",")[2]) for line in listener.heard.split(b"\n")[:-1] if line.startswith(b"#Raw")]
        assert indices[: 6 * 30] == list(range(30)) * 6
        assert listener.heard.count(b"UART commands") >= 50
    assert terminal.failure is None


def test_the_wrong_speed_is_noise(link):
    with served(link, kind=FreeRunning):
        listener = Listener(link, termios.B115200)
        # What was sent before the speed was set is no more than the terminal's buffers hold.
        heard = listener.until(lambda heard: len(heard) > 60_000)[30_000:]
        assert heard.count(b"#Raw") == 0
        assert len(set(heard)) > 200


def test_free_running_firmware_says_its_range_and_runs(link):
    with served(link, kind=FreeRunning):
        listener = Listener(link, termios.B1000000)
        lines = listener.until(lambda heard: heard.count(b"#Obj") == 3).split(b"\n")
        assert b"Active range: 6E" in lines[0]
        assert [line[:4] for line in lines[1:32]] == [b"#Raw"] * 30 + [b"#Obj"]


def test_an_unplugged_port_goes_away_and_comes_back_booted(link):
    with served(link, Faults(unplug_at=(1,), back_after_s=10.0)) as terminal:
        listener = Listener(link)
        listener.say(b"Ezm")
        with pytest.raises(OSError, match=r"Input/output error|end of file"):
            listener.until(lambda heard: heard.count(b"#Obj") == 3)
        # What nobody has read when the cable is pulled is gone.
        assert listener.heard.count(b"#Obj") <= 1
        again = reappeared(link)
        again.say(b"h")
        assert again.until(lambda heard: b"state=" in heard).endswith(b"state=disabled\n")
    assert terminal.failure is None


def test_a_pulled_cable_stays_away_until_it_is_put_back(link):
    with served(link) as terminal:
        listener = Listener(link)
        terminal.unplug()
        with pytest.raises(OSError, match=r"Input/output error|end of file"):
            listener.until(lambda heard: False)
        assert not link.exists()
        terminal.plug_in()
        reappeared(link)


def test_a_stalled_line_goes_on(link):
    with served(link, Faults(stall_at=(0, 1), stall_s=20.0)):
        listener = Listener(link)
        listener.say(b"Ezm")
        lines = listener.until(lambda heard: heard.count(b"#Obj") == 3).split(b"\n")
        assert [int(line.split(b",")[2]) for line in lines if line.startswith(b"#Raw")][:90] == list(range(30)) * 3


def test_a_failing_source_takes_the_port_away(link):
    def source(setting):
        raise RuntimeError("no scene")

    with Terminal(Firmware(source, np.random.default_rng(0)), link, speed=SPEED) as terminal:
        listener = Listener(link)
        listener.say(b"Ezm")
        with pytest.raises(OSError, match=r"Input/output error|end of file"):
            listener.until(lambda heard: b"#Obj" in heard)
    assert "no scene" in str(terminal.failure)


def test_shares_of_lines_are_lost_and_garbled():
    rng = np.random.default_rng(2)
    line = b"#Raw,65,0,1,2,3\n"
    left = [damaged(line, Faults(lose=0.2, garble=0.3), rng) for _ in range(4000)]
    assert abs(left.count(b"") - 800) < 5 * np.sqrt(800)
    garbled = [one for one in left if one not in (b"", line)]
    assert abs(len(garbled) - 1200) < 5 * np.sqrt(1200)
    assert all(sum(a != b for a, b in zip(one, line, strict=True)) == 1 for one in garbled)
