"""Pictures over a Unix-domain socket, from the process that plays the scene to the one that drives the camera.

A request is one message, b"hello" or b"look". The answer begins with four letters: SAID and JSON says what the camera
is, SEEN and bytes is a picture (rgb (H, W, 3) uint8, then depth (H, W) little-endian uint16 millimetres where there is
one), LOST and a sentence says that the camera is lost.
"""

import contextlib
import json
import os
import socket
import stat
import threading
from collections.abc import Callable
from multiprocessing.connection import Client, Connection, Listener
from typing import Any

import numpy as np

from devices.captures import DeviceLost
from recordings.refusal import Refusal

Look = Callable[[], tuple[np.ndarray, np.ndarray | None]]
SAID, SEEN, LOST = b"SAID", b"SEEN", b"LOST"
MM = 1e3
MOST_MM = 65535


class PictureServer:
    """Answers at `address` with what `look` sees, several clients at a time, until it is closed.

    Whatever `look` raises is told to the client as a lost camera: `DeviceLost` with its words.
    """

    def __init__(self, address: str, look: Look, said: dict[str, Any]) -> None:
        self._address, self._look, self._said = address, look, said
        _free(address)
        self._listener = Listener(address, family="AF_UNIX")
        os.chmod(address, 0o600)
        self._open: set[Connection] = set()
        self._closing = False
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def __enter__(self) -> "PictureServer":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close every connection and remove the socket."""
        if self._closing:
            return
        self._closing = True
        with contextlib.suppress(OSError, EOFError):
            Client(self._address, family="AF_UNIX").close()  # wakes up the thread that accepts
        self._thread.join()
        self._listener.close()
        for connection in list(self._open):
            _shut(connection)

    def _serve(self) -> None:
        while True:
            try:
                connection = self._listener.accept()
            except OSError:  # a client that went away before it was let in
                continue
            if self._closing:
                connection.close()
                return
            self._open.add(connection)
            threading.Thread(target=self._answer, args=(connection,), daemon=True).start()

    def _answer(self, connection: Connection) -> None:
        with contextlib.suppress(OSError, EOFError), connection:
            while True:
                asked = connection.recv_bytes(16)
                connection.send_bytes(SAID + json.dumps(self._said).encode() if asked == b"hello" else self._seen())
        self._open.discard(connection)

    def _seen(self) -> bytes:
        try:
            rgb, depth_m = self._look()
            parts = [SEEN, np.ascontiguousarray(rgb, np.uint8)]
            if self._said["depth"]:
                parts.append(np.ascontiguousarray(counts(depth_m)))
            return b"".join(parts)
        except Exception as wrong:  # whatever breaks in the scene, its client must hear of it
            return LOST + (str(wrong) or type(wrong).__name__).encode()


def serve_pictures(
    address: str,
    look: Look,
    size: tuple[int, int],
    *,
    intrinsics: tuple[float, ...] = (),
    depth: bool = True,
    speed: float = 1.0,
) -> PictureServer:
    """Begin to answer at the socket `address` (a path) with what `look()` returns.

    look: () -> rgb (H, W, 3) uint8, depth (H, W) metres (NaN where unknown), uint16 millimetres, or None. size: width,
    height. intrinsics: fx, fy, cx, cy, pixels. depth: False spares its cost where look gives none. speed: the camera's
    clock runs so many times faster than the host's.
    """
    said = {"size": list(size), "intrinsics": list(intrinsics), "depth": depth, "speed": speed}
    return PictureServer(address, look, said)


def millimetres(depth_m: np.ndarray | None) -> np.ndarray:
    """(H, W) metres as the depth sensor's uint16 counts, 0 where unknown, not above 0 or too far."""
    if depth_m is None:
        raise ValueError("the scene gives no depth, expected one: serve its pictures with depth=False")
    with np.errstate(over="ignore"):
        mm = np.multiply(depth_m, np.float32(MM), dtype=np.float32) + np.float32(0.5)
    np.putmask(mm, ~((mm >= 0) & (mm < MOST_MM + 1)), 0)  # also where it is NaN
    return mm.astype("<u2")


def counts(depth: np.ndarray | None) -> np.ndarray:
    """(H, W) uint16 counts as they are, or out of metres."""
    return depth if depth is not None and depth.dtype == np.uint16 else millimetres(depth)


class PictureClient:
    """The other end; said: what the server told of its camera."""

    def __init__(self, address: str, timeout_s: float = 5.0) -> None:
        self._timeout_s = timeout_s
        try:
            self._connection = Client(address, family="AF_UNIX")
        except (OSError, EOFError, ValueError) as wrong:
            at = f"camera.device {address!r} ({wrong})"
            raise Refusal(f"no rehearsal answers at {at}: start `difflidar rehearse`") from None
        self.said = json.loads(bytes(self._ask(b"hello")))
        self._width, self._height = self.said["size"]

    def look(self) -> tuple[np.ndarray, np.ndarray | None]:
        """rgb (H, W, 3) uint8, and depth (H, W) uint16 millimetres or None; raises `DeviceLost`."""
        pixels = self._width * self._height
        seen = self._ask(b"look")
        expected = pixels * (5 if self.said["depth"] else 3)
        if len(seen) != expected:
            raise DeviceLost(f"the rehearsal sent a picture of {len(seen)} bytes, expected {expected}")
        rgb = np.frombuffer(seen, np.uint8, 3 * pixels).reshape(self._height, self._width, 3)
        if not self.said["depth"]:
            return rgb, None
        return rgb, np.frombuffer(seen, "<u2", pixels, 3 * pixels).reshape(self._height, self._width)

    def close(self) -> None:
        """Hang up."""
        self._connection.close()

    def _ask(self, what: bytes) -> memoryview:
        try:
            self._connection.send_bytes(what)
            if not self._connection.poll(self._timeout_s):
                raise DeviceLost(f"the rehearsal's camera sent nothing for {self._timeout_s:g} s")
            answer = self._connection.recv_bytes()
        except (OSError, EOFError) as wrong:
            raise DeviceLost(f"the rehearsal's camera went away ({wrong or type(wrong).__name__})") from None
        if answer[:4] == LOST:
            raise DeviceLost(answer[4:].decode(errors="replace"))
        return memoryview(answer)[4:]


def _free(address: str) -> None:
    """Remove the socket that a killed rehearsal left; anything else at its place is not ours to remove."""
    if not os.path.lexists(address):
        return
    if not stat.S_ISSOCK(os.lstat(address).st_mode):
        raise Refusal(f"{address} is a file, expected no file where the camera's socket is to be")
    with contextlib.suppress(ConnectionRefusedError):
        Client(address, family="AF_UNIX").close()
        raise Refusal(f"{address} is in use by another rehearsal: end it, or choose another place")
    os.unlink(address)


def _shut(connection: Connection) -> None:
    """Close a connection under a thread that reads from it, which plain closing would not wake."""
    with contextlib.suppress(OSError), socket.socket(fileno=os.dup(connection.fileno())) as line:
        line.shutdown(socket.SHUT_RDWR)
