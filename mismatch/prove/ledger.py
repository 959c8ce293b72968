"""The truth of sealed recordings: written first, with its hash, opened only when all answers are written."""

import hashlib
import json
from pathlib import Path
from typing import Any

from recordings.refusal import Refusal
from recordings.untrusted import reading


def seal(truths: list[dict[str, Any]], path: Path) -> str:
    """Write the ledger; its SHA-256 goes beside it and is returned."""
    text = json.dumps({"format": "difflidar-truth/1", "cases": truths}, indent=1)
    path.write_text(text)
    digest = hashlib.sha256(text.encode()).hexdigest()
    path.with_suffix(".sha256").write_text(digest + "\n")
    return digest


def unseal(path: Path, digest: str | None = None) -> list[dict[str, Any]]:
    """The cases of a ledger; refused where it is not the one that was sealed."""
    with reading(path, "ledger of the truth (.json)"):
        text = path.read_text()
        held = json.loads(text)
    if digest is not None and hashlib.sha256(text.encode()).hexdigest() != digest:
        raise Refusal(f"{path}: was changed after it was sealed, expected SHA-256 {digest}")
    cases = held.get("cases", held) if isinstance(held, dict) else held
    if not isinstance(cases, list) or not all(isinstance(case, dict) for case in cases):
        raise Refusal(f"{path}: holds no list of cases, expected one object for each recording")
    for i, case in enumerate(cases):
        effects = case.get("effects", [])
        if not isinstance(effects, list) or not all(
            isinstance(e, dict) and isinstance(e.get("id"), str) for e in effects
        ):
            raise Refusal(f"{path}: cases[{i}].effects is {effects!r}, expected a list of objects with an id")
        if not isinstance(case.get("file"), str):
            raise Refusal(f"{path}: cases[{i}].file is {case.get('file')!r}, expected the name of its recording")
    return cases
