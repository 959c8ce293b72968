"""A robot's loop: frames arrive from one thread at the sensor's rate, clouds are made in another.

    python examples/stream.py RECORDING MAPS.npz [--speed 1]

The recording stands in for the sensor: its frames come as far apart as they were recorded, `--speed` times as fast.
"""

import argparse
import queue
import threading
import time

from fusion.fuser import Fuser
from fusion.rig import given, open_rig
from fusion.volume import Volume
from recordings.maps_file import load_maps


def sensor(passing, speed, out):
    """Put frames into `out` at the rate at which they were recorded; a full queue loses them, as a sensor's would."""
    first = None
    for frame in passing.frames:
        now, then = time.monotonic(), float(frame["timestamp_s"])
        first = (now, then) if first is None else first
        time.sleep(max(0.0, first[0] + (then - first[1]) / speed - now))
        try:
            out.put_nowait(frame)
        except queue.Full:
            print("a frame was lost: fusion is slower than the sensor")
    out.put(None)


def main():
    """Run the loop over a recording."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("recording")
    parser.add_argument("maps")
    parser.add_argument("--speed", type=float, default=1.0)
    wanted = parser.parse_args()

    passing, sight, response = open_rig(wanted.recording, load_maps(wanted.maps))
    fuser = Fuser(sight, response, volume=Volume(voxel_m=0.05))
    frames = queue.Queue(maxsize=4)
    threading.Thread(target=sensor, args=(passing, wanted.speed, frames), daemon=True).start()
    while (frame := frames.get()) is not None:
        start = time.perf_counter()
        rgb = given(frame, passing.static, "rgb")
        cloud = fuser.push(frame["counts"], rgb, frame.get("camera_pose"), frame["timestamp_s"])
        took_ms = 1e3 * (time.perf_counter() - start)
        print(f"{cloud.timestamp_s:8.3f} s: {len(cloud)} points in {took_ms:.1f} ms")
    for sentence, times in fuser.complaints.items():
        print(f"{times} times: {sentence}")


if __name__ == "__main__":
    main()
