"""The records of a stream of pickles, one by one, as plain data."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from recordings.importers.inert.makers import MAKERS, StandIn
from recordings.importers.inert.reader import BoundedReader
from recordings.importers.inert.unpickler import PUBLISHERS, Global, InertUnpickler, Noted
from recordings.refusal import Refusal

UNFOLDED_LIMIT = 1_000_000
ITSELF = object()


def records(path: Path, reader: BoundedReader) -> Iterator[Any]:
    """Each whole pickle of the stream as `revived` gives it; `EOFError` says where the last one is cut off.

    `Refusal` names the record and the byte it starts at where one asks for more than data or is none.
    """
    number = 0
    while reader.position < reader.size:
        reader.start_record()
        where = f"{path}: record {number} at byte {reader.record_start}"
        try:
            record = revived(InertUnpickler(reader).load())
        except EOFError as wrong:
            raise EOFError(f"record {number} at byte {reader.record_start} is cut off: it {wrong}") from None
        except Refusal as wrong:
            raise Refusal(f"{where} {wrong}; nothing of it was run") from None
        except Exception as wrong:  # damaged bytes make the interpreter of pickles fail in any way
            raise Refusal(f"{where} is not a pickle of data ({type(wrong).__name__}: {wrong!s:.100})") from None
        yield record
        number += 1


def revived(value: Any) -> Any:
    """`value` with arrays as `StoredArray`, numpy scalars as numbers and publisher's objects as `StandIn`.

    `Refusal` where something is neither, or contains itself.
    """
    done: dict[int, tuple[Any, int]] = {}
    unfolded = 0

    def revive(value: Any) -> Any:
        nonlocal unfolded
        before, known = unfolded, None
        if isinstance(value, Noted | dict | list | tuple | set | frozenset):
            if id(value) in done:
                known, size = done[id(value)]
                unfolded += size
            else:
                done[id(value)] = ITSELF, 0
                known = rebuilt(value, revive)
                unfolded += 1
                done[id(value)] = known, unfolded - before
        else:
            unfolded += 1
            known = StandIn(value.name, ()) if isinstance(value, Global) else value
        # Shared parts are revived once, but a walk through them meets each as often as it is named.
        if unfolded > UNFOLDED_LIMIT or known is ITSELF:
            raise Refusal(f"contains itself or unfolds to more than {UNFOLDED_LIMIT} values")
        return known

    try:
        return revive(value)
    except (TypeError, RecursionError) as wrong:
        raise Refusal(f"is no record of data ({type(wrong).__name__})") from None


def rebuilt(value: Any, revive: Callable[[Any], Any]) -> Any:
    """One container or noted call with everything in it revived."""
    if isinstance(value, dict):
        return {revive(key): revive(item) for key, item in value.items()}
    if not isinstance(value, Noted):
        return type(value)(revive(item) for item in value)
    if value.name.split(".")[0] in PUBLISHERS:
        return StandIn(value.name, revive(value.args), revive(value.state))
    try:
        return MAKERS[value.name.rpartition(".")[2]](revive(value.args), value.state and revive(value.state))
    except Refusal:
        raise
    except (ValueError, TypeError, KeyError, OverflowError, AttributeError):
        raise Refusal(f"calls {value.name} in a way that makes no array or number") from None
