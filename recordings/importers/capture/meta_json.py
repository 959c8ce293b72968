"""The metadata of an imported capture file: provenance, scan plan, what is missing and what is assumed."""

from collections import Counter
from typing import Any

from recordings.importers.capture.metadata import range_mode, scan_plan
from recordings.importers.capture.survey import Survey
from recordings.importers.inert.walk import as_json


def described(survey: Survey) -> dict[str, Any]:
    """The metadata of the recording, plain JSON values; keys that have nothing to say are absent."""
    said = {
        "sensor": "TMF8828",
        "provenance": "pickle stream of the capture scripts of Behari & Raskar 2026",
        "range_mode": range_mode(survey.metadata),
        "assumed": assumed(survey),
        "publisher_metadata": as_json(survey.metadata),
        "arrays_left_out": sorted({name for one in survey.captures for name in one.unused}),
        "records_left_out": survey.left_out,
        "truncated": survey.truncated,
        **iterations(survey),
    }
    return {name: value for name, value in said.items() if value not in (None, [], {})}


def assumed(survey: Survey) -> list[str]:
    """What the file does not say and the recording needs."""
    mode = range_mode(survey.metadata)
    lines = [
        "bin_width_s and time_zero_s: typical of a TMF8828 in its "
        + (f"{mode} range mode" if mode else "LONG range mode, the default where the file names none")
    ]
    if survey.times_s is None:
        lines.append("timestamp_s: one frame a second, as the records carry no rising times")
    if survey.iterations is None:
        lines.append("order of the frames: that of the file, as not every record carries its iteration")
    if survey.captures[0].colour:
        lines.append("rgb: stored as bgr8, as the capture scripts set the camera up")
    if survey.captures[0].depth:
        lines.append("depth_m: stored in millimetres, 0 where unknown")
    return lines


def iterations(survey: Survey) -> dict[str, Any]:
    """Which iteration each frame is, which are missing or there twice, and the grid they ran over."""
    there = survey.iterations
    if there is None:
        return {}
    times = Counter(there)
    return {
        "iter": there,
        "missing_iters": [i for i in range(there[-1]) if i not in times],
        "duplicate_iters": [i for i, n in times.items() if n > 1],
        "plan": with_lost(scan_plan(survey.metadata, there), set(there)),
    }


def with_lost(plan: dict[str, Any] | None, there: set[int]) -> dict[str, Any] | None:
    """The plan with the frames that no record holds; an iteration is the number of its frame in the plan."""
    if plan is None:
        return None
    planned = plan["first"] + plan["columns"] * plan["rows"] * plan["repeats"]
    lost = [i for i in range(planned) if i not in there]
    return plan | {"lost": lost} if lost else plan
