"""Importer of what a TMF882x's serial port printed, kept as text: `#Raw` and `#Obj` lines, and all that stands between.

Of the makers' Arduino driver and the UW Graphics firmware. The file is gone through three times: for the setting, for
what the measurements say besides their histograms, and measurement by measurement.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from recordings.head import head
from recordings.importers.tmf882x.assemble import Assembled, Assembler
from recordings.importers.tmf882x.layout import LAYOUTS
from recordings.importers.tmf882x.survey import Survey, numbered_lines, surveyed
from recordings.importers.tmf882x.times import times_s
from recordings.importers.tmf882x.timing import BIN_WIDTH_S, time_zero_s
from recordings.refusal import Refusal
from recordings.stream import Stream

DATA = (b"#Raw,", b"#Obj,", b"#Cal,", b"#Prt,")


def reads(path: Path) -> bool:
    """Whether a line among the first begins as data of the sensor do."""
    return any(line.startswith(DATA) for line in head(path).split(b"\n"))


def stream(path: Path) -> Stream:
    """The whole measurements of the log; what was lost or damaged is counted in the metadata.

    `Refusal` names the line where the setting changes, or says that there is no whole measurement.
    """
    survey = surveyed(path)
    mode, _ = survey.mode
    assembler = Assembler(mode, survey.setting.kilo_iterations)
    said = [besides(one) for one in measurements(path, assembler)]
    if not said:
        why = ", ".join(f"{reason} ({count})" for reason, count in assembler.tally.reasons.items()) or "no result line"
        last = f"line {assembler.tally.lines}"
        raise Refusal(f"{path}: holds no whole measurement of mode {mode} up to its end at {last}: {why}")
    times, assumed = times_s(np.array([one["tick_s"] for one in said]), np.array([one["number"] for one in said]))
    ranging = survey.setting.ranging or "long"
    layout = LAYOUTS[mode]
    static: dict[str, Any] = {
        "zone_grid": np.array(layout.grid),
        "bin_width_s": np.array(BIN_WIDTH_S[ranging]),
        "time_zero_s": time_zero_s(layout, ranging),
        "meta_json": json.dumps(described(survey, assembler.tally.said(), said, assumed)),
    }
    if survey.setting.kilo_iterations is not None:
        static["laser_cycles"] = np.array(1024 * survey.setting.kilo_iterations)
    again = measurements(path, Assembler(mode, survey.setting.kilo_iterations))
    frames = (
        {"counts": one.counts, "timestamp_s": float(time)} for one, time in zip(again, times.tolist(), strict=True)
    )
    return Stream(static=static, frames=frames, count=len(said))


def measurements(path: Path, assembler: Assembler) -> Iterator[Assembled]:
    """The whole measurements of a file; no line says when it came."""
    for _, line in numbered_lines(path):
        if (one := assembler.push(line, float("nan"))) is not None:
            yield one


def besides(one: Assembled) -> dict[str, Any]:
    """What a measurement says besides its histograms."""
    nothing = one.distance_mm is None
    return {
        "tick_s": one.tick_s,
        "number": one.number,
        "temperature_c": None if nothing else one.temperature_c,
        "distance_mm": None if nothing else one.distance_mm.tolist(),
        "confidence": None if nothing else one.confidence.tolist(),
        "reference_counts": one.reference.tolist(),
    }


def described(
    survey: Survey, tally: dict[str, Any], said: list[dict[str, Any]], assumed_times: str | None
) -> dict[str, Any]:
    """The recording's metadata: setting, what is assumed, what was lost, and what the chip itself found."""
    mode, because = survey.mode
    setting = survey.setting
    ranging = setting.ranging or "long"
    assumed = [
        f"mode {mode}: {because}",
        f"bin_width_s: {BIN_WIDTH_S[ranging]:.3g} s, published fits of {ranging} range",
        "time_zero_s: factory calibration page of one device",
    ]
    if setting.ranging is None:
        assumed.append("long range, which the firmware starts with, as the log does not say")
    if assumed_times is not None:
        assumed.append(assumed_times)
    kept = ("number", "temperature_c")
    return {
        "sensor": setting.sensor or "TMF882x",
        "mode": f"{mode}, {ranging} range",
        "provenance": "serial log of a TMF882x",
        "firmware": survey.device,
        "spad_map": setting.spad_map,
        "kilo_iterations": setting.kilo_iterations,
        "period_ms": setting.period_ms,
        "assumed": assumed,
        "lost": tally,
        **{name: [one[name] for one in said] for name in kept},
        "on_chip": {name: [one[name] for one in said] for name in ("distance_mm", "confidence")},
        "reference_counts": [one["reference_counts"] for one in said],
    }
