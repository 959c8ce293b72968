"""Write a recording frame by frame, so that what was written survives the end of the process."""

import contextlib
import os
import threading
from pathlib import Path
from typing import Any

from recordings.atomic import expect_place_for
from recordings.frame_checks import FrameChecks
from recordings.refusal import Refusal
from recordings.rrd.layout import APPLICATION, Layout

# At most this long a frame waits in memory; with the time that writing takes it is on its way within a second.
WAIT_S = 0.5
BLOCK_FRAMES = 64
BLOCK_BYTES = 32 << 20
PARTIAL = ".partial"


def partial_path(path: Path) -> Path:
    """Where a recording is written until it is whole."""
    return path.with_name(path.name + PARTIAL)


class RrdWriter:
    """Writes PATH.partial, which takes the name PATH once it is closed, read back and found whole.

    path: the .rrd file; static: fields of the `Recording` that do not vary by frame;
    blueprint: what the viewer shows at first, or None.
    recording: the `rerun.RecordingStream` of the file, for what a viewer should show besides; a reader ignores it.

    As a context manager it closes the file where the block ends well; where it ends with an error, PATH.partial
    keeps the frames that came, for `difflidar repair`. Raises `Refusal` for fields that break the format and
    `OSError` where the operating system does (a full disk), at the latest with the next call.
    """

    def __init__(self, path: str | Path, static: dict[str, Any], blueprint: Any = None) -> None:
        from recordings.rrd.sink import RrdSink

        self.path = Path(path)
        expect_place_for(self.path)
        self.partial = partial_path(self.path)
        self._checks = FrameChecks(static)
        self._layout: Layout | None = None
        self._block: list[dict[str, Any]] = []
        self._block_bytes = 0
        self._sent = 0
        self._timer: threading.Timer | None = None
        self._failed: BaseException | None = None
        self._closed = False
        self._one_at_a_time = threading.RLock()
        try:
            self._sink = RrdSink(self.partial, APPLICATION, blueprint)
        except FileExistsError:
            raise Refusal(
                f"{self.partial} is there from a recording that was interrupted; "
                f"save it with `difflidar repair`, or remove it"
            ) from None
        self.recording = self._sink.recording

    def append(self, frame: dict[str, Any]) -> None:
        """Add a frame: its fields without their first axis, `rgb` as an array or as PNG or JPEG bytes."""
        with self._one_at_a_time:
            self._complain()
            plain = self._checks.frame(frame)
            self._block.append(plain)
            self._block_bytes += sum(len(v) if isinstance(v, bytes) else v.nbytes for v in plain.values())
            if len(self._block) >= BLOCK_FRAMES or self._block_bytes >= BLOCK_BYTES:
                self.flush()
            elif self._timer is None:
                self._timer = threading.Timer(WAIT_S, self._flush_late)
                self._timer.daemon = True
                self._timer.start()

    def flush(self) -> None:
        """Hand all frames so far to the operating system; they survive the end of this process from here on."""
        with self._one_at_a_time:
            self._complain()
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None
            try:
                self._send()
            except BaseException as wrong:
                self._failed = wrong
                raise

    def close(self) -> None:
        """Write what is left, read the file back, and give it its name."""
        from recordings.rrd.reader import verify

        with self._one_at_a_time:
            self.flush()
            self._end()
            if self._sent == 0:
                self.partial.unlink()
                raise Refusal(f"{self.path}: no frame was recorded, expected at least one")
            verify(self.partial, self._sent)
            os.replace(self.partial, self.path)

    def abandon(self) -> None:
        """Write what is left if that is possible, and leave the frames in PATH.partial."""
        with self._one_at_a_time:
            try:
                self.flush()
            finally:
                self._end()

    def _send(self) -> None:
        from recordings.rrd.columns import encoded_all, send_frames, send_static

        if self._block and self._layout is None:
            static = dict(self._checks.static)
            if "rgb" in static:
                static["rgb"] = encoded_all([static["rgb"]])[0]
            self._layout = Layout.of(static, self._block[0], self._checks.image_shape)
            send_static(self.recording, static, self._layout)
        if self._block:
            send_frames(self.recording, self._sent, self._block, self._layout)
            self._sent += len(self._block)
            self._block, self._block_bytes = [], 0
        self._sink.flush()

    def _flush_late(self) -> None:
        # The error is kept, and raised by the next call.
        with contextlib.suppress(BaseException):
            self.flush()

    def _complain(self) -> None:
        if self._failed is not None:
            raise self._failed

    def _end(self) -> None:
        if not self._closed:
            self._closed = True
            self._sink.close()

    def __enter__(self) -> "RrdWriter":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: Any) -> None:
        if kind is None:
            self.close()
            return
        try:
            self.abandon()
        except Exception as also:  # whatever it is, the error that ended the recording matters more
            error.add_note(f"and the last frames could not be written: {also}")
