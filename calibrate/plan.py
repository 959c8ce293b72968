"""The order in which a scan visits its grid, and which frames of the recording belong to which cell."""

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from recordings.refusal import Refusal

ORDERS = ("snake", "raster", "listed")
META_KEY = "plan"
# A file may claim any grid; nobody scans ten million frames.
MAX_FRAMES = 10_000_000


@dataclass(frozen=True)
class ScanPlan:
    """A patch visits columns × rows cells and rests for `repeats` frames at each.

    first: frames recorded before the grid, which belong to no cell.
    order: "snake" runs through even rows with ascending columns and through odd rows with descending ones, as
    the published scans do (row 0 is the lowest in the image, column 0 the leftmost); "raster" always ascends; "listed"
    visits the cells in `listed`.
    listed: numbers of cells, row · columns + column, each once, in the order of the visits.
    lost: frames of the plan, counted from 0, that the recording does not hold; cells they belong to drop out.

    Raises `Refusal` where a number is not an integer in range or the order is none of these.
    """

    columns: int
    rows: int
    repeats: int = 1
    first: int = 0
    order: str = "snake"
    lost: tuple[int, ...] = ()
    listed: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        for name, least in (("columns", 1), ("rows", 1), ("repeats", 1), ("first", 0)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
                raise Refusal(f"scan plan: {name} is {value!r}, expected an integer of {least} or more")
            # Plain integers, so that the plan can be written as JSON.
            object.__setattr__(self, name, int(value))
        if self.order not in ORDERS:
            raise Refusal(f"scan plan: order is {self.order!r}, expected {' or '.join(ORDERS)}")
        cells = self.columns * self.rows
        listed = _whole_numbers("listed", self.listed, cells - 1)
        if len(set(listed)) < len(listed) or bool(listed) != (self.order == "listed"):
            raise Refusal(f"scan plan: listed has {len(listed)} cells, expected each once, and only in order 'listed'")
        object.__setattr__(self, "listed", listed)
        if self.planned > MAX_FRAMES:
            raise Refusal(f"scan plan: {self.planned} frames, expected at most {MAX_FRAMES}")
        lost = _whole_numbers("lost", self.lost, self.planned - 1)
        object.__setattr__(self, "lost", tuple(sorted(set(lost))))

    @property
    def visits(self) -> int:
        """Cells of the whole plan."""
        return len(self.listed) or self.columns * self.rows

    @property
    def planned(self) -> int:
        """Frames of the whole plan: those before the grid and `repeats` at each cell."""
        return self.first + self.visits * self.repeats

    @property
    def count(self) -> int:
        """Frames that the recording holds."""
        return self.planned - len(self.lost)

    @cached_property
    def cells(self) -> np.ndarray:
        """(K, 2) column and row of each cell of which all frames are there, in the order of the scan."""
        visited = np.array(self.listed) if self.listed else np.arange(self.columns * self.rows)
        row, column = np.divmod(visited, self.columns)
        if self.order == "snake":
            column = np.where(row % 2 == 1, self.columns - 1 - column, column)
        return np.stack([column, row], axis=1)[self._whole]

    @cached_property
    def frames(self) -> np.ndarray:
        """(K, repeats) indices of the recording's frames taken at each cell."""
        recorded = np.cumsum(self._there) - 1
        return recorded[self.first :].reshape(-1, self.repeats)[self._whole]

    @cached_property
    def _there(self) -> np.ndarray:
        """(planned,) which frames the recording holds."""
        there = np.ones(self.planned, bool)
        there[list(self.lost)] = False
        return there

    @cached_property
    def _whole(self) -> np.ndarray:
        """(visits,) which cells lost no frame."""
        return self._there[self.first :].reshape(-1, self.repeats).all(axis=1)

    def to_meta(self) -> dict[str, Any]:
        """What to add to the meta of a recording so that `from_meta` finds the plan again."""
        return {META_KEY: asdict(self)}

    @staticmethod
    def from_meta(meta: Mapping[str, Any]) -> "ScanPlan | None":
        """The plan that a recording's meta holds, None where it holds none; refuses one that is malformed."""
        if META_KEY not in meta:
            return None
        described = meta[META_KEY]
        if not isinstance(described, Mapping):
            raise Refusal(f"{META_KEY} in meta holds {described!r}, expected columns, rows, repeats, first, order")
        known = set(ScanPlan.__dataclass_fields__)
        strange, missing = set(described) - known, {"columns", "rows"} - set(described)
        if strange or missing:
            wrong = f"has {min(strange)!r}" if strange else f"lacks {min(missing)!r}"
            raise Refusal(f"{META_KEY} in meta {wrong}, expected {', '.join(ScanPlan.__dataclass_fields__)}")
        return ScanPlan(**described)

    @staticmethod
    def parse(text: str) -> "ScanPlan":
        """The plan written as "80x45" (columns x rows), or "80x45x3" with 3 repeats."""
        found = re.fullmatch(r"\s*([0-9]{1,9})x([0-9]{1,9})(?:x([0-9]{1,9}))?\s*", text)
        if not found:
            raise Refusal(f"scan plan {text!r}: expected columns x rows, such as 80x45, or 80x45x3 with repeats")
        return ScanPlan(*(int(number) for number in found.groups(default="1")))


def _whole_numbers(name: str, said: Any, most: int) -> tuple[int, ...]:
    """Numbers from 0 to `most`."""
    if not isinstance(said, list | tuple) or not all(
        isinstance(n, int | np.integer) and not isinstance(n, bool) and 0 <= n <= most for n in said
    ):
        raise Refusal(f"scan plan: {name} is {str(said)[:80]}, expected whole numbers from 0 to {most}")
    return tuple(int(n) for n in said)
