"""`difflidar live`: sensor and camera, fused as they see, in the rerun viewer."""

import signal
import time
from collections import deque
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path

import click
from rich.console import Console
from rich.live import Live
from rich.text import Text

# Rates and latencies are said of so many frames.
LATEST = 50
CAMERA_AWAY_S = 60.0


@click.command()
@click.option(
    "--rig", "rig_path", default="rig.json", show_default=True, type=click.Path(path_type=Path), help="The rig file."
)
@click.option("--calibration", "maps_path", required=True, type=click.Path(path_type=Path), help="Response maps, .npz.")
@click.option("--sensor", "sensor_name", help="A sensor.json, or a preset; default: by the rig's mode.")
@click.option("--method", help="Of fusion, as `difflidar fuse` has it; default: splat, the fastest.")
@click.option("--connect", "address", help="Address of a viewer that runs, such as rerun+http://127.0.0.1:9876/proxy.")
@click.option("--save", "out", type=click.Path(path_type=Path), help="Write the session to FILE.rrd instead.")
@click.option("--frames", "most", type=click.IntRange(1), help="End after so many frames; default: when interrupted.")
def command(rig_path, maps_path, sensor_name, method, address, out, most):
    """Fuse what sensor and camera see now, and show it with its latency until interrupted (Ctrl-C)."""
    from calibrate.rig import load_rig
    from devices.camera.open import open_camera
    from devices.live_stream import Pictures, live_stream
    from devices.scan.kept import Kept
    from devices.tmf882x.driver import open_tmf882x
    from difflidar.view_recording import instruments, session_of
    from fusion.fuse import expect_method
    from physics.sensor_choice import choose_sensor
    from recordings.atomic import expect_place_for
    from recordings.maps_file import load_maps
    from recordings.refusal import Refusal
    from viewers.fusion_session import live_session, saved_session

    if out is not None and address is not None:
        raise Refusal("--save and --connect: expected one of them, the session goes to a file or to a viewer")
    if out is not None:
        expect_place_for(out)
    method = method or "splat"
    expect_method(method)
    rig, maps = load_rig(rig_path), load_maps(maps_path)
    sensor = choose_sensor(sensor_name, "", maps)
    tell = Console(stderr=True).print
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with ExitStack() as stack:
        lidar = stack.enter_context(closing(open_tmf882x(rig.lidar, reconnect_s=CAMERA_AWAY_S, progress=tell)))
        camera = Kept("camera", lambda: open_camera(rig.camera), tell, CAMERA_AWAY_S)
        said = camera.device.said
        pictures = stack.enter_context(Pictures(camera))
        passing = live_stream(rig, lidar, said, pictures)
        first = next(passing.frames)
        tools = instruments(passing.static, first, maps, sensor, method)
        about = f"{rig.name}, live, fused by the method *{method}*."
        # What is compiled at its first use is compiled before the stream begins, or it would run behind for seconds.
        passing.frames.close()
        next(session_of(replace(passing, frames=iter([first])), rig.name, about, tools)[1])
        passing = live_stream(rig, lidar, said, pictures)
        shown, frames, _ = session_of(passing, rig.name, about, tools)
        shown = replace(shown, has_latency=True, start_s=None)
        if out is None:
            push = stack.enter_context(closing(live_session(shown, address))).push
        else:
            push = stack.enter_context(saved_session(out, shown))
        try:
            run(frames, push, most)
        except KeyboardInterrupt:
            tell("over")


def run(frames, push, most: int | None) -> None:
    """Push frames as they come; the terminal shows their rate and how late they are."""
    late, at = deque(maxlen=LATEST), deque(maxlen=LATEST)
    count = 0
    with Live(Text("waiting for the first frame"), console=Console(stderr=True), refresh_per_second=4) as line:
        for frame in frames:
            # Both from the host's clock: when the measurement's first line arrived, and when its cloud is handed on.
            latency_s = time.time() - frame.timestamp_s
            push(replace(frame, latency_s=latency_s))
            late.append(latency_s)
            at.append(frame.timestamp_s)
            count += 1
            rate = (len(at) - 1) / max(at[-1] - at[0], 1e-9)
            middle, worst = (1e3 * sorted(late)[int(share * (len(late) - 1))] for share in (0.5, 0.95))
            line.update(
                Text(f"{count} frames, {rate:.1f} a second; {middle:.0f} ms late (median), {worst:.0f} ms (95 %)")
            )
            if count == most:
                return
