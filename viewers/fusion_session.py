"""Where a session goes: into files of bounded size, or to a viewer."""

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import rerun as rr

from recordings.atomic import written_aside
from recordings.files import NO_ROOM
from recordings.refusal import Refusal
from recordings.rrd.sink import RrdSink
from viewers.fusion_blueprint import fusion_blueprint
from viewers.live_view import PICTURES_HZ, POINTS, LiveView
from viewers.session_frame import SessionFrame, SessionRig
from viewers.viewer import shown_in_viewer

# Not that of recordings and scans: the viewer keeps a layout for each.
APPLICATION = "difflidar view"
INSTEAD = "--save FILE.rrd writes it to a file instead"
PART_BYTES = 256 << 20
FLUSH_FRAMES = 32


@contextmanager
def saved_session(
    path: str | Path,
    rig: SessionRig,
    part_bytes: int = PART_BYTES,
    pictures_hz: float = PICTURES_HZ,
    most_points: int = POINTS,
) -> Iterator[Callable[[SessionFrame], None]]:
    """Yield a function that adds a frame to the session at `path`; the files are there whole, or none is.

    Once a file has `part_bytes`, the session goes on in NAME.part2.rrd and so on, each of which opens by itself.
    """
    path = Path(path)
    if path.suffix != ".rrd":
        raise Refusal(f"{path}: expected a name that ends in .rrd")
    if part_path(path, 2).exists():
        raise Refusal(f"{part_path(path, 2)} is there from another session; remove it, or choose another name")
    # Left from the inside out: files are closed before they get their names.
    with ExitStack() as names, ExitStack() as open_file:
        parts: list[tuple[Path, RrdSink]] = []

        def next_part() -> rr.RecordingStream:
            open_file.close()
            aside = names.enter_context(written_aside(part_path(path, len(parts) + 1)))
            sink = RrdSink(aside, APPLICATION, fusion_blueprint(rig))
            open_file.callback(sink.close)
            parts.append((aside, sink))
            sink.recording.send_recording_name(rig.title + (f", part {len(parts)}" if len(parts) > 1 else ""))
            return sink.recording

        view, pushed = LiveView(rig, next_part(), pictures_hz, most_points, prompt=False), 0

        def push(frame: SessionFrame) -> None:
            nonlocal pushed
            view.push(frame)
            pushed += 1
            if pushed % FLUSH_FRAMES == 0:
                view.flush()
                aside, sink = parts[-1]
                sink.flush()
                if os.path.getsize(aside) >= part_bytes:
                    view.moved_to(next_part())

        try:
            yield push
            view.flush()
            open_file.close()
        except OSError as wrong:
            if wrong.errno in NO_ROOM:
                wrong.filename = str(path)  # Not the name it has until it is whole.
            raise


def part_path(path: Path, number: int) -> Path:
    """The file of a session's part, counted from 1."""
    return path if number == 1 else path.with_name(f"{path.stem}.part{number}{path.suffix}")


def live_session(rig: SessionRig, address: str | None = None, pictures_hz: float = PICTURES_HZ) -> LiveView:
    """A session in the viewer at `address`, or, where that is None, in the one of this machine, started if need be.

    Refused in a sentence where there is no viewer at the address, or no display to start one on.
    """
    recording = shown_in_viewer(APPLICATION, fusion_blueprint(rig), address, INSTEAD)
    recording.send_recording_name(rig.title)
    return LiveView(rig, recording, pictures_hz)
