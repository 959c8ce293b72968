"""A rerun recording written to a file by this process itself, so that a full disk is an error here and now.

The rerun library writes its files from a thread of its own; where the disk is full it reports nothing that a
program can rely on, and may wait for ever. Here it writes into a pipe that is always emptied.
"""

import os
import select
import threading
from pathlib import Path
from typing import Any

READ_BYTES = 1 << 20


class RrdSink:
    """An open .rrd file: log to `recording`, `flush`, `close`.

    path: a file that does not exist yet; application: its name in the viewer; blueprint: what the viewer shows
    at first, or None.
    recording: the `rerun.RecordingStream` that ends in the file.

    Raises `OSError` where the operating system does, also from `flush` and `close`.
    """

    def __init__(self, path: Path, application: str, blueprint: Any = None) -> None:
        import rerun as rr

        self._file = open(path, "xb", buffering=0)  # noqa: SIM115 - `close` closes it
        self._failed: OSError | None = None
        self._emptying = threading.Lock()
        self._pipe, into = os.pipe()
        os.set_blocking(self._pipe, False)
        self._pump = threading.Thread(target=self._pump_until_closed, daemon=True)
        self._pump.start()
        try:
            self.recording = rr.RecordingStream(
                application,
                make_default=False,
                make_thread_default=False,
                batcher_config=rr.ChunkBatcherConfig.NEVER(),
            )
            self.recording.save(f"/dev/fd/{into}", default_blueprint=blueprint)
        finally:
            os.close(into)

    def flush(self) -> None:
        """Return once all that was logged is with the operating system, where the end of this process spares it."""
        self.recording.flush()
        self._empty()
        self._complain()

    def close(self) -> None:
        """Write the index and close the file."""
        self.recording.disconnect()
        self._pump.join()
        os.close(self._pipe)
        self._file.close()
        self._complain()

    def _complain(self) -> None:
        if self._failed is not None:
            raise self._failed

    def _pump_until_closed(self) -> None:
        waiting = select.poll()
        waiting.register(self._pipe, select.POLLIN)
        while True:
            waiting.poll()
            if not self._empty():
                return

    def _empty(self) -> bool:
        """Move what is in the pipe to the file; False once nothing will come any more.

        After an error the rest is thrown away, so that the library never waits.
        """
        with self._emptying:
            try:
                while data := os.read(self._pipe, READ_BYTES):
                    self._write(memoryview(data))
            except BlockingIOError:
                return True
        return False

    def _write(self, data: memoryview) -> None:
        try:
            while data and self._failed is None:
                data = data[self._file.write(data) :]
        except OSError as wrong:
            wrong.filename = self._file.name
            self._failed = wrong
