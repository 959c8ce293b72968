"""`difflidar record`: what sensor and camera see, kept as a recording."""

import signal
from contextlib import closing
from pathlib import Path

import click
from rich.console import Console

AWAY_S = 60.0


@click.command()
@click.option(
    "--rig", "rig_path", default="rig.json", show_default=True, type=click.Path(path_type=Path), help="The rig file."
)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Recording to write, .rrd or .npz.")
@click.option("--frames", "most", type=click.IntRange(1), help="End after so many frames; default: when interrupted.")
def command(rig_path, out, most):
    """Record the LiDAR's histograms and the camera's pictures, and its depth if it has any, until interrupted (Ctrl-C).

    What comes out is what `fuse`, `check` and `explain` take. A camera's depth is poor while its projector is off, as
    it is unless camera.emitter in the rig file says otherwise; while it is on it adds light to the histograms.
    """
    from calibrate.rig import load_rig
    from devices.camera.open import open_camera
    from devices.live_stream import Pictures, live_stream
    from devices.scan.kept import Kept
    from devices.tmf882x.driver import open_tmf882x
    from recordings.atomic import expect_place_for
    from recordings.files import WRITTEN, save
    from recordings.refusal import Refusal
    from recordings.stream import Stream

    if out.suffix not in WRITTEN:
        raise Refusal(f"{out}: expected a name that ends in {' or '.join(WRITTEN)}")
    expect_place_for(out)
    rig = load_rig(rig_path)
    console = Console(stderr=True)
    over: list[int] = []
    with closing(open_tmf882x(rig.lidar, reconnect_s=AWAY_S, progress=console.print)) as lidar:
        camera = Kept("camera", lambda: open_camera(rig.camera), console.print, AWAY_S)
        said = camera.device.said
        with Pictures(camera) as pictures:
            passing = live_stream(rig, lidar, said, pictures)
            # A frame that was begun is kept: the first interruption only says that it is enough.
            for name in (signal.SIGINT, signal.SIGTERM):
                signal.signal(name, lambda *_: over.append(1))
            count = 0

            def until_enough():
                nonlocal count
                for frame in passing.frames:
                    yield frame
                    count += 1
                    if over or count == most:
                        return

            console.print(f"recording {rig.name}; interrupt (Ctrl-C) to end", highlight=False)
            save(Stream(passing.static, until_enough(), most), out)
            passing.frames.close()
    lost = lidar.said["lost"]
    click.echo(f"wrote {out}: {count} frames, {lost.get('missed', 0)} more were lost on the way")
