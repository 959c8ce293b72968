"""Connections to an emulated controller: real-time data, dashboard and scripts."""

import socket
import struct
from collections.abc import Callable, Mapping, Sequence

from devices.emulated.ur import packets
from devices.emulated.ur.controller import Controller
from devices.emulated.ur.dashboard import GREETING, answer

MOST_BYTES = 1 << 20


class Client:
    """One connection, of a loop that calls `readable` when something came and `tick` each cycle of the controller."""

    def __init__(self, controller: Controller, connection: socket.socket, left: Callable[["Client"], None]) -> None:
        self.controller, self.connection, self.buffer = controller, connection, bytearray()
        self._left, self._open = left, True
        self.welcome()

    def readable(self) -> None:
        """Take what came; a client that speaks nonsense is let go, as the real controller does."""
        try:
            read = self.connection.recv(1 << 16)
            if not read or len(self.buffer) > MOST_BYTES:
                raise ConnectionError
            self.buffer += read
            self.take()
        except BlockingIOError:
            return
        except (OSError, ValueError, LookupError, struct.error):
            self.close()

    def send(self, data: bytes) -> None:
        """All of it at once; who has not read for so long that buffers are full is let go."""
        try:
            if self._open and self.connection.send(data) < len(data):
                self.close()
        except OSError:
            self.close()

    def close(self) -> None:
        """Hang up."""
        if self._open:
            self._open = False
            self._left(self)

    def welcome(self) -> None:
        """Say what is said before anything is asked."""

    def take(self) -> None:
        """Use what is in the buffer, as far as it is whole."""
        self.buffer.clear()

    def tick(self, values: Mapping[str, Sequence[float]]) -> None:
        """A cycle of the controller has passed, the variables are now these."""


class RtdeClient(Client):
    """Reads variables and writes registers."""

    def welcome(self) -> None:
        """Nothing is streamed before it is asked for."""
        self._outputs: packets.Recipe | None = None
        self._inputs: dict[int, packets.Recipe] = {}
        self._every_s, self._due_s, self._started = 0.0, 0.0, False

    def take(self) -> None:
        """Answer each packet."""
        for kind, payload in packets.whole(self.buffer):
            if kind == packets.DATA:
                self.controller.write_registers(self._inputs[payload[0]].unpack(payload[1:]))
            else:
                self.send(packets.packet(kind, self._answer(kind, payload)))

    def _answer(self, kind: bytes, payload: bytes) -> bytes:
        if kind == packets.REQUEST_VERSION:
            return bytes([payload == b"\0\2"])
        if kind == packets.CONTROLLER_VERSION:
            return packets.VERSION.pack(*self.controller.version)
        if kind == packets.SET_OUTPUTS:
            hertz, names = packets.HERTZ.unpack_from(payload)[0], payload[packets.HERTZ.size :]
            self._every_s = 1 / min(max(hertz, 1.0), self.controller.hertz)
            self._outputs = packets.recipe(1, names)
            return bytes([self._outputs.known]) + ",".join(self._outputs.types).encode()
        if kind == packets.SET_INPUTS:
            asked = packets.recipe(len(self._inputs) + 1, payload)
            self._inputs[asked.number] = asked
            return bytes([asked.number]) + ",".join(asked.types).encode()
        if kind in (packets.START, packets.PAUSE):
            self._started = kind == packets.START and self._outputs is not None and self._outputs.known
            return bytes([self._started or kind == packets.PAUSE])
        raise ValueError(f"a packet of kind {kind!r}")

    def tick(self, values: Mapping[str, Sequence[float]]) -> None:
        """Stream, as often as was asked for and whenever a register changed."""
        now = values["timestamp"][0]
        if self._started and (now >= self._due_s or values["stirred"][0]):
            # Half a cycle early is on time.
            self._due_s = now + self._every_s - 0.5 / self.controller.hertz
            self.send(self._outputs.pack(values))


class DashboardClient(Client):
    """Lines of text, each answered by one."""

    def welcome(self) -> None:
        """A greeting comes first."""
        self.send(GREETING)

    def take(self) -> None:
        """Answer each line."""
        while b"\n" in self.buffer:
            line, _, rest = self.buffer.partition(b"\n")
            self.buffer = rest
            self.send(answer(self.controller, line.decode("utf-8", "replace").strip()).encode() + b"\n")


class ScriptClient(Client):
    """Programs; each ends in a line that says so. What a program says is not read: it is taken for ur_rtde's."""

    def take(self) -> None:
        """Run each whole program."""
        while (end := self.buffer.find(b"\nend\n")) >= 0:
            script = bytes(self.buffer[: end + 5])
            del self.buffer[: end + 5]
            self.controller.run_script(script)
