"""A scan as the terminal shows it: a bar with the time left, and sentences above it."""

import sys
import time

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from devices.scan.visit import Seen
from recordings.refusal import Refusal

# Where nobody watches the terminal, a log gets a line this often.
LOG_EVERY_S = 60.0


class ScanProgress:
    """A context in which `saw`, `tell` and `ask` may be called.

    view: hears of every position, too; what goes wrong with it is said once and harms nothing else.
    """

    def __init__(self, view=None) -> None:
        self._console = Console(stderr=True)
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        )
        self._bar = Progress(*columns, console=self._console, disable=not self._console.is_terminal)
        self._task = self._bar.add_task("scanning", total=None)
        self._view, self._logged = view, time.monotonic()

    def __enter__(self) -> "ScanProgress":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def tell(self, sentence: str) -> None:
        """Say what happened, with the time."""
        self._console.print(f"{time.strftime('%H:%M:%S')} {sentence}", highlight=False, soft_wrap=True, markup=False)

    def ask(self, sentence: str) -> None:
        """Ask a person for something, and wait for Enter."""
        if not sys.stdin.isatty():
            raise Refusal(
                f"{sentence.rstrip('.')}: nobody can answer here; run the scan in a terminal, or, if all is ready, "
                "go on with --resume"
            )
        self._bar.stop()
        self.tell(sentence)
        self._console.input("Then press Enter: ")
        self._bar.start()

    def saw(self, seen: Seen) -> None:
        """Show a position."""
        self._bar.update(self._task, completed=seen.done, total=seen.planned, description=seen.sample.pass_name)
        if self._bar.disable and time.monotonic() - self._logged > LOG_EVERY_S:
            self._logged = time.monotonic()
            self.tell(f"{seen.sample.pass_name}: {seen.done} of {seen.planned} positions")
        if self._view is None:
            return
        try:
            disc = seen.patch and (seen.patch.x_px, seen.patch.y_px, seen.patch.radius_px)
            self._view.push(seen.sample.frames[-1].counts, seen.rgb, disc, seen.sample.pass_name)
        except Exception as wrong:  # a picture for people must not end a scan
            self._view = None
            self.tell(f"the live view is off from here on: {wrong}")
