"""The frames of a TMF8820 JSON file, checked: histograms, poses, distances, and all else they report."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recordings.refusal import Refusal
from recordings.relations import check_rigid

PLACES = ("pose", "dist_to_plane")
COUNT_LIMIT = 1 << 32
# Far beyond what the sensor sees, near enough for float32.
FARTHEST_M = 1e4
# The publishers left the last row of some poses empty.
LAST_ROWS = ([0, 0, 0, 0], [0, 0, 0, 1])


@dataclass(frozen=True, eq=False)
class Tmf8820Frames:
    """What F frames of a file hold.

    counts: (F, P, T) uint32. pose: (F, 4, 4) world from sensor, or None. distance_m: (F,) to a plane, or
    None. reported: everything else the file says, by field, a list of F values each; `on_chip` by field in
    turn.
    """

    counts: np.ndarray
    pose: np.ndarray | None
    distance_m: np.ndarray | None
    reported: dict[str, Any]


def read_frames(path: Path) -> Tmf8820Frames:
    """The frames of a file; `Refusal` names the frame and the field at fault."""
    frames = read_json(path)
    if not isinstance(frames, list) or not frames or not all(isinstance(frame, dict) for frame in frames):
        raise Refusal(f"{path}: is not a list of frames, expected [{{...}}, ...] with `hists` in each")
    names = dict.fromkeys(name for frame in frames for name in frame)
    for name in ("hists", *(name for name in PLACES if name in names)):
        lacking = next((i for i, frame in enumerate(frames) if name not in frame), None)
        if lacking is not None:
            raise Refusal(f"{path}: frame {lacking} has no {name}, expected it in every frame")
    fields = {name: [frame.get(name) for frame in frames] for name in names}
    pose = poses(path, fields.pop("pose")) if "pose" in fields else None
    distance = distances(path, fields["dist_to_plane"]) if "dist_to_plane" in fields else None
    counts = histograms(path, fields.pop("hists"))
    return Tmf8820Frames(counts, pose, distance, reported(path, fields))


def read_json(path: Path) -> Any:
    """What a JSON file holds."""
    try:
        return json.loads(path.read_bytes())
    except (ValueError, RecursionError) as wrong:
        raise Refusal(f"{path}: is not JSON ({wrong or 'nested too deeply'})") from None


def numbers(path: Path, field: str, values: list[Any], shape: str, axes: int) -> np.ndarray:
    """`values` as one array of finite numbers; refuses a frame that is not, or not shaped as the first."""
    arrays = []
    for frame, value in enumerate(values):
        try:
            array = np.asarray(value)
        except ValueError:
            array = np.asarray(None)
        if array.dtype.kind not in "iuf" or array.ndim != axes or 0 in array.shape:
            raise Refusal(f"{path}: frame {frame}: {field} is no array of numbers of shape {shape}")
        if arrays and array.shape != arrays[0].shape:
            expected = f"{arrays[0].shape} as in frame 0"
            raise Refusal(f"{path}: frame {frame}: {field} has shape {array.shape}, expected {expected}")
        arrays.append(array)
    array = np.stack(arrays)
    refuse_where(path, field, array, ~np.isfinite(array), "a finite number")
    return array


def refuse_where(path: Path, field: str, array: np.ndarray, bad: np.ndarray, expected: str) -> None:
    """Refuse the first value marked bad, by frame and index."""
    if bad.any():
        frame, *index = (int(i) for i in np.argwhere(bad)[0])
        place = f"{field}{index}" if index else field
        raise Refusal(f"{path}: frame {frame}: {place} is {array[(frame, *index)]}, expected {expected}")


def histograms(path: Path, values: list[Any]) -> np.ndarray:
    """(F, P, T) uint32 photon counts."""
    counts = numbers(path, "hists", values, "(zones, bins)", 2)
    bad = (counts < 0) | (counts >= COUNT_LIMIT) | (counts != np.floor(counts))
    refuse_where(path, "hists", counts, bad, f"a whole count of 0 or more, below {COUNT_LIMIT}")
    return counts.astype(np.uint32)


def poses(path: Path, values: list[Any]) -> np.ndarray:
    """(F, 4, 4) rigid transforms with their last row made 0 0 0 1."""
    pose = numbers(path, "pose", values, "(4, 4)", 2).astype(float)
    if pose.shape[1:] != (4, 4):
        raise Refusal(f"{path}: frame 0: pose has shape {pose.shape[1:]}, expected (4, 4)")
    place = pose[:, :3, 3]
    refuse_where(path, "pose translation", place, np.abs(place) > FARTHEST_M, f"at most {FARTHEST_M:.0f} metres")
    last = pose[:, 3].tolist()
    wrong = next((frame for frame, row in enumerate(last) if row not in LAST_ROWS), None)
    if wrong is not None:
        raise Refusal(f"{path}: frame {wrong}: pose ends in the row {last[wrong]}, expected 0 0 0 1 or 0 0 0 0")
    pose[:, 3] = 0, 0, 0, 1
    for frame, one in enumerate(pose):
        check_rigid(f"{path}: frame {frame}: pose", one)
    return pose


def distances(path: Path, values: list[Any]) -> np.ndarray:
    """(F,) metres to the plane."""
    metres = numbers(path, "dist_to_plane", values, "()", 0).astype(float)
    bad = (metres < 0) | (metres > FARTHEST_M)
    refuse_where(path, "dist_to_plane", metres, bad, f"metres of 0 to {FARTHEST_M:.0f}")
    return metres


def reported(path: Path, fields: dict[str, list[Any]]) -> dict[str, Any]:
    """What a recording has no array for, as plain JSON; on-chip results become a list for each field."""
    for name, values in fields.items():
        for frame, value in enumerate(values):
            try:
                json.dumps(value, allow_nan=False)
            except (ValueError, RecursionError):
                raise Refusal(f"{path}: frame {frame}: {name} holds NaN or infinity, expected numbers") from None
    chip = fields.get("distances", [])
    single = all(isinstance(one, list) and len(one) == 1 and isinstance(one[0], dict) for one in chip)
    if chip and single and len({tuple(one[0]) for one in chip}) == 1:
        on_chip = {name: [one[0][name] for one in chip] for name in chip[0][0]}
        fields = {name: values for name, values in fields.items() if name != "distances"} | {"on_chip": on_chip}
    if "reference_hist" in fields:
        fields["reference_counts"] = fields.pop("reference_hist")
    return fields
