"""Who puts the patch on its holder and takes it off between the passes."""

from collections.abc import Callable
from typing import Protocol


class Holder(Protocol):
    """Shows the patch or hides it."""

    def show(self, patch: bool) -> None:
        """Return once the patch is there (True) or gone."""


class Person:
    """Somebody who is asked, and says when it is done."""

    def __init__(self, ask: Callable[[str], None]) -> None:
        """ask: shows a sentence and returns when it was answered."""
        self._ask = ask

    def show(self, patch: bool) -> None:
        """Ask for it."""
        what = "put the patch on its holder" if patch else "take the patch off its holder, or cover it with the plate"
        self._ask(f"The arm stands still: {what}, leave everything else as it is, and step back.")
