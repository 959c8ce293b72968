"""Reading the records of a pickle stream given as bytes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from recordings.importers.inert.reader import BoundedReader
from recordings.importers.inert.records import records
from recordings.importers.inert.stored_array import StoredArray


@pytest.fixture
def read() -> Callable[[Path, bytes], list[Any]]:
    """Writes bytes into a folder and reads their records, arrays loaded."""

    def read_records(folder: Path, content: bytes) -> list[Any]:
        path = folder / "records.pkl"
        path.write_bytes(content)
        with path.open("rb") as file:
            revived = list(records(path, BoundedReader(file)))
            return [value.read(file) if isinstance(value, StoredArray) else value for value in revived]

    return read_records
