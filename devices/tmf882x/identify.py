"""Who is at the other end of the port."""

import re
import time

from devices.tmf882x.dialogue import PATIENCE_S, TRIES, ask, listen
from devices.tmf882x.reader import Reader
from recordings.refusal import Refusal

# Any of them will do, since lines get lost.
HELP_LINES = {"TMF8828 Arduino Driver", "UART commands", "z ... histogram", "# ... reset"}
RANGE_LINE = re.compile(r"Active range:\s*(?:0x)?6([EF])")
# A board that resets when its port opens is deaf for up to two seconds: it is asked again and again.
ASK_AGAIN_S = 0.5
# After a stop, firmware that takes commands prints at most what was on its way: not as many lines, and not for so long.
FREE_AFTER_S, FREE_AFTER_LINES = 1.0, 62
COMMANDS, FREE_RUNNING = "ams Arduino driver", "free-running (UW Graphics)"


def identify(reader: Reader, port: str, baud: int, patience_s: float) -> tuple[str, str | None]:
    """The kind of firmware and, if it says so by itself, its range mode; measuring is stopped if it can be.

    `Refusal` where there is something else, or nothing that can be understood.
    """
    began = time.monotonic()
    lines_before = reader.data_lines
    ranging = None
    while (now := time.monotonic()) < began + patience_s:
        reader.write(b"s")
        until = min(now + ASK_AGAIN_S, began + patience_s)
        while (text := reader.next_text(until)) is not None:
            if " state=" in text:
                return _with_commands(reader, port), None
            if (said := RANGE_LINE.fullmatch(text)) is not None:
                ranging = {"E": "short", "F": "long"}[said[1]]
        running = reader.data_lines - lines_before >= FREE_AFTER_LINES and now > began + FREE_AFTER_S
        if ranging is not None or running:
            return FREE_RUNNING, ranging
    if reader.data_lines - lines_before > reader.noise_bytes:
        return FREE_RUNNING, None
    raise Refusal(f"lidar.port {port}: {_why(reader, baud)}")


def _with_commands(reader: Reader, port: str) -> str:
    """Answers to several stops may be on their way; they come before the help."""
    for _ in range(TRIES):
        reader.forget_texts()
        reader.write(b"h")
        until = time.monotonic() + PATIENCE_S
        while (answer := listen(reader, until)) is not None:
            if HELP_LINES.intersection(answer.lines):
                ask(reader, "s")
                return COMMANDS
    raise Refusal(
        f"lidar.port {port}: what answers is not the {COMMANDS} for the TMF8828, it gives no help as that does; load "
        "that firmware onto the board, or name another port"
    )


def _why(reader: Reader, baud: int) -> str:
    if reader.noise_bytes:
        return (
            f"noise comes at {baud} baud, so the board runs at another speed; correct lidar.baud (2000000 for the "
            "reference firmware, 1000000 for older and UW Graphics' firmware)"
        )
    if reader.text_lines:
        return (
            "what is there prints text but no TMF882x; load the sensor's firmware onto the board, or name another port"
        )
    return (
        f"nothing answers at {baud} baud; see whether this is the sensor's port, whether lidar.baud is the firmware's, "
        "and whether the board has power and its firmware"
    )
