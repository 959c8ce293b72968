"""Commands of the reference firmware, one character each, and their answers: they end in the line of the state."""

import re
import time
from dataclasses import dataclass

from devices.captures import DeviceLost
from devices.tmf882x.reader import Reader

STATE = re.compile(r"TMF88(28|2x) state=(disabled|standby|stopped|measure|error)")
PATIENCE_S = 3.0
# Commands that take their time: the image is downloaded over I2C, a calibration fires 4 x 4 million shots.
SLOW_S = {"e": 20.0, "E": 20.0, "f": 30.0, "l": 10.0, "r": 10.0, "a": 10.0}
# Commands that do no more when they are given twice, so that they can be given again where no answer came.
REPEATABLE = "adhlmrs"
TRIES = 3


class NoAnswer(DeviceLost):
    """A command was not answered."""


@dataclass(frozen=True)
class Answer:
    """What was printed before the line of the state, and what that says: the mode and the state."""

    lines: tuple[str, ...]
    mode_8828: bool
    state: str

    @property
    def errors(self) -> list[str]:
        """The lines that report errors."""
        return [line for line in self.lines if line.startswith("#Err")]

    def matching(self, pattern: re.Pattern[str]) -> re.Match[str] | None:
        """The last line that is as `pattern` says."""
        return next((match for line in reversed(self.lines) if (match := pattern.fullmatch(line))), None)


def ask(reader: Reader, command: str, *, state: str | None = None) -> Answer:
    """Give a command, return its answer; `NoAnswer` if none came, or it never comes to be in `state`."""
    slow_s = max(PATIENCE_S, SLOW_S.get(command, 0.0))
    for _ in range(TRIES if command in REPEATABLE else 1):
        reader.forget_texts()
        reader.write(command.encode("ascii"))
        # An answer that has begun goes on without a pause, but for the calibration, which is announced first.
        answer = listen(reader, time.monotonic() + slow_s, slow_s if command == "f" else PATIENCE_S)
        if answer is not None and state in (None, answer.state):
            return answer
    said = "nothing" if answer is None else f"state={answer.state}"
    raise NoAnswer(f"the LiDAR answered the command {command!r} with {said}")


def listen(reader: Reader, until: float, pause_s: float = float("inf")) -> Answer | None:
    """What is said up to the next line of the state; None if that does not come in time, or a pause comes before it."""
    lines: list[str] = []
    pause = until
    while (text := reader.next_text(min(until, pause))) is not None:
        if (state := STATE.fullmatch(text)) is not None:
            return Answer(tuple(lines), state[1] == "28", state[2])
        lines.append(text)
        pause = time.monotonic() + pause_s
    return None
