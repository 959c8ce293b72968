"""What a recording or a file of response maps holds, in a few plain figures."""

from typing import Any

import numpy as np

from recordings.maps import ResponseMaps
from recordings.recording import Recording

LIGHT_M_S = 299_792_458.0
# With these in their meta, maps are rays in space; without one of them they are true at one distance only.
IN_SPACE = ("intrinsics", "lidar_from_camera", "calibration_range_m")


def describe_recording(recording: Recording) -> dict[str, Any]:
    """Figures of a recording, ready for JSON; `bin_width_mm` is range, half of what light travels in a bin."""
    frames, zones, bins = recording.counts.shape
    times = np.asarray(recording.timestamp_s, float)
    duration = float(times[-1] - times[0])
    width = float(recording.bin_width_s)
    present = dict(recording.present())
    meta = recording.meta
    return {
        "kind": "recording",
        "sensor": meta.get("sensor"),
        "zone_grid": [int(n) for n in recording.zone_grid],
        "zones": zones,
        "bins": bins,
        "bin_width_ps": width * 1e12,
        "bin_width_mm": width * LIGHT_M_S / 2 * 1e3,
        "frames": frames,
        "duration_s": duration,
        "rate_hz": (frames - 1) / duration if duration > 0 else None,
        "fields": {name: array(value) for name, value in present.items() if name != "meta_json"},
        "absent": [name for name in recording.__dataclass_fields__ if name not in present],
        "meta": meta,
    }


def describe_maps(maps: ResponseMaps) -> dict[str, Any]:
    """Figures of response maps, ready for JSON."""
    rows, columns = maps.zone_grid
    missing = [name for name in IN_SPACE if name not in maps.meta]
    fields = {name: getattr(maps, name) for name in maps.__dataclass_fields__ if name != "meta_json"}
    return {
        "kind": "response maps",
        "sensor": maps.meta.get("sensor"),
        "zone_grid": [rows, columns],
        "zones": rows * columns,
        "positions": len(maps.xs),
        "extent_x_px": [float(maps.xs.min()), float(maps.xs.max())],
        "extent_y_px": [float(maps.ys.min()), float(maps.ys.max())],
        "image_size": list(maps.image_size),
        "image_plane_only": bool(missing),
        "missing_for_space": missing,
        "fields": {name: array(value) for name, value in fields.items() if value is not None},
        "meta": maps.meta,
    }


def array(value: Any) -> dict[str, Any]:
    """Type, shape and size in memory of an array or of frames read on demand."""
    kind = "text" if value.dtype.kind == "U" else value.dtype.name
    return {"type": kind, "shape": [int(n) for n in value.shape], "bytes": int(value.nbytes)}
