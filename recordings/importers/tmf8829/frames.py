"""The frames of a TMF8829's log, checked: histograms, and the distances the chip found in them."""

import gzip
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recordings.importers.tmf8820.frames import COUNT_LIMIT, numbers, refuse_where
from recordings.refusal import Refusal
from recordings.untrusted import reading

# The makers' readme and their code call them differently; in dual mode those of high accuracy have a name of their own.
ZONES = ("mp_histo", "mp_hist", "mp_histo_HA", "mp_hist_HA")
REFERENCE = ("ref_histo", "ref_hist", "ref_histo_HA", "ref_hist_HA")
GZIP = b"\x1f\x8b"
LARGEST = 1 << 30
METRES_PER_UNIT = 0.25e-3


@dataclass(frozen=True, eq=False)
class Tmf8829Frames:
    """F frames of a log.

    counts: (F, rows, columns, T) uint32. distance_m: (F, rows, columns) of the first peak, NaN where there is none.
    histograms: the name they were found by. reference: a list for each frame, or None. info: of each frame. besides:
    what the log says of all. left_out: the numbers of frames without histograms.
    """

    counts: np.ndarray
    distance_m: np.ndarray
    histograms: str
    reference: list[Any]
    info: list[Any]
    besides: dict[str, Any]
    left_out: list[int]


def unpacked(path: Path) -> bytes:
    """What a file holds, unpacked where it is packed."""
    with path.open("rb") as file:
        packed = file.read(2) == GZIP
    with reading(path, "log (.json.gz)"), gzip.open(path) if packed else path.open("rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise Refusal(f"{path}: holds more than {LARGEST} bytes, expected a smaller log; split it")
    return content


def read_frames(path: Path) -> Tmf8829Frames:
    """The frames with histograms; `Refusal` names the frame and field at fault, or the line where JSON ends."""
    try:
        log = json.loads(unpacked(path))
    except (ValueError, RecursionError) as wrong:
        raise Refusal(f"{path}: is not JSON ({wrong or 'nested too deeply'})") from None
    sets = log.get("Result_Set") if isinstance(log, dict) else None
    if not isinstance(sets, list) or not all(isinstance(one, dict) for one in sets):
        raise Refusal(f"{path}: has no list of frames under Result_Set, expected {{...}} for each")
    name = next((name for name in ZONES if any(name in one for one in sets)), None)
    if name is None:
        raise Refusal(f"{path}: no frame holds histograms, expected {' or '.join(ZONES[:2])}; switch them on")
    kept = [one for one in sets if name in one]
    values = [bins_of(one[name]) for one in kept]
    counts = numbers(path, name, values, "(rows, columns, bins)", 3)
    bad = (counts < 0) | (counts >= COUNT_LIMIT) | (counts != np.floor(counts))
    refuse_where(path, name, counts, bad, f"a whole count of 0 or more, below {COUNT_LIMIT}")
    reference = next((other for other in REFERENCE if other in kept[0]), None)
    return Tmf8829Frames(
        counts=counts.astype(np.uint32),
        distance_m=np.stack([distances(one.get("results"), counts.shape[1:3]) for one in kept]),
        histograms=name,
        reference=[one.get(reference) for one in kept],
        info=[one.get("info") for one in kept],
        besides={what: log[what] for what in ("configuration", "info", "device") if what in log},
        left_out=[i for i, one in enumerate(sets) if name not in one],
    )


def bins_of(rows: Any) -> Any:
    """[row][column] of `{"bin": [...]}` as plain lists; whatever else is there as it is, to be refused."""
    try:
        return [[zone["bin"] for zone in row] for row in rows]
    except (TypeError, KeyError):
        return None


def distances(rows: Any, shape: tuple[int, ...]) -> np.ndarray:
    """(rows, columns) metres of the first peak, NaN where there is none; all NaN where the results are others."""
    metres = np.full(shape, np.nan)
    try:
        for row, column in np.ndindex(*shape):
            peaks = rows[row][column]["peaks"]
            if peaks and peaks[0]["distance"] > 0:
                metres[row, column] = peaks[0]["distance"] * METRES_PER_UNIT
    except (TypeError, KeyError, IndexError):
        return np.full(shape, np.nan)
    return metres
