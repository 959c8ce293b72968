"""The first bytes of a file, by which importers know what is theirs."""

from pathlib import Path

SNIFFED_BYTES = 1 << 16


def head(path: Path, count: int = SNIFFED_BYTES) -> bytes:
    """At most `count` bytes from the start of a file; none where it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(count)
    except OSError:
        return b""
