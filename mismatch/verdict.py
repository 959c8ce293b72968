"""The Verdict: how a recording and its simulation differ, as the verdict format says."""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from mismatch.places import Place

FORMAT = "difflidar-verdict/1"


@dataclass(frozen=True)
class Estimate:
    """A parameter: value and standard deviation, in its unit."""

    name: str
    value: float
    sigma: float
    unit: str


@dataclass(frozen=True)
class Alternative:
    """Another effect that may be the cause instead. separated_by: the capture that would tell."""

    id: str
    probability: float
    separated_by: str


@dataclass(frozen=True)
class Named:
    """An effect that is there. heldout_gain, expected_gain: deviance that it gains on the frames held out, and what it
    should gain there if it is the cause. p_value: after correction for the number of effects tried. scatter: standard
    deviation of such a gain from recording to recording, None where nobody asked."""

    id: str
    sentence: str
    parameters: tuple[Estimate, ...]
    heldout_gain: float
    p_value: float
    expected_gain: float
    look_alikes: tuple[Alternative, ...] = ()
    scatter: float | None = None


@dataclass(frozen=True)
class Deviance:
    """Poisson deviance per cell: of the nominal model, of the explained one, and what the data's own noise allows."""

    nominal: float
    explained: float
    floor: float


@dataclass(frozen=True)
class NotVisible:
    """An effect that was not found, and the strength at which it would have been."""

    id: str
    smallest_visible: float
    unit: str


@dataclass(frozen=True)
class Verdict:
    """What `explain` answers; fields as the verdict format says. notes: what was assumed or could not be judged."""

    verdict: str
    located: tuple[Place, ...]
    effects: tuple[Named, ...]
    train: Deviance
    heldout: Deviance
    gap_closed: float | None
    unexplained: tuple[Place, ...]
    not_visible: tuple[NotVisible, ...]
    next_measurement: str | None
    seconds: float = 0.0
    notes: tuple[str, ...] = field(default=())

    def to_json(self) -> dict[str, Any]:
        """As the file holds it."""
        return {
            "format": FORMAT,
            "verdict": self.verdict,
            "located": [_place(place) for place in self.located],
            "effects": [_effect(effect) for effect in self.effects],
            "fit": {"train": asdict(self.train), "heldout": asdict(self.heldout), "gap_closed": self.gap_closed},
            "unexplained": [_place(place) for place in self.unexplained],
            "not_visible": [asdict(one) for one in self.not_visible],
            "next_measurement": self.next_measurement,
            "notes": list(self.notes),
            "seconds": self.seconds,
        }

    def text(self) -> str:
        """JSON, with what no number says as null."""
        return json.dumps(_plain(self.to_json()), indent=1, allow_nan=False) + "\n"


def _effect(effect: Named) -> dict[str, Any]:
    """An effect as the file holds it, which has no field for how gains scatter."""
    return {name: value for name, value in asdict(effect).items() if name != "scatter"}


def _place(place: Place) -> dict[str, Any]:
    """A place as the file holds it."""
    return {
        "zones": list(place.zones),
        "bins": list(place.bins),
        "frames": list(place.frames),
        "follows": place.follows,
        "share_of_misfit": place.share,
        "p_value": place.p_value,
        "sentence": place.sentence,
    }


def _plain(value: Any) -> Any:
    """Numbers of Python, None where they are not finite."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
