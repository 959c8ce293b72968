"""`difflidar view`: a recording, or what was fused of one, to look through."""

from pathlib import Path

import click

from difflidar.progress import bar


@click.command()
@click.argument("recording", metavar="RECORDING|DIR", type=click.Path(path_type=Path))
@click.option("--calibration", "maps_path", type=click.Path(path_type=Path), help="Response maps, .npz, to fuse with.")
@click.option("--sensor", "sensor_name", help="A sensor.json, or a preset such as tmf8828-3x3-wide-long.")
@click.option("--method", help="Of fusion, as `difflidar fuse` has it.")
@click.option("--save", "out", type=click.Path(path_type=Path), help="Write the session to FILE.rrd; shows nothing.")
@click.option("--connect", "address", help="Address of a viewer that runs, such as rerun+http://127.0.0.1:9876/proxy.")
@click.option("--part-mb", default=256, show_default=True, type=click.IntRange(1), help="Size of a file at most.")
def command(recording, maps_path, sensor_name, method, out, address, part_mb):
    """Show RECORDING, or DIR as `difflidar fuse` wrote it, in the rerun viewer, or save that as a session.

    With a calibration, depth is fused: the session shows it with its uncertainty, as a cloud with the camera among it,
    and beside the histograms; where the recording has depth of its own, residuals against a simulation, too.
    """
    from fusion.fuse import METHODS
    from recordings.atomic import expect_place_for
    from recordings.refusal import Refusal
    from viewers.fusion_session import live_session, saved_session

    if out is not None and address is not None:
        raise Refusal("--save and --connect: expected one of them, the session goes to a file or to a viewer")
    if out is not None:
        expect_place_for(out)
    rig, frames, count = opened(recording, maps_path, sensor_name, method or METHODS[-1])
    if out is None:
        view = live_session(rig, address)
        for frame in bar(frames, count, "showing frames"):
            view.push(frame)
        view.close()
        return
    with saved_session(out, rig, part_bytes=part_mb << 20) as push:
        for frame in bar(frames, count, "writing the session"):
            push(frame)
    parts = sorted(out.parent.glob(f"{out.stem}.part*{out.suffix}"))
    click.echo(f"wrote {' '.join(str(path) for path in [out, *parts])}")


def opened(recording: Path, maps_path: Path | None, sensor_name: str | None, method: str):
    """Rig, frames and their number, of a recording or a folder of fused frames."""
    from difflidar.view_folder import is_fused, open_fused
    from difflidar.view_recording import open_recording
    from recordings.refusal import Refusal

    if not is_fused(recording):
        return open_recording(recording, maps_path, sensor_name, method)
    if maps_path is not None or sensor_name is not None:
        raise Refusal(f"{recording}: is fused already, expected no --calibration and no --sensor")
    return open_fused(recording)
