"""Kinds of values on the command line that several commands take."""

from typing import Any

import click


class Numbers(click.ParamType):
    """A fixed number of numbers with a separator, such as 15:35 or 0.02,0,0."""

    name = "numbers"

    def __init__(self, kind: type, count: int, separator: str):
        self.kind, self.count, self.separator = kind, count, separator

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """How the value is shown in the help page."""
        return self.separator.join(["N"] * self.count)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple:
        """The numbers as a tuple; refused in one sentence where they are something else."""
        if isinstance(value, tuple):
            return value
        try:
            numbers = tuple(self.kind(part) for part in value.split(self.separator))
        except ValueError:
            numbers = ()
        if len(numbers) != self.count:
            self.fail(
                f"{value!r} found, expected {self.count} numbers such as {self.get_metavar(param)}",
                param,
                ctx,
            )
        return numbers
