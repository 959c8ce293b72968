"""A finished scan as recordings: with the patch, without it, and what the monitor pose saw."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from calibrate.plan import ScanPlan
from calibrate.rig import Rig, rig_from
from devices.rig_static import rig_meta, rig_static
from devices.scan.clocks import clocks_apart
from devices.scan.drift import drift
from devices.scan.journal import Journal, Sample
from devices.scan.motion_plan import MotionPlan, plan_from
from recordings.files import save
from recordings.progress import Progress, silent
from recordings.stream import Stream

# Clocks are set back now and then; frames of a recording never are.
LEAST_STEP_S = 1e-6


def written_paths(out: Path) -> dict[str, Path]:
    """Pass name -> the file of that pass."""
    return {"patch": out} | {name: out.with_name(f"{out.stem}-{name}.rrd") for name in ("background", "monitor")}


def export(journal: Journal, out: Path, progress: Progress = silent) -> dict[str, Path]:
    """Write the recordings of a journal; pass name -> file, for the passes that were seen."""
    plan, rig = plan_from(journal.said("plan")), rig_from(journal.said("rig"))
    cells = {name: journal.cells(name) for name in ("patch", "background", "monitor")}
    if cells["background"]:
        # A calibration pairs captures with and without the patch by their order.
        both = set(cells["background"])
        cells["patch"] = cells["background"] = [cell for cell in cells["patch"] if cell in both]
    written = {}
    for name, path in written_paths(out).items():
        if cells[name]:
            save(_recording(journal, name, cells[name], plan, rig), path, progress)
            written[name] = path
    return written


def _recording(journal: Journal, name: str, cells: list[int], plan: MotionPlan, rig: Rig) -> Stream:
    """The frames of a pass at these cells, in this order."""
    said = {device: journal.said(device) or {} for device in ("lidar", "camera", "arm")}
    devices = said["lidar"], said["camera"]
    meta = rig_meta(rig, *devices, "scan") | {
        "scan_pass": name,
        "patch_depth_m": rig.patch_distance_m,
        "patch_radius_m": rig.patch_radius_m,
        "arm": said["arm"],
        "motion": {"order": plan.order, "passes": plan.passes, "settle_s": plan.settle_s},
        "tally": journal.said("tally") or {},
        "drift": drift(journal),
        "clocks": clocks_apart(journal),
        **_reported(journal, name, set(cells)),
    }
    if name != "monitor":
        meta |= _grid(plan, cells).to_meta()
    static = rig_static(rig, *devices) | {"meta_json": json.dumps(meta)}
    return Stream(static, _frames(journal, name, set(cells)), len(cells) * plan.repeats)


def _grid(plan: MotionPlan, cells: list[int]) -> ScanPlan:
    """The scan plan of what was really visited."""
    for order in ("snake", "raster"):
        whole = ScanPlan(plan.columns, plan.rows, plan.repeats, order=order)
        if (whole.cells @ [1, plan.columns]).tolist() == cells:
            return whole
    return ScanPlan(plan.columns, plan.rows, plan.repeats, order="listed", listed=tuple(cells))


def _frames(journal: Journal, name: str, cells: set[int]) -> Iterator[dict[str, Any]]:
    """Frames as they were taken."""
    last_s = -np.inf
    for sample in journal.samples(name):
        if sample.cell not in cells:
            continue
        for frame in sample.frames:
            last_s = max(frame.time_s, last_s + LEAST_STEP_S)
            fields = {"counts": frame.counts, "timestamp_s": last_s}
            yield fields if frame.rgb is None else fields | {"rgb": frame.rgb}


def _reported(journal: Journal, name: str, cells: set[int]) -> dict[str, Any]:
    """What was said of every sample: where the arm was read at, temperatures, the reference channel."""
    said: list[Sample] = [s for s in journal.samples(name, pictures=False) if s.cell in cells]
    temperatures = np.array([t for s in said for t in s.said["temperature_c"]], float)
    known = temperatures[np.isfinite(temperatures)]
    return {
        "arm_pose": [s.said["pose"] for s in said],
        "arm_joints": [s.said["joints"] for s in said],
        "temperature_c": float(known.mean()) if len(known) else None,
        "temperatures_c": [None if not np.isfinite(t) else float(t) for t in temperatures],
        "reference_counts": [n for s in said for n in s.said["reference_counts"]],
        "device_s": [None if not np.isfinite(t) else t for s in said for t in s.said["device_s"]],
    }
