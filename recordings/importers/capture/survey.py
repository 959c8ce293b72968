"""A published capture file gone through once, passing over its arrays: what of it can be read."""

import itertools
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from recordings.importers.capture.record import Capture, capture
from recordings.importers.inert.reader import BoundedReader
from recordings.importers.inert.records import records
from recordings.importers.inert.walk import loaded
from recordings.refusal import Refusal


@dataclass(frozen=True)
class Survey:
    """`captures` alike in layout and in order, and the `metadata` before them.

    `left_out` gives for the number of each other record why; `truncated` says where the file was cut off.
    """

    captures: tuple[Capture, ...]
    metadata: dict[str, Any]
    left_out: dict[str, str]
    truncated: str | None

    @property
    def iterations(self) -> list[int] | None:
        """What the script counted, a number a capture, rising; None where not every record says it."""
        iterations = [one.iteration for one in self.captures]
        return None if None in iterations else iterations

    @property
    def times_s(self) -> list[float] | None:
        """When each capture was taken, seconds; None where the records do not give rising times."""
        times = [one.time_s for one in self.captures]
        if None in times or any(later <= earlier for earlier, later in itertools.pairwise(times)):
            return None
        return times


def surveyed(path: Path) -> Survey:
    """Go through the file once; `Refusal` where a record asks for more than data, or none holds a capture."""
    whole: list[Capture] = []
    metadata: dict[str, Any] = {}
    left_out: dict[str, str] = {}
    truncated = None
    with path.open("rb") as file:
        reader = BoundedReader(file)
        try:
            for number, record in enumerate(records(path, reader)):
                if number == 0 and isinstance(record, dict) and isinstance(record.get("metadata"), dict):
                    with path.open("rb") as arrays:
                        metadata = loaded(record["metadata"], arrays)
                    continue
                try:
                    whole.append(capture(number, record))
                except Refusal as wrong:
                    left_out[str(number)] = str(wrong)
        except EOFError as wrong:
            truncated = str(wrong)
    if not whole:
        reasons = [truncated, *(f"record {number} {why}" for number, why in left_out.items())]
        reason = next(filter(None, reasons), "it ends after its metadata")
        raise Refusal(f"{path}: no capture with a histogram is in this stream of pickles; {reason}")
    layout = Counter(one.layout for one in whole).most_common(1)[0][0]
    left_out |= {str(one.number): unlike(one.layout, layout) for one in whole if one.layout != layout}
    captures = [one for one in whole if one.layout == layout]
    if all(one.iteration is not None for one in captures):
        captures.sort(key=lambda one: one.iteration)
    return Survey(tuple(captures), metadata, left_out, truncated)


def unlike(layout: tuple[tuple[str, str], ...], common: tuple[tuple[str, str], ...]) -> str:
    """In what a record differs from most records."""
    name, has, expected = next(
        (name, has, expected) for (name, has), (_, expected) in zip(layout, common, strict=True) if has != expected
    )
    return f"has {name}: {has}, expected {expected} as in most records"
