"""A scan from its files to its files: begun, or gone on with where it was left."""

import contextlib
import json
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from calibrate.rig import MODES, Rig
from devices.rehearsal.control import RehearsedPerson
from devices.scan.export import export, written_paths
from devices.scan.holder import Holder, Person
from devices.scan.journal import SUFFIX, Journal
from devices.scan.motion_plan import MotionPlan
from devices.scan.open_station import open_station
from devices.scan.runner import Scan
from devices.scan.visit import Seen
from recordings.atomic import expect_place_for
from recordings.maps import ResponseMaps
from recordings.progress import Progress, silent
from recordings.refusal import Refusal

# Where devices are found may change between two sittings; what they are set to may not.
ADDRESSES = ("lidar.port", "camera.device", "arm.address", "control")


def conduct(
    plan: MotionPlan,
    rig: Rig,
    out: Path,
    *,
    resume: bool = False,
    prior: ResponseMaps | None = None,
    ask: Callable[[str], None],
    tell: Callable[[str], None],
    watch: Callable[[Seen], None] = lambda seen: None,
    progress: Progress = silent,
) -> tuple[dict[str, Path], dict]:
    """Scan, and write the recordings; pass -> file, and the tally.

    resume: go on with the scan that was left at `out`. ask: shows a person a sentence and returns when it was answered.
    Raises `Refusal` where it cannot go on; what was seen is kept in the journal beside `out`.
    """
    with contextlib.closing(begun(plan, rig, out, resume)) as journal:
        holder: Holder = RehearsedPerson(rig.control) if rig.control else Person(ask)
        station, said = open_station(rig, plan, tell)
        try:
            for device, words in said.items():
                journal.say(device, words)
            Scan(
                plan, station, holder, journal, zone_grid=MODES[rig.lidar.mode], prior=prior, watch=watch, tell=tell
            ).run()
            tally = station.summary()
            journal.say("tally", tally)
            journal.say("lidar", station.lidar.device.said)
        finally:
            station.close()
        written = export(journal, out, progress)
        journal.remove()
    return written, tally


def begun(plan: MotionPlan, rig: Rig, out: Path, resume: bool) -> Journal:
    """The journal of a scan, new or the one that was left; `Refusal` where the wrong one of them is there."""
    for path in written_paths(out).values():
        expect_place_for(path)
        if path.exists():
            raise Refusal(f"{path}: is there already, expected a new name; a scan writes over nothing")
    path = out.with_name(out.name + SUFFIX)
    if path.exists() and not resume:
        raise Refusal(f"{path}: a scan was left here; go on with --resume, or delete this file to begin anew")
    if resume and not path.exists():
        raise Refusal(f"{path}: no such file, so there is no scan to go on with; leave --resume out to begin one")
    journal = Journal(path)
    asked = {"plan": json.loads(plan.text()), "rig": json.loads(rig.text())}
    for name, value in asked.items():
        kept = journal.said(name)
        if kept is None:
            journal.say(name, value)
        elif differs := _first_difference(kept, value):
            journal.close()
            raise Refusal(f"{name}: {differs} is not what the scan was begun with; give it the same {name} to go on")
    journal.say("version", version("difflidar"))
    return journal


def _first_difference(kept: dict, asked: dict, before: str = "") -> str:
    """The first field in which two files differ, "" where none does."""
    for name in {**kept, **asked}:
        path = f"{before}{name}"
        one, other = kept.get(name), asked.get(name)
        if isinstance(one, dict) and isinstance(other, dict):
            if found := _first_difference(one, other, f"{path}."):
                return found
        elif one != other and path not in ADDRESSES:
            return path
    return ""
