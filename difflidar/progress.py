"""A progress bar on standard error, shown once work has taken two seconds."""

import time
from collections.abc import Iterable
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

PATIENCE_S = 2.0


def bar(items: Iterable[Any], total: int | None, label: str) -> Iterable[Any]:
    """Pass `items` through; where that takes more than two seconds, show how far it is and the time left.

    Nothing is shown where standard error is not a terminal: a log is no place for a bar.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield from items
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    started = time.monotonic()
    shown = Progress(*columns, console=console, transient=True)
    task = shown.add_task(label, total=total)
    try:
        for item in items:
            yield item
            shown.advance(task)
            if not shown.live.is_started and time.monotonic() - started > PATIENCE_S:
                shown.start()
    finally:
        if shown.live.is_started:
            shown.stop()
