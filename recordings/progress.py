"""How long work reports that it advances, without knowing who listens."""

from collections.abc import Callable, Iterable
from typing import Any

# (items, how many there are or None, what is being done) -> the same items, watched as they pass.
Progress = Callable[[Iterable[Any], int | None, str], Iterable[Any]]


def silent(items: Iterable[Any], total: int | None, label: str) -> Iterable[Any]:
    """Nobody listens."""
    return items
