"""Reading what somebody else wrote: whatever a library says about a malformed file becomes one refusal."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from recordings.refusal import Refusal

# What the operating system says about a place (no such file, no permission, is a folder) is said as it is.
ABOUT_THE_PLACE = (FileNotFoundError, PermissionError, IsADirectoryError, NotADirectoryError)


@contextmanager
def reading(path: str | Path, kind: str) -> Iterator[None]:
    """Turn every error that damaged bytes cause in a decoder into `PATH: damaged KIND (reason)`.

    A refusal is passed on, with the file's name before it.
    """
    try:
        yield
    except Refusal as wrong:
        sentence = str(wrong)
        raise Refusal(sentence if sentence.startswith(str(path)) else f"{path}: {sentence}") from None
    except ABOUT_THE_PLACE:
        raise
    except Exception as wrong:  # decoders name neither all their errors nor the bytes at fault
        reason = " ".join(str(wrong).split())[:200] or type(wrong).__name__
        raise Refusal(f"{path}: damaged {kind} ({reason})") from None
