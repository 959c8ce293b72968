"""Bad luck with ports and firmware: one sentence each, that says what to do."""

import errno

import numpy as np
import pytest
import serial

from calibrate.rig import LidarSetup
from devices.emulated.tmf882x.chip import Chip
from devices.emulated.tmf882x.firmware import Firmware
from devices.emulated.tmf882x.free_running import FreeRunning
from devices.tmf882x import connection, identify
from devices.tmf882x.driver import open_tmf882x
from recordings.refusal import Refusal


def refused(setup, **more):
    with pytest.raises(Refusal) as no:
        open_tmf882x(setup, **more)
    sentence = str(no.value)
    assert "\n" not in sentence
    return sentence


@pytest.fixture
def impatient(monkeypatch):
    """Who waits less long for an answer than a board needs that resets."""
    monkeypatch.setattr(connection, "ANSWER_S", 1.5)


def test_no_port():
    assert "no USB serial port is there: plug" in refused(LidarSetup(), find=list)


def test_a_port_that_is_not_there(port):
    assert "is not there, plug the sensor's board in" in refused(port.setup())


@pytest.mark.parametrize(
    ("number", "said"),
    [(errno.EACCES, "usermod -aG dialout"), (errno.EBUSY, "another program has it"), (errno.EIO, "is no serial port")],
)
def test_a_port_that_does_not_open(port, monkeypatch, number, said):
    def fail(*_, **__):
        raise serial.SerialException(number, "could not open port")

    monkeypatch.setattr(serial, "Serial", fail)
    assert said in refused(port.setup())


def test_a_file_is_no_port(port, tmp_path):
    (tmp_path / "port").write_text("")
    assert "is no serial port that works" in refused(port.setup())


def test_a_port_that_another_program_has(port):
    port.plug()
    with open_tmf882x(port.setup()):
        assert "another program has it; close that one" in refused(port.setup())


def test_a_speed_that_does_not_exist(port):
    port.plug()
    assert "lidar.baud" in refused(port.setup(baud=2**40))


def test_silence(port, impatient):
    class Mute(Firmware):
        next_due = None

        def take(self, now):
            return []

    port.plug(Mute(None, np.random.default_rng(0)))
    assert "nothing answers at 2000000 baud" in refused(port.setup())


def test_the_wrong_speed(port, impatient):
    port.plug(FreeRunning(None, np.random.default_rng(0)))
    assert "noise comes at 115200 baud" in refused(port.setup(baud=115200))


class Echo(Firmware):
    """Something else that talks."""

    answer = "ok"

    def _obey(self, now):
        while self._typed:
            self._typed.popleft()
            self._busy_until = now
            self.say([self.answer])


def test_other_firmware(port, impatient):
    port.plug(Echo(None, np.random.default_rng(0)))
    assert "prints text but no TMF882x" in refused(port.setup())


def test_firmware_that_has_the_states_but_no_help(port, monkeypatch):
    monkeypatch.setattr(identify, "PATIENCE_S", 0.3)

    class Similar(Echo):
        answer = "TMF8828 state=stopped"

    port.plug(Similar(None, np.random.default_rng(0)))
    assert "is not the ams Arduino driver" in refused(port.setup())


@pytest.mark.parametrize(
    ("asked", "offered"),
    [
        ({"mode": "3x6"}, "3x3 of 10000 kilo-iterations and 4x4 of 2500"),
        ({"kilo_iterations": 550}, "3x3 of 10000 kilo-iterations and 4x4 of 2500"),
        ({"mode": "8x8", "kilo_iterations": 125}, "8x8 of 10 kilo-iterations and 8x8 of 2500"),
    ],
)
def test_what_the_firmware_cannot_be_set_to(port, asked, offered):
    port.plug()
    assert offered in refused(port.setup(**asked))


def test_next_configuration_is_asked_for_once(port):
    """The reference firmware reads past the end of its table the second time."""
    typed = []

    class Watched(Firmware):
        def write(self, data, now):
            typed.append(data)
            super().write(data, now)

    port.plug(Watched(None, np.random.default_rng(0)))
    refused(port.setup(kilo_iterations=550))
    said = b"".join(typed)
    assert max(part.count(b"c") for part in said.replace(b"e", b"E").split(b"E")) == 1


def test_a_smaller_sensor_has_no_8x8(port):
    port.plug(Firmware(None, np.random.default_rng(0), Chip(has_8x8=False)))
    assert "this sensor has no 8 x 8 zones" in refused(port.setup(mode="8x8"))


def test_free_running_firmware_is_as_it_is(port, monkeypatch):
    monkeypatch.setattr(connection, "SPARE_S", 0.1)
    monkeypatch.setattr(connection, "MORE", 1)
    monkeypatch.setattr(identify, "FREE_AFTER_S", 0.1)
    port.plug(FreeRunning(None, np.random.default_rng(0)))
    setup = {"baud": 1_000_000, "ranging": "short"}
    assert "no whole measurement of that mode" in refused(port.setup(mode="4x4", kilo_iterations=1, **setup))
    assert "can load none" in refused(port.setup(factory_calibration="page.c", **setup))
    with open_tmf882x(port.setup(**setup)) as lidar, pytest.raises(Refusal, match="takes no commands"):
        lidar.calibrate_factory()


def test_ports_are_tried_until_one_answers(port, tmp_path, impatient):
    (tmp_path / "other").write_text("")
    port.plug()
    setup = LidarSetup()
    with open_tmf882x(setup, find=lambda: [str(tmp_path / "other"), port.name]) as lidar:
        assert lidar.said["port"] == port.name
    sentence = refused(setup, find=lambda: [str(tmp_path / "other"), str(tmp_path / "third")])
    assert "none of the 2 USB serial ports has the LiDAR" in sentence


class Talkative(FreeRunning):
    """Says its range mode before every measurement."""

    def take(self, now):
        out = super().take(now)
        return [part for line in out for part in ([b"Active range: 6E\n"] * line.startswith(b"#Raw,65,0,") + [line])]


def test_free_running_firmware_in_the_other_range(port):
    port.plug(Talkative(None, np.random.default_rng(0)))
    assert "runs in short range and takes no commands" in refused(port.setup(baud=1_000_000, ranging="long"))
    with open_tmf882x(port.setup(baud=1_000_000, ranging="short")) as lidar:
        assert lidar.said["ranging_is"] == "said by the firmware"
