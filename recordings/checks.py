"""What a recording and response maps must satisfy; each refusal is one sentence."""

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from recordings.fields import FIELDS, MAP_FIELDS
from recordings.one_field import checked
from recordings.refusal import Refusal
from recordings.relations import check_relations

if TYPE_CHECKING:
    from recordings.maps import ResponseMaps
    from recordings.recording import Recording


def check_recording(recording: "Recording") -> None:
    """Refuse a recording that breaks a rule of the format; set its arrays to plain ones of the same values."""
    sizes: dict[str, int] = {}
    values = {}
    for name, field in FIELDS.items():
        values[name] = getattr(recording, name)
        if values[name] is not None or field.required:
            values[name] = checked(name, values[name], field, sizes)
    values["counts"] = unsigned(values["counts"])
    check_relations(values, sizes)
    check_json("meta_json", recording.meta_json)
    for name, value in values.items():
        object.__setattr__(recording, name, value)


def unsigned(counts: np.ndarray) -> np.ndarray:
    """Counts that were found not to be negative, as the unsigned type of the same width."""
    return counts.astype(f"u{counts.dtype.itemsize}", copy=False)


def check_json(name: str, text: Any) -> dict[str, Any]:
    """The object that JSON `text` holds; refuses anything else."""
    if not isinstance(text, str):
        raise Refusal(f"{name} is {type(text).__name__}, expected JSON text")
    try:
        text.encode()
        value = json.loads(text)
    except (ValueError, RecursionError) as wrong:
        raise Refusal(f"{name} is not JSON text ({wrong}), expected a JSON object") from None
    if not isinstance(value, dict):
        raise Refusal(f"{name} holds a JSON {type(value).__name__}, expected a JSON object")
    return value


def check_maps(maps: "ResponseMaps") -> None:
    """Refuse response maps that break a rule of the published layout; set their arrays to plain ones."""
    sizes: dict[str, int] = {}
    for name, field in MAP_FIELDS.items():
        value = getattr(maps, name)
        if value is not None or field.required:
            object.__setattr__(maps, name, checked(name, value, field, sizes))
    ids = np.asarray(maps.cap_ids)
    if ids.dtype.kind != "U" or ids.shape != (sizes["K"],):
        there = f"{ids.dtype.name} of shape {ids.shape}"
        raise Refusal(f"cap_ids holds {there}, expected text of shape ({sizes['K']},)")
    object.__setattr__(maps, "cap_ids", ids)
    size = check_json("meta_json", maps.meta_json).get("image_size", [1, 1])
    pixels = isinstance(size, list) and len(size) == 2 and all(type(n) is int and n > 0 for n in size)
    if not pixels:
        raise Refusal(f"meta_json gives image_size {size}, expected width and height of 1 or more pixels")
