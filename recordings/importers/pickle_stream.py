"""Importer of the published capture scripts' file: a stream of pickles, the metadata, then one a capture.

Layout after the scripts released with Behari & Raskar 2026, "Spatial Calibration of Diffuse LiDARs". The file
is gone through twice: once for what its records hold, passing over the arrays, then capture by capture.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from recordings.head import head
from recordings.importers.capture.meta_json import described
from recordings.importers.capture.metadata import BIN_WIDTH_S, TIME_ZERO_BINS, pinhole, range_mode
from recordings.importers.capture.survey import Survey, surveyed
from recordings.refusal import Refusal
from recordings.stream import Stream

PICKLE_PROTOCOLS = (2, 3, 4, 5)
METRES_PER_DEPTH_UNIT = np.float32(1e-3)


def reads(path: Path) -> bool:
    """Whether the file starts as a binary pickle does."""
    began = head(path, 2)
    return len(began) == 2 and began[0] == 0x80 and began[1] in PICKLE_PROTOCOLS


def stream(path: Path) -> Stream:
    """The captures of the file as a stream, in the order of their iterations.

    Captures that lack what the first one has, and a last record that is cut off, are left out and listed in
    the metadata. `Refusal` where a record asks for anything but data, or no whole capture is there.
    """
    survey = surveyed(path)
    first = survey.captures[0]
    mode = range_mode(survey.metadata) or "LONG"
    static: dict[str, Any] = {
        "zone_grid": np.array(first.zone_grid),
        "bin_width_s": np.array(BIN_WIDTH_S[mode]),
        "time_zero_s": np.array(TIME_ZERO_BINS[mode] * BIN_WIDTH_S[mode]),
        "meta_json": json.dumps(described(survey)),
    }
    image = first.colour or first.depth
    if image:
        height, width = image.shape[:2]
        static["image_size"] = np.array([width, height])
        matrix = pinhole(survey.metadata, height, width)
        if matrix is not None:
            static["intrinsics"] = matrix
    return Stream(static=static, frames=frames(path, survey), count=len(survey.captures))


def frames(path: Path, survey: Survey) -> Iterator[dict[str, Any]]:
    """The per-frame fields of each capture, read from the file one at a time."""
    times = survey.times_s or range(len(survey.captures))
    with path.open("rb") as file:
        for one, time_s in zip(survey.captures, times, strict=True):
            counts = one.histogram.read(file).reshape(-1, one.histogram.shape[-1])
            if counts.min() < 0:
                zone, at = np.argwhere(counts < 0)[0]
                place = f"record {one.number}, zone {zone}, bin {at}"
                raise Refusal(f"{path}: {place} counts {counts[zone, at]}, expected 0 or more")
            frame: dict[str, Any] = {"timestamp_s": float(time_s)}
            frame["counts"] = counts.astype(f"u{counts.itemsize}")
            if one.colour:
                # The scripts set the camera to bgr8.
                frame["rgb"] = np.ascontiguousarray(one.colour.read(file)[..., ::-1])
            if one.depth:
                depth = one.depth.read(file)
                frame["depth_m"] = np.where(depth > 0, depth * METRES_PER_DEPTH_UNIT, np.float32(np.nan))
            yield frame
