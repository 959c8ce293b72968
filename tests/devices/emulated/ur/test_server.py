import os
import socket
import struct

import numpy as np
import pytest

from devices.arm.kinematics import forward, links, pose_of
from devices.emulated.ur.arm import START_JOINTS, EmulatedController
from recordings.refusal import Refusal

HOST = f"127.{200 + os.getpid() % 50}.{os.getpid() // 50 % 256}.9"


@pytest.fixture(scope="module")
def controller():
    with EmulatedController(HOST, speed=50) as controller:
        yield controller


class Client:
    """Real-time data by hand, as the guide spells it."""

    def __init__(self, *names):
        self.line = socket.create_connection((HOST, 30004), timeout=30)
        self.names = ",".join(names).encode()

    def send(self, kind, payload=b""):
        self.line.sendall(struct.pack(">HB", 3 + len(payload), ord(kind)) + payload)

    def read(self):
        size, kind = struct.unpack(">HB", self.exactly(3))
        return chr(kind), self.exactly(size - 3)

    def exactly(self, count):
        got = b""
        while len(got) < count:
            read = self.line.recv(count - len(got))
            if not read:
                raise EOFError
            got += read
        return got

    def asked(self, kind, payload=b""):
        self.send(kind, payload)
        return self.read()

    def started(self, hertz=125.0):
        self.asked("O", struct.pack(">d", hertz) + self.names)
        assert self.asked("S") == ("S", b"\1")
        return self


def test_hands_are_shaken_as_the_guide_says(controller):
    client = Client()
    assert client.asked("V", b"\0\2") == ("V", b"\1")
    assert client.asked("V", b"\0\1") == ("V", b"\0")
    assert client.asked("v") == ("v", struct.pack(">4I", 3, 15, 8, 106339))
    assert client.asked("O", struct.pack(">d", 125) + b"timestamp,actual_q,") == ("O", b"\1DOUBLE,VECTOR6D")
    assert client.asked("I", b"input_int_register_0,") == ("I", b"\1INT32")
    assert client.asked("I", b"input_double_register_3") == ("I", b"\2DOUBLE")
    assert client.asked("P") == ("P", b"\1")


def test_nothing_is_streamed_that_was_not_found(controller):
    client = Client()
    assert client.asked("O", struct.pack(">d", 125) + b"timestamp,phase_of_moon") == ("O", b"\0DOUBLE,NOT_FOUND")
    assert client.asked("S") == ("S", b"\0")


def test_several_clients_see_the_same_arm(controller):
    clients = [Client("timestamp", "actual_q", "actual_TCP_pose", "runtime_state").started() for _ in range(3)]
    for client in clients:
        stamps = []
        for _ in range(4):
            kind, payload = client.read()
            assert (kind, payload[0]) == ("U", 1)
            stamp, *values, runtime = struct.unpack(">d6d6dI", payload[1:])
            stamps.append(stamp)
        assert stamps == sorted(stamps)
        np.testing.assert_allclose(values[:6], START_JOINTS)
        np.testing.assert_allclose(values[6:], pose_of(forward(links("UR10"), np.array(START_JOINTS))), atol=1e-12)
        assert runtime == 1
    np.testing.assert_allclose(controller.joints, START_JOINTS)


@pytest.mark.parametrize("nonsense", [b"\0\0\0\0", b"GET / HTTP/1.1\r\n\r\n", b"\0\4U\7", b"\0\3?"])
def test_who_speaks_nonsense_is_let_go_and_nobody_else(controller, nonsense):
    good, bad = Client("timestamp").started(), Client()
    bad.line.sendall(nonsense)
    with pytest.raises((EOFError, ConnectionError)):
        bad.read()
    assert good.read()[0] == "U"


def test_the_dashboard_greets_and_answers_line_by_line(controller):
    with socket.create_connection((HOST, 29999), timeout=30) as line, line.makefile("rwb") as text:
        assert text.readline().startswith(b"Connected: Universal Robots Dashboard Server")
        text.write(b"robotmode\nsafetystatus\n")
        text.flush()
        assert text.readline() == b"Robotmode: RUNNING\n"
        assert text.readline() == b"Safetystatus: NORMAL\n"


def test_ports_that_are_taken_are_refused(controller):
    with pytest.raises(Refusal, match=rf"{HOST}:30004 cannot be served \(Address already in use\)"):
        EmulatedController(HOST).start()


def test_an_arm_nobody_has_is_refused():
    with pytest.raises(Refusal, match=r"arm\.model is 'R2D2'"):
        EmulatedController(HOST, model="R2D2").start()


def test_what_cannot_be_brought_about_is_said(controller):
    with pytest.raises(ValueError, match="'earthquake', expected one of"):
        controller.interrupt("earthquake")
