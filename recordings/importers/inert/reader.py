"""A file whose length fields are believed only as far as the file goes."""

from dataclasses import dataclass
from typing import BinaryIO

from recordings.refusal import Refusal

# What is parsed of a record rather than skipped: names, shapes, small numbers.
PARSED_LIMIT_BYTES = 16 << 20
# Every opcode is a step; one can ask for an empty dictionary, so this bounds what a hostile record can claim.
STEP_LIMIT = 500_000


@dataclass(frozen=True)
class Span:
    """`length` bytes of the file from `offset` on, left there."""

    offset: int
    length: int

    def __len__(self) -> int:
        return self.length


class BoundedReader:
    """A file whose every read is checked against what the file still holds before anything is allocated."""

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        self.size = file.seek(0, 2)
        self.position = file.seek(0)
        self.record_start = self.parsed = self.steps = 0

    def start_record(self) -> None:
        """Forget what earlier records took."""
        self.record_start, self.parsed, self.steps = self.position, 0, 0

    def take(self, length: int) -> None:
        """Account for `length` bytes ahead; `EOFError` where the file ends before them."""
        if length > self.size - self.position:
            raise EOFError(f"wants {length} bytes where the file holds {self.size - self.position} more")
        self.position += length

    def read(self, length: int) -> bytes:
        """The next `length` bytes."""
        self.parsed += length
        self.steps += 1
        if self.parsed > PARSED_LIMIT_BYTES or self.steps > STEP_LIMIT:
            raise Refusal("holds more beside its arrays than the record of a capture")
        self.take(length)
        return self.file.read(length)

    def readline(self) -> bytes:
        """The next line with its end."""
        line = self.file.readline(PARSED_LIMIT_BYTES)
        self.file.seek(self.position)
        if not line.endswith(b"\n"):
            raise EOFError("ends within a line")
        return self.read(len(line))

    def skip(self, length: int) -> Span:
        """The next `length` bytes, passed over."""
        span = Span(self.position, length)
        self.take(length)
        self.file.seek(self.position)
        return span
