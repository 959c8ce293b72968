"""The rerun viewer of this machine or another: found where it runs, started where there is none."""

import os
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import rerun as rr
from rerun import blueprint as rrb

from recordings.refusal import Refusal

LOOPBACK = "127.0.0.1"
ADDRESS = f"rerun+http://{LOOPBACK}:9876/proxy"
PATIENCE_S, START_S, POLL_S = 2.0, 20.0, 0.1
VIEWER_MEMORY = "25%"


def shown_in_viewer(
    application: str, blueprint: rrb.Blueprint, address: str | None, instead: str
) -> rr.RecordingStream:
    """A recording that goes to the viewer at `address`, or, where that is None, to this machine's, started if need be.

    Refused in a sentence where there is no viewer at the address, or no display to start one on; `instead` says in it
    what else can be done.
    """
    wanted = ADDRESS if address is None else address
    if not listens(wanted):
        if address is not None:
            raise Refusal(f"{address}: no viewer answers there, expected one that runs, such as {ADDRESS}")
        if not has_display():
            raise Refusal(f"there is no display to show the session on; {instead}")
        _start_viewer(wanted, instead)
    recording = rr.RecordingStream(application)
    recording.connect_grpc(wanted, default_blueprint=blueprint)
    return recording


def _start_viewer(address: str, instead: str) -> None:
    """Start the viewer, which outlives this process, and wait until it listens."""
    # Beside the interpreter, too: a virtual environment need not be active.
    beside = Path(sys.executable).with_name("rerun")
    program = str(beside) if beside.exists() else shutil.which("rerun")
    if program is None:
        raise Refusal(f"the viewer `rerun` is not installed; {instead}")
    place = urlsplit(address)
    # Left to itself the viewer listens to the whole network.
    options = ["--bind", LOOPBACK, "--port", str(place.port), "--memory-limit", VIEWER_MEMORY, "--hide-welcome-screen"]
    silent = subprocess.DEVNULL
    viewer = subprocess.Popen([program, *options], stdin=silent, stdout=silent, stderr=silent, start_new_session=True)
    for _ in range(int(START_S / POLL_S)):
        if listens(address):
            return
        if viewer.poll() is not None:
            break
        time.sleep(POLL_S)
    raise Refusal(f"the viewer cannot be started on this display; {instead}")


def has_display() -> bool:
    """Whether a window can be opened here."""
    return not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def listens(address: str) -> bool:
    """Whether anybody answers at an address such as `ADDRESS`."""
    try:
        place = urlsplit(address)
        with socket.create_connection((place.hostname or "", place.port or 9876), PATIENCE_S):
            return bool(place.hostname)
    except (OSError, ValueError):
        return False
