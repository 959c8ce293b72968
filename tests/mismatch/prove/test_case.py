"""Sealed recordings: the same for the same seed, and silent about what they conceal."""

import json

import numpy as np
import pytest

from mismatch.prove.case import KINDS, _whole, draw_case
from mismatch.prove.ledger import seal
from mismatch.prove.run import answer, compare, make_cases, recordings_in
from mismatch.prove.strangers import STRANGERS
from physics.effects import all_effects, find_effect
from physics.footprint import footprints
from recordings.files import load, save
from recordings.maps_file import load_maps, save_maps
from recordings.refusal import Refusal


@pytest.fixture(scope="module")
def cases():
    return [draw_case(np.random.default_rng([1, seed])) for seed in range(4)]


def test_a_seed_is_a_case(cases):
    again = draw_case(np.random.default_rng([1, 0]))
    np.testing.assert_array_equal(np.asarray(again.recording.counts), np.asarray(cases[0].recording.counts))
    np.testing.assert_array_equal(again.maps.responses, cases[0].maps.responses)
    assert again.truth == cases[0].truth
    other = np.asarray(cases[1].recording.counts)
    assert other.shape != np.asarray(again.recording.counts).shape or (other != again.recording.counts).any()


def test_the_truth_says_what_is_there(cases):
    for case in cases:
        truth = case.truth
        assert truth["kind"] in KINDS
        assert len(truth["effects"]) == {"single": 1, "pair": 2}.get(truth["kind"], 0)
        assert (truth["stranger"] in STRANGERS) == (truth["kind"] == "unknown")
        assert {effect["id"] for effect in truth["effects"]} <= set(all_effects())
        assert (truth["deviance_moved"] > 0) == (truth["kind"] != "nothing")
        assert truth["frames"] == len(case.recording.counts)
        json.dumps(truth, allow_nan=False)


def test_maps_read_alike_from_their_file(cases, tmp_path):
    """What explains a case reads its maps from a file: rounding there turned diagonals of the scan's grid, and nothing
    concealed was called wrong gains of zones."""
    for case in cases:
        save_maps(case.maps, tmp_path / "maps.npz")
        there = load_maps(tmp_path / "maps.npz")
        shape = np.asarray(case.recording.depth_m).shape[1:]
        np.testing.assert_array_equal(footprints(there, shape).weights, footprints(case.maps, shape).weights)


def test_the_recording_says_nothing_of_it(cases):
    for case in cases:
        said = case.recording.meta_json + "".join(
            str(value) for _, value in case.recording.present() if np.asarray(value).dtype.kind in "US"
        )
        for name in (*all_effects(), *STRANGERS):
            assert name not in said
        assert set(case.recording.meta) <= {"calibration_range_m", "made_by"}
        assert "effects" not in case.maps.meta


def test_cases_are_sealed_and_their_files_found(tmp_path):
    digest = make_cases(tmp_path / "cases", 2, seed=3)
    assert digest == make_cases(tmp_path / "again", 2, seed=3)
    files = recordings_in(tmp_path / "cases")
    assert [name for name, _ in files] == ["case_000.npz", "case_001.npz"]
    assert len(load(tmp_path / "cases" / "case_000.npz").counts) in (48, 96)
    with pytest.raises(Refusal, match="none of its cases is among the recordings"):
        compare(tmp_path, tmp_path / "cases" / "truth.json", digest)


def test_a_folder_without_recordings_or_maps_is_refused(tmp_path):
    with pytest.raises(Refusal, match="holds no recording"):
        recordings_in(tmp_path)
    (tmp_path / "seen.npz").write_bytes(b"")
    with pytest.raises(Refusal, match=r"no seen_maps\.npz beside it"):
        recordings_in(tmp_path)
    assert recordings_in(tmp_path, tmp_path / "maps.npz") == [("seen.npz", tmp_path / "maps.npz")]


def test_answers_are_put_beside_the_truth(rig, tmp_path):
    folder, answers = tmp_path / "cases", tmp_path / "answers"
    folder.mkdir()
    save(rig.recording(np.random.default_rng(4).poisson(rig.expected())), folder / "small.npz")
    save_maps(rig.maps, folder / "small_maps.npz")
    digest = seal([{"file": "small.npz", "effects": []}], folder / "truth.json")
    answer(folder, answers, recordings_in(folder))
    (found,) = compare(answers, folder / "truth.json", digest)
    assert found.kind == "nothing"
    assert found.right
    assert found.verdict["format"] == "difflidar-verdict/1"


def test_what_is_there_or_not_is_drawn_whole():
    mirrored = find_effect("mirrored_zones")
    whole = _whole(mirrored.at(columns=0.02, transposed=0.02), None)
    assert (whole.values["columns"], whole.values["transposed"], whole.values["rows"]) == (1.0, 1.0, 0.0)
    tail = find_effect("impulse_tail").at(share=0.02)
    assert _whole(tail, None) is tail
    # A thing all of whose light comes from elsewhere would contradict itself however strong.
    assert _whole(find_effect("second_surface").at(one=0.99, spacing=0.1), None) is None
