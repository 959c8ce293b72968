"""`difflidar scan`: the arm moves the patch through the field of sensor and camera, unattended."""

import signal
import sys
from pathlib import Path

import click
from rich.console import Console

from difflidar.progress import bar


@click.command()
@click.argument("plan", type=click.Path(path_type=Path))
@click.option(
    "--rig", "rig_path", type=click.Path(path_type=Path), help="The rig file.  [default: rig.json beside PLAN]"
)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Recording to write, .rrd.")
@click.option("--resume", is_flag=True, help="Go on with the scan that was left at --out.")
@click.option("--prior", type=click.Path(path_type=Path), help="Maps of the other range mode, for an adaptive plan.")
@click.option("--live", is_flag=True, help="Open the rerun viewer and show the scan in it.")
@click.option("--connect", "address", help="Address of a viewer that runs, such as rerun+http://127.0.0.1:9876/proxy.")
def command(plan, rig_path, out, resume, prior, live, address):
    """Scan as PLAN says; every position is on disk before the next but one, and --resume goes on where it was."""
    from calibrate.rig import load_rig
    from devices.scan.conduct import conduct
    from devices.scan.motion_plan import load_plan
    from difflidar.scan_progress import ScanProgress
    from recordings.maps_file import load_maps
    from recordings.refusal import Refusal

    if out.suffix != ".rrd":
        raise Refusal(f"{out}: expected a name that ends in .rrd")
    motion, rig = load_plan(plan), load_rig(rig_path or plan.with_name("rig.json"))
    if prior is not None and motion.order != "adaptive":
        raise Refusal("--prior: only an adaptive plan has a use for other maps, this plan's order is " + motion.order)
    known = None if prior is None else load_maps(prior)
    view = viewer(rig, address) if live or address else None
    # A scan that is told to end brings the arm to rest first.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    shown = ScanProgress(view)
    try:
        with shown:
            written, tally = conduct(
                motion,
                rig,
                out,
                resume=resume,
                prior=known,
                ask=shown.ask,
                tell=shown.tell,
                watch=shown.saw,
                progress=bar,
            )
    except KeyboardInterrupt:
        raise Refusal(f"interrupted; the arm rests, what was seen is kept: go on with --resume --out {out}") from None
    say(written, tally)


def viewer(rig, address: str | None):
    """A live view of the scan, in a viewer that runs at `address` or in a new one."""
    from calibrate.rig import MODES
    from viewers.live_scan import LiveScan, live_scan_blueprint
    from viewers.viewer import shown_in_viewer

    grid = MODES[rig.lidar.mode]
    session = shown_in_viewer("difflidar scan", live_scan_blueprint(grid), address, "leave --live out")
    return LiveScan(session, grid, rig.camera.size)


def say(written: dict[str, Path], tally: dict) -> None:
    """What was written, and where the time went."""
    console = Console()
    whole, moving, measuring = (tally[name] for name in ("whole_s", "moving_s", "measuring_s"))
    rest = whole - moving - measuring
    stops = ", ".join(f"{count} {kind} stops" for kind, count in tally["stops"].items()) or "no stop"
    lost = ", ".join(f"{what} {count} times" for what, count in tally["lost"].items() if count) or "nothing"
    console.print(
        f"In this sitting {whole:.0f} s: {moving:.0f} s moving, {measuring:.0f} s measuring, {rest:.0f} s for the "
        f"rest; {stops}; lost and found again: {lost}.",
        highlight=False,
        soft_wrap=True,
    )
    console.print(f"wrote {' '.join(str(path) for path in written.values())}", highlight=False, soft_wrap=True)
    background = f" --background {written['background']}" if "background" in written else ""
    tool = Path(sys.argv[0]).name or "difflidar"
    console.print(
        f"now: {tool} calibrate {written['patch']}{background} --out maps.npz", highlight=False, soft_wrap=True
    )
