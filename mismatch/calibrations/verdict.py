"""The verdict on two calibrations: what makes them disagree, and how well they agree without it."""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from mismatch.verdict import Deviance, Named
from recordings.maps import ResponseMaps

FORMAT = "difflidar-calibrations-verdict/1"


@dataclass(frozen=True)
class Figures:
    """Consistency on positions held out, mean over zones: as `calibrate.consistency` defines it.

    displacement_px: between centroids. one_minus_cosine: of peak-normalised maps. iou: by `thresholds` of the peak.
    """

    displacement_px: float
    one_minus_cosine: float
    thresholds: tuple[float, ...]
    iou: tuple[float, ...]


@dataclass(frozen=True)
class Where:
    """A part of the misfit. zones: indices. positions_px: x from, x to, y from, y to; holds four fifths of it.

    share: of the squared misfit of all zones.
    """

    zones: tuple[int, ...]
    positions_px: tuple[float, float, float, float]
    share: float
    sentence: str


@dataclass(frozen=True, eq=False)
class CalibrationVerdict:
    """What `explain_calibrations` answers.

    verdict: agrees, explained or unknown. effects: strongest first; heldout_gain and expected_gain are robust deviance
    on the positions held out. multiples: how many times each effect's change was found there, 1 if it is the cause.
    seen_as: what can be known of it beyond the difference. before, after: figures at positions held out; floor: what
    the scatter of samples around their neighbours alone would leave. train, heldout: mean of the squared standardised
    difference, each at most 100, of a common gain, of the effects, of noise. scatter: relative standard deviation
    beyond noise, before and after. a, b: both calibrations on common ground, at the positions both have.
    """

    verdict: str
    effects: tuple[Named, ...]
    multiples: tuple[float, ...]
    seen_as: tuple[str, ...]
    located: tuple[Where, ...]
    unexplained: tuple[Where, ...]
    train: Deviance
    heldout: Deviance
    gap_closed: float | None
    before: Figures
    after: Figures
    floor: Figures
    scatter: tuple[float, float]
    positions: tuple[int, int]
    a: ResponseMaps
    b: ResponseMaps
    notes: tuple[str, ...] = field(default=())

    def to_json(self) -> dict[str, Any]:
        """As the file holds it; the maps go into files of their own."""
        effects = [
            asdict(effect) | {"multiple_on_heldout": multiple, "seen_as": seen}
            for effect, multiple, seen in zip(self.effects, self.multiples, self.seen_as, strict=True)
        ]
        return {
            "format": FORMAT,
            "verdict": self.verdict,
            "effects": effects,
            "located": [asdict(one) for one in self.located],
            "unexplained": [asdict(one) for one in self.unexplained],
            "fit": {"train": asdict(self.train), "heldout": asdict(self.heldout), "gap_closed": self.gap_closed},
            "consistency": {name: asdict(getattr(self, name)) for name in ("before", "after", "floor")},
            "scatter": {"before": self.scatter[0], "after": self.scatter[1]},
            "positions": {"fitted": self.positions[0], "heldout": self.positions[1]},
            "notes": list(self.notes),
        }

    def text(self) -> str:
        """JSON, with what no number says as null."""
        return json.dumps(_plain(self.to_json()), indent=1, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """Numbers of Python, None where they are not finite."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
