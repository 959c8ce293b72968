"""`python -m devices.emulated.ur`: an arm's controller that is not there."""

import json
import os
import sys
import time

import click
import numpy as np

from devices.emulated.ur.arm import START_JOINTS
from devices.emulated.ur.controller import Controller
from devices.emulated.ur.server import Server
from recordings.refusal import Refusal


@click.command()
@click.option("--host", default="127.0.0.1", help="address to serve at")
@click.option("--model", default="UR10")
@click.option("--joints", default=json.dumps(START_JOINTS), help="six angles in radians, JSON")
@click.option("--speed", default=1.0, help="how many times faster than real")
@click.option("--stops", default="{}", help='stops by the number of the move they interrupt, JSON: {"3": "protective"}')
def main(host: str, model: str, joints: str, speed: float, stops: str) -> None:
    """Serve until standard input ends; lines there are orders, each is answered by a line of JSON."""
    try:
        controller = Controller(
            model,
            np.array(json.loads(joints), float),
            clock=lambda: time.monotonic() * speed,
            host_clock=time.monotonic,
            stops={int(move): kind for move, kind in json.loads(stops).items()},
        )
        server = Server(controller, host, speed)
    except Refusal as refusal:
        os.write(sys.stdout.fileno(), json.dumps({"refusal": str(refusal)}).encode() + b"\n")
        return
    os.write(sys.stdout.fileno(), b"{}\n")
    server.serve(sys.stdin.fileno(), sys.stdout.fileno())


if __name__ == "__main__":
    main()
