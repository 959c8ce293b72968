"""The proof from end to end: recordings sealed, answers written, the truth opened, the answers scored."""

import json
from pathlib import Path

import numpy as np

from mismatch.explain import explain
from mismatch.open_simulation import open_simulation
from mismatch.prove.case import draw_case
from mismatch.prove.ledger import seal, unseal
from mismatch.prove.scores import Answered
from recordings.files import save
from recordings.maps_file import save_maps
from recordings.progress import Progress, silent
from recordings.refusal import Refusal


def make_cases(out: Path, cases: int, seed: int, progress: Progress = silent) -> str:
    """Write so many sealed recordings with their maps into a folder; the hash of their truth.

    Each case has a random state of its own, so that the first cases of a longer proof are those of a shorter one.
    """
    out.mkdir(parents=True, exist_ok=True)
    truths = []
    for i in progress(range(cases), cases, "sealing recordings"):
        case = draw_case(np.random.default_rng([seed, i]))
        name = f"case_{i:03d}"
        save(case.recording, out / f"{name}.npz")
        save_maps(case.maps, out / f"{name}_maps.npz")
        truths.append({"file": f"{name}.npz", "maps": f"{name}_maps.npz", **case.truth})
    return seal(truths, out / "truth.json")


def answer(folder: Path, answers: Path, files: list[tuple[str, Path]], progress: Progress = silent) -> None:
    """Explain every recording of a folder, given by name and maps; a file for each answer."""
    answers.mkdir(parents=True, exist_ok=True)
    for name, maps in progress(files, len(files), "explaining"):
        simulation, _, notes = open_simulation(folder / name, maps)
        verdict = explain(simulation, notes).verdict
        (answers / f"{Path(name).stem}.json").write_text(verdict.text())


def recordings_in(folder: Path, maps: Path | None = None) -> list[tuple[str, Path]]:
    """Recordings of a folder by name, each with the maps beside it, NAME_maps.npz, or those given for all."""
    found = sorted(p for p in folder.iterdir() if p.suffix in (".npz", ".rrd") and not p.stem.endswith("_maps"))
    if not found:
        raise Refusal(f"{folder}: holds no recording, expected .npz or .rrd files")
    out = []
    for path in found:
        own = path.with_name(f"{path.stem}_maps.npz")
        if not own.exists() and maps is None:
            raise Refusal(f"{path}: no {own.name} beside it, expected response maps there or by --calibration")
        out.append((path.name, own if own.exists() else maps))
    return out


def compare(answers: Path, truth: Path, digest: str | None = None) -> list[Answered]:
    """Open the truth, and put it beside the answers."""
    found = []
    for case in unseal(truth, digest):
        path = answers / f"{Path(case['file']).stem}.json"
        if path.exists():
            found.append(Answered(case, json.loads(path.read_text())))
    if not found:
        raise Refusal(f"{truth}: none of its cases is among the recordings")
    return found
