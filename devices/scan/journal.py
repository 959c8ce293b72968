"""What a scan has seen so far, on disk after every sample, so that a scan goes on where it was.

An SQLite database: a sample is there whole or not at all, whatever happens to the process, the disk or the power.
"""

import fcntl
import json
import sqlite3
import threading
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from recordings.refusal import Refusal

SUFFIX = ".scanning"
KIND = "difflidar scan 1"
SCHEMA = """
CREATE TABLE IF NOT EXISTS said (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS samples (
    id INTEGER PRIMARY KEY, pass TEXT NOT NULL, cell INTEGER NOT NULL, frames INTEGER NOT NULL, said TEXT NOT NULL);
CREATE UNIQUE INDEX IF NOT EXISTS once ON samples (pass, cell) WHERE pass <> 'monitor';
CREATE TABLE IF NOT EXISTS frames (
    sample INTEGER NOT NULL REFERENCES samples (id), number INTEGER NOT NULL, time_s REAL NOT NULL,
    counts BLOB NOT NULL, rgb BLOB, PRIMARY KEY (sample, number)) WITHOUT ROWID;
"""
# Zone counts are small numbers in wide types: the fastest level halves them or better.
LEVEL = 1


@dataclass(frozen=True, eq=False)
class Frame:
    """One measurement of a sample. counts: (P, T) uint32. rgb: JPEG bytes, None where no picture was taken."""

    time_s: float
    counts: np.ndarray
    rgb: bytes | None


@dataclass(frozen=True, eq=False)
class Sample:
    """What was seen at one position: `pass_name` "patch", "background" or "monitor", and the number of the cell.

    said: pose and joints the arm was read at, temperature, what the chip found itself, exposure.
    """

    pass_name: str
    cell: int
    frames: tuple[Frame, ...]
    said: dict[str, Any]


class Journal:
    """The samples of a scan, in the order in which they were taken; may be used from several threads."""

    def __init__(self, path: str | Path) -> None:
        """Open or begin a journal; raises `Refusal` where the file is something else."""
        self.path = Path(path)
        self._alone = threading.RLock()
        self._lock = _locked(self.path)
        self._base = sqlite3.connect(self.path, isolation_level=None, check_same_thread=False)
        try:
            # FULL: a sample that was told to be there survives a power cut.
            self._base.execute("PRAGMA synchronous = FULL")
            self._base.executescript(f"PRAGMA journal_mode = WAL; BEGIN; {SCHEMA} COMMIT;")
            if self.said("kind") is None:
                self.say("kind", KIND)
        except sqlite3.DatabaseError as wrong:
            self._base.close()
            raise self._refusal(wrong) from None
        if self.said("kind") != KIND:
            raise Refusal(f"{self.path}: a journal of kind {self.said('kind')!r}, expected {KIND!r}")

    def close(self) -> None:
        """Let go of the file."""
        self._base.close()
        self._lock.close()

    def remove(self) -> None:
        """Delete the journal, once all of it is somewhere else."""
        self.close()
        for suffix in ("-wal", "-shm", ""):
            self.path.with_name(self.path.name + suffix).unlink(missing_ok=True)

    def say(self, name: str, value: Any) -> None:
        """Keep a value that JSON can hold under a name."""
        with self._writing():
            self._base.execute("INSERT OR REPLACE INTO said VALUES (?, ?)", (name, json.dumps(value)))

    def said(self, name: str) -> Any:
        """What was kept under a name, None where nothing was."""
        with self._alone:
            row = self._base.execute("SELECT value FROM said WHERE name = ?", (name,)).fetchone()
        return None if row is None else json.loads(row[0])

    def add(self, sample: Sample) -> None:
        """Keep a sample; once this returns, it stays. Raises `Refusal` where the disk is full."""
        with self._writing():
            row = (sample.pass_name, sample.cell, len(sample.frames), json.dumps(sample.said))
            at = self._base.execute("INSERT INTO samples (pass, cell, frames, said) VALUES (?, ?, ?, ?)", row).lastrowid
            for number, frame in enumerate(sample.frames):
                counts = np.ascontiguousarray(frame.counts, np.uint32)
                blob = json.dumps(counts.shape).encode() + b"\n" + zlib.compress(counts.tobytes(), LEVEL)
                self._base.execute(
                    "INSERT INTO frames VALUES (?, ?, ?, ?, ?)", (at, number, frame.time_s, blob, frame.rgb)
                )

    def forget(self, pass_name: str, cells: list[int]) -> None:
        """Drop samples that turned out to show something else."""
        with self._writing():
            for cell in cells:
                of = "SELECT id FROM samples WHERE pass = ? AND cell = ?"
                self._base.execute(f"DELETE FROM frames WHERE sample IN ({of})", (pass_name, cell))
                self._base.execute("DELETE FROM samples WHERE pass = ? AND cell = ?", (pass_name, cell))

    def cells(self, pass_name: str) -> list[int]:
        """Cells that were visited in a pass, in order."""
        with self._alone:
            rows = self._base.execute("SELECT cell FROM samples WHERE pass = ? ORDER BY id", (pass_name,)).fetchall()
        return [cell for (cell,) in rows]

    def count(self) -> int:
        """Samples so far."""
        with self._alone:
            return self._base.execute("SELECT count(*) FROM samples").fetchone()[0]

    def samples(self, pass_name: str, pictures: bool = True) -> Iterator[Sample]:
        """Samples of a pass, as they were taken, one at a time."""
        with self._alone:
            rows = self._base.execute("SELECT id, cell, said FROM samples WHERE pass = ? ORDER BY id", (pass_name,))
            found = rows.fetchall()
        rgb = "rgb" if pictures else "NULL"
        for at, cell, said in found:
            with self._alone:
                rows = self._base.execute(
                    f"SELECT time_s, counts, {rgb} FROM frames WHERE sample = ? ORDER BY number", (at,)
                ).fetchall()
            frames = tuple(Frame(time_s, _counts(blob), picture) for time_s, blob, picture in rows)
            yield Sample(pass_name, cell, frames, json.loads(said))

    def _writing(self) -> "_Transaction":
        return _Transaction(self)

    def _refusal(self, wrong: sqlite3.Error) -> Refusal:
        if "full" in str(wrong) or "disk I/O" in str(wrong):
            return Refusal(
                f"{self.path}: the disk is full; what was seen so far is kept: free some space and go on with --resume"
            )
        return Refusal(f"{self.path}: cannot be used as the journal of a scan ({wrong})")


class _Transaction:
    """All or nothing; the database's words become a refusal."""

    def __init__(self, journal: Journal) -> None:
        self._journal, self._base = journal, journal._base

    def __enter__(self) -> None:
        self._journal._alone.acquire()
        self._base.execute("BEGIN")

    def __exit__(self, kind: type | None, wrong: BaseException | None, trace: Any) -> None:
        try:
            self._base.execute("ROLLBACK" if kind else "COMMIT")
        except sqlite3.Error as worse:
            wrong = wrong or worse
            if self._base.in_transaction:
                self._base.execute("ROLLBACK")
        finally:
            self._journal._alone.release()
        if isinstance(wrong, sqlite3.Error):
            raise self._journal._refusal(wrong) from None


def _locked(path: Path) -> IO[bytes]:
    """The file, open and locked for this process alone; `Refusal` where another scan writes into it."""
    file = path.open("ab")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise Refusal(f"{path}: another scan writes into it; wait for it, or stop it") from None
    return file


def _counts(blob: bytes) -> np.ndarray:
    shape, _, packed = blob.partition(b"\n")
    return np.frombuffer(zlib.decompress(packed), np.uint32).reshape(json.loads(shape))
