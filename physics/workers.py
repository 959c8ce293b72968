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
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if min(cores, len(items)) < 2 or getattr(_inside, "working", False):
        return [work(item) for item in items]
    size = 1 if singly else -(-len(items) // (PARCELS * cores))
    parcels = [items[at : at + size] for at in range(0, len(items), size)]

    def one(parcel: list[Item]) -> list[Result]:
        _inside.working = True
        return [work(item) for item in parcel]

    return [result for done in _pool(os.getpid(), cores).map(one, parcels) for result in done]


@cache
def _pool(process: int, cores: int) -> ThreadPoolExecutor:
    """The threads of this process; one that was forked has none of its parent's."""
    return ThreadPoolExecutor(cores)
