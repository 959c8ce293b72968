"""`difflidar rehearse`: a rig that is not there, for the real drivers to work with."""

import sys
import time
from pathlib import Path

import click

LOOK_S = 0.2


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.option("--grid", default="80x45", show_default=True, metavar="COLUMNSxROWS", help="Positions of the plan.")
@click.option("--order", default="snake", show_default=True, type=click.Choice(["snake", "raster", "adaptive"]))
@click.option("--passes", default="separate", show_default=True, type=click.Choice(["separate", "interleaved"]))
@click.option("--ranging", default="long", show_default=True, type=click.Choice(["long", "short"]))
@click.option("--speed", default=1.0, show_default=True, help="How many times faster than real all clocks run.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Loopback address of the arm's controller.")
@click.option("--seed", default=0, show_default=True, help="Of everything random.")
@click.option("--lose", default=0.0, help="Share of the sensor's lines that are lost.")
@click.option("--garble", default=0.0, help="Share of the sensor's lines in which a byte is wrong.")
@click.option("--unplug-at", multiple=True, type=int, metavar="N", help="Measurement in which the cable is pulled.")
@click.option("--stop-at", multiple=True, type=int, metavar="N", help="Move in which a protective stop comes.")
def command(folder, grid, order, passes, ranging, speed, host, seed, lose, garble, unplug_at, stop_at):
    """Serve an emulated sensor, arm and camera before one simulated bench until interrupted.

    FOLDER gets rig.json and plan.json, which `difflidar scan` takes, and the sensor's serial port. Nothing is served
    but on this machine.
    """
    import ipaddress
    import signal

    import numpy as np

    from calibrate.plan import ScanPlan
    from calibrate.rig import LidarSetup
    from devices.emulated.tmf882x.faults import Faults
    from devices.rehearsal.rehearsal import KILO, Rehearsal, Trouble
    from recordings.refusal import Refusal

    size = ScanPlan.parse(grid)
    for name, share in (("lose", lose), ("garble", garble)):
        if not 0 <= share < 1:
            raise Refusal(f"--{name}: {share} found, expected a share from 0 to below 1")
    if not speed > 0:
        raise Refusal(f"--speed: {speed} found, expected a number above 0")
    try:
        local = ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = False
    if not local:
        raise Refusal(f"--host: {host!r} found, expected a loopback address such as 127.0.0.2")
    trouble = Trouble(
        Faults(lose=lose, garble=garble, unplug_at=unplug_at),
        stops=tuple((number, "protective") for number in stop_at),
    )
    rehearsal = Rehearsal(
        folder,
        size.columns,
        size.rows,
        rng=np.random.default_rng(seed),
        lidar=LidarSetup(ranging=ranging, kilo_iterations=KILO),
        speed=speed,
        host=host,
        trouble=trouble,
        order=order,
        passes=passes,
        repeats=size.repeats,
        settle_s=0.02 / speed,
    )
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with rehearsal:
        tool = Path(sys.argv[0]).name
        click.echo(
            f"Sensor, arm and camera are there. In another terminal:\n"
            f"  {tool} scan {folder / 'plan.json'} --rig {folder / 'rig.json'} --out {folder / 'scan.rrd'}\n"
            "Interrupt this (Ctrl-C) to end."
        )
        try:
            while rehearsal.failure is None:
                time.sleep(LOOK_S)
            raise rehearsal.failure
        except KeyboardInterrupt:
            click.echo("over")
