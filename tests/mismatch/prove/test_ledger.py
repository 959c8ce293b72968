"""The truth is sealed and opened again, unless it was changed in between."""

import hashlib
import json

import pytest

from mismatch.prove.ledger import seal, unseal
from recordings.refusal import Refusal

TRUTHS = [{"file": "case_000.npz", "effects": [{"id": "pile_up", "parameters": {"share": 1.0}}]}, {"file": "b.npz"}]


def test_what_was_sealed_comes_back(tmp_path):
    path = tmp_path / "truth.json"
    digest = seal(TRUTHS, path)
    assert unseal(path, digest) == TRUTHS
    assert digest == hashlib.sha256(path.read_bytes()).hexdigest()
    assert path.with_suffix(".sha256").read_text().strip() == digest


def test_a_truth_that_was_changed_is_refused(tmp_path):
    path = tmp_path / "truth.json"
    digest = seal(TRUTHS, path)
    path.write_text(path.read_text().replace("pile_up", "zone_gain"))
    with pytest.raises(Refusal, match=f"was changed after it was sealed, expected SHA-256 {digest}"):
        unseal(path, digest)


@pytest.mark.parametrize(
    ("held", "words"),
    [
        ({"cases": 3}, "no list of cases"),
        ([1], "no list of cases"),
        ([{"file": "a.npz", "effects": ["pile_up"]}], r"cases\[0\].effects"),
        ([{"file": "a.npz"}, {"effects": []}], r"cases\[1\].file is None"),
    ],
)
def test_what_is_no_ledger_is_refused(tmp_path, held, words):
    path = tmp_path / "truth.json"
    path.write_text(json.dumps(held))
    with pytest.raises(Refusal, match=words):
        unseal(path)


@pytest.mark.parametrize("text", ["", "{", "\x00"])
def test_what_is_no_json_is_refused(tmp_path, text):
    path = tmp_path / "truth.json"
    path.write_text(text)
    with pytest.raises(Refusal):
        unseal(path)
