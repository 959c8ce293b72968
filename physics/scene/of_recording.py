"""The scene a recording saw, from its depth."""

from collections.abc import Iterator
from pathlib import Path

from physics.scene.view import View, Views
from recordings.files import stream
from recordings.refusal import Refusal
from recordings.stream import Stream

PER_VIEW = ("depth_m", "reflectance", "incidence_cosine", "rgb")


def open_recording(path: Path) -> Views:
    """The views of the recording in a file; refused where it has no depth or no intrinsics."""
    return views_of(stream(path), str(path))


def views_of(passing: Stream, name: str) -> Views:
    """The views of a recording in passing."""
    if passing.static.get("intrinsics") is None:
        raise Refusal(f"{name}: intrinsics is missing, expected a recording of a camera and its depth")

    def views() -> Iterator[View]:
        for frame in passing.checked():
            seen = {n: frame.get(n, passing.static.get(n)) for n in PER_VIEW}
            if seen["depth_m"] is None:
                raise Refusal(f"{name}: depth_m is missing, expected a recording with depth")
            yield View(float(frame["timestamp_s"]), **seen, camera_pose=frame.get("camera_pose"))

    return Views(
        passing.static["intrinsics"],
        views(),
        passing.count,
        passing.static.get("lidar_from_camera"),
        {"scene": name.rpartition("/")[2], "scene_form": "recording"},
    )
