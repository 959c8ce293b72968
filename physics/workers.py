"""Work on all cores; the kernels let go of the interpreter while they run."""

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

# Items are handed over in so many parcels for each core: few enough to cost nothing, enough to end together.
PARCELS = 4
_inside = threading.local()


def in_parallel(work: Callable[[Item], Result], items: Iterable[Item], *, singly: bool = False) -> list[Result]:
    """What `work` gives for each item, in order; the first error is raised. Within `work` it goes one by one.

    singly: items are handed over one at a time, for few that take long and differ in how long.
    """
    items = list(items)
    cores = _cores()
    if min(cores, len(items)) < 2 or getattr(_inside, "working", False):
        return [work(item) for item in items]
    size = 1 if singly else -(-len(items) // (PARCELS * cores))
    parcels = [items[at : at + size] for at in range(0, len(items), size)]

    def one(parcel: list[Item]) -> list[Result]:
        _inside.working = True
        return [work(item) for item in parcel]

    return [result for done in _pool(os.getpid(), cores).map(one, parcels) for result in done]


def in_slices(work: Callable[[slice], None], count: int) -> None:
    """Work on slices of so many things, on all cores: all at once within other work, which keeps to its own core."""
    parts = 1 if getattr(_inside, "working", False) else min(PARCELS * _cores(), count)
    ends = [count * i // max(parts, 1) for i in range(parts + 1)]
    in_parallel(work, [slice(*ends[i : i + 2]) for i in range(parts)], singly=True)


def _cores() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool(process: int, cores: int) -> ThreadPoolExecutor:
    """The threads of this process; one that was forked has none of its parent's."""
    return ThreadPoolExecutor(cores)
