"""Write aside, then rename: a file is there whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from recordings.refusal import Refusal


def expect_place_for(path: str | Path) -> None:
    """Refuse a path that no file can be written to: worth asking before work that takes minutes."""
    path = Path(path)
    if not path.parent.is_dir():
        raise Refusal(f"{path}: the folder {path.parent} does not exist")
    if path.is_dir():
        raise Refusal(f"{path}: is a folder, expected the name of a file to write")
    if not os.access(path.parent, os.W_OK):
        raise Refusal(f"{path}: no permission to write into {path.parent}")


@contextmanager
def written_aside(path: str | Path) -> Iterator[Path]:
    """Yield a path beside `path` to write to; it takes the name `path` when the block ends without error.

    Where the block fails, whatever stood at `path` before is untouched and nothing else is left behind.
    """
    path = Path(path)
    expect_place_for(path)
    aside = path.with_name(f".{path.name}.{os.getpid()}.aside")
    try:
        yield aside
        os.replace(aside, path)
    finally:
        aside.unlink(missing_ok=True)
