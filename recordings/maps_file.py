"""Response maps as a calibration .npz in the published layout."""

import zipfile
from dataclasses import fields
from pathlib import Path

import numpy as np

from recordings.atomic import written_aside
from recordings.maps import ResponseMaps
from recordings.npz_members import members, save_array, text
from recordings.refusal import Refusal
from recordings.untrusted import reading

KIND = ".npz of response maps"
NAMES = tuple(field.name for field in fields(ResponseMaps))
REQUIRED = ("responses", "xs", "ys", "cap_ids")


def load_maps(path: str | Path) -> ResponseMaps:
    """The maps in a calibration file, published or ours; refuses anything but plain arrays of the layout."""
    with reading(path, KIND), zipfile.ZipFile(path) as archive:
        found = members(archive)
        missing = [name for name in REQUIRED if name not in found]
        if missing:
            hint = "; this is a recording, not response maps" if "counts" in found else ""
            raise Refusal(f"{missing[0]} is missing, expected {', '.join(REQUIRED)}{hint}")
        values = {name: found[name].whole(archive) for name in NAMES if name in found}
        if "meta_json" in values:
            values["meta_json"] = text(values["meta_json"], "meta_json")
        return ResponseMaps(**values)


def save_maps(maps: ResponseMaps, path: str | Path) -> None:
    """Write maps to `path`, whole or not at all: responses, xs, ys in float32 as published, the rest as it is."""
    with written_aside(path) as aside, zipfile.ZipFile(aside, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in NAMES:
            value = getattr(maps, name)
            if value is None:
                continue
            array = np.asarray(value)
            if name in ("responses", "xs", "ys"):
                array = array.astype(np.float32)
            save_array(archive, name, array.dtype, array.shape, array)
