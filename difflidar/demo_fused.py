"""The demo's middle: a simulated sensor looks round a room, and what it saw is fused through the maps of the scan."""

from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

import recordings
from recordings.maps import ResponseMaps
from recordings.progress import Progress
from recordings.recording import Recording

ROOM = Path(recordings.__file__).parent / "samples" / "room.json"
PEAK = 3000.0  # counts in the fullest bin
# Of what a pixel's depth says, the part that must come from the sensor for it to be judged.
SEEN = 0.1


def see_room(maps: ResponseMaps, rng: np.random.Generator, every: int = 1) -> Recording:
    """What a TMF8828 mounted as `maps` say records of the sample room, with the parallax that its mount has.

    every: of so many frames of the way through the room, one is recorded.
    """
    from physics.effects import find_effect
    from physics.presets import preset
    from physics.scene.open_scene import open_scene
    from physics.simulate import simulate

    mount = np.asarray(maps.meta["lidar_from_camera"])
    x, y, _ = -mount[:3, :3].T @ mount[:3, 3]
    sensor = replace(preset("tmf8828-3x3-wide-long"), effects=(find_effect("parallax").at(x=x, y=y),))
    way = open_scene(ROOM, maps)
    way = replace(way, views=islice(way.views, 0, None, every), count=-(-way.count // every))
    return simulate(way, maps, sensor, rng, peak=PEAK)[0].collect()


def fuse_room(maps_path: Path, out: Path, rng: np.random.Generator, progress: Progress) -> tuple[float, float]:
    """Record the room, fuse it, and write seen.rrd, fused/ and fused.rrd; errors of depth.

    Rms of depth in metres against the depth of the simulation, and how often it lies in the interval of 90 %, over
    pixels that the zones see.
    """
    from difflidar.view_recording import open_recording
    from fusion.fuse import METHODS
    from fusion.rig import open_rig
    from fusion.save import folder_aside, load_frames
    from fusion.session import fuse_into
    from recordings.files import save
    from recordings.maps_file import load_maps
    from viewers.fusion_session import saved_session

    maps, seen = load_maps(maps_path), out / "seen.rrd"
    recording = see_room(maps, rng, every=2)
    save(recording, seen)
    passing, sight, response = open_rig(seen, maps)
    with folder_aside(out / "fused") as folder:
        names = {"recording": seen.name, "calibration": maps_path.name}
        fuse_into(folder, passing, sight, response, METHODS[-1], names=names, progress=progress)
    rig, frames, count = open_recording(seen, maps_path, None, METHODS[-1])
    with saved_session(out / "fused.rrd", rig) as push:
        for frame in progress(frames, count, "writing the session"):
            push(frame)
    off, stated = [], []
    for (frame, _), truth in zip(load_frames(out / "fused"), recording.depth_m, strict=True):
        judged = frame.known & (frame.confidence > SEEN) & np.isfinite(truth)
        off.append((frame.depth_m - truth)[judged])
        stated.append(frame.sigma_m[judged])
    error, sigma = np.concatenate(off), np.concatenate(stated)
    return float(np.sqrt(np.mean(error**2))), float(np.mean(np.abs(error) < 1.645 * sigma))
