"""Serves an emulated controller on the ports where clients look for a real one."""

import json
import os
import selectors
import socket
import time

from devices.emulated.ur.clients import Client, DashboardClient, RtdeClient, ScriptClient
from devices.emulated.ur.controller import Controller
from devices.emulated.ur.safety import HUNG_UP, PLUGGED, SILENT
from recordings.refusal import Refusal

SERVED = {30004: RtdeClient, 29999: DashboardClient, 30003: ScriptClient}
# Packets go out no more often than this, however fast the controller's clock runs.
SHORTEST_TICK_S = 0.002


class Server:
    """Serves a controller at an address of this machine until its operator leaves.

    speed: how many times faster than real the controller's clock runs. The operator writes lines to one descriptor and
    reads a line of JSON for each on the other: "state", what `Safety.interrupt` can bring about, or
    "at 3 protective", for a stop during the third move from now.
    Raises `Refusal` where the ports are taken; the clients fix them, so each controller needs an address of its own.
    """

    def __init__(self, controller: Controller, host: str, speed: float) -> None:
        self.controller = controller
        self._tick_s = max(SHORTEST_TICK_S, 1 / (controller.hertz * speed))
        self._selector = selectors.DefaultSelector()
        self._clients: set[Client] = set()
        for port, kind in SERVED.items():
            listener = socket.socket()
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._selector.register(listener, selectors.EVENT_READ, kind)
            try:
                listener.bind((host, port))
            except OSError as error:
                raise Refusal(
                    f"emulated arm: {host}:{port} cannot be served ({error.strerror}), expected an address of this "
                    "machine whose ports nobody else serves, such as 127.0.0.2"
                ) from None
            listener.listen()
            listener.setblocking(False)

    def serve(self, orders: int, answers: int) -> None:
        """Serve until the operator hangs up."""
        self._selector.register(orders, selectors.EVENT_READ, None)
        heard, due = b"", time.monotonic()
        while True:
            for key, _ in self._selector.select(max(due - time.monotonic(), 0)):
                if key.data is not None and self.controller.line == SILENT:
                    # What was sent waits on the line; so does this, lest it spin.
                    time.sleep(self._tick_s)
                    continue
                if isinstance(key.data, Client):
                    key.data.readable()
                elif key.data is not None:
                    self._welcome(key.fileobj, key.data)
                elif read := os.read(orders, 4096):
                    *lines, heard = (heard + read).split(b"\n")
                    for line in lines:
                        os.write(answers, json.dumps(self._order(line.decode().strip())).encode() + b"\n")
                else:
                    return
            # A register that changed goes out at once: at many times the speed a tick would be a long time.
            if self.controller.stirred or time.monotonic() >= due:
                due = time.monotonic() + self._tick_s
                values = self.controller.values()
                self.controller.stirred = False
                for client in tuple(self._clients):
                    if self.controller.line == PLUGGED:
                        client.tick(values)
                    elif self.controller.line == HUNG_UP:
                        client.close()

    def _order(self, line: str) -> dict:
        if line == "state":
            self.controller.advance()
            joints, speeds = self.controller.joints_now()
            return {
                "joints": joints.tolist(),
                "pose": self.controller.pose_now().tolist(),
                "moving": bool(speeds.any()),
                "moves": self.controller.moves,
                "playing": self.controller.playing,
                "safety_mode": self.controller.safety_mode,
            }
        at, _, kind = line.removeprefix("at ").partition(" ")
        try:
            if line.startswith("at "):
                self.controller.stops[self.controller.moves + int(at)] = kind
            else:
                self.controller.interrupt(line)
                if line == "restart":
                    for client in tuple(self._clients):
                        client.close()
        except ValueError as error:
            return {"error": str(error)}
        return {}

    def _welcome(self, listener: socket.socket, kind: type[Client]) -> None:
        try:
            connection, _ = listener.accept()
        except OSError:
            return  # Who knocked has left again.
        if self.controller.line == HUNG_UP:
            connection.close()
            return
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client = kind(self.controller, connection, self._forget)
        self._clients.add(client)
        self._selector.register(connection, selectors.EVENT_READ, client)

    def _forget(self, client: Client) -> None:
        self._clients.discard(client)
        self._selector.unregister(client.connection)
        client.connection.close()
