"""The command `prove` from end to end on recordings of a few frames, and what it refuses."""

import hashlib
import json
from types import SimpleNamespace

import numpy as np
import pytest

from difflidar.cli import main
from mismatch.prove.case import Case
from mismatch.prove.extrapolation import SideBySide
from physics.clock import Clock
from physics.effects import find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import two_piece_pulse
from recordings.files import save
from recordings.maps import ResponseMaps
from recordings.maps_file import save_maps
from recordings.recording import Recording

WIDTH, BINS, FRAMES = 2e-10, 40, 12
EFFECTS = {"plain": [], "lit": [{"id": "ambient_pedestal", "parameters": {"level": 6.0}}]}


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


def refused(capsys, *arguments):
    """The one sentence of a refusal."""
    assert run(*arguments) == 2
    said = capsys.readouterr()
    assert said.err.startswith("difflidar: ")
    assert said.err.count("\n") == 1
    return said.err


@pytest.fixture(scope="module")
def made():
    """Two zones before a wall that sways: maps, and recordings with nothing concealed and with unrecorded light."""
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-2, 14, 6), np.linspace(-2, 14, 6)))
    blobs = np.stack([1e3 * np.exp(-(((x - a) / 4) ** 2) - ((y - 6) / 4) ** 2) for a in (3, 9)])
    maps = ResponseMaps(blobs.reshape(1, 2, -1), x, y, np.arange(x.size).astype(str), '{"image_size": [12, 12]}')
    slant = 0.01 * np.arange(12) + 0.01 * np.arange(12)[:, None]
    depth = (0.5 + 0.15 * np.sin(0.8 * np.arange(FRAMES))[:, None, None] + slant).astype(np.float32)
    intrinsics = np.array([[40.0, 0, 5.5], [0, 40, 5.5], [0, 0, 1]])
    pulse = two_piece_pulse(1.2e-10, 2e-10, WIDTH / 16)
    times = np.arange(FRAMES) / 15
    light = direct_light(depth, intrinsics, time_s=times, laser_cycles=1e6)
    model = ForwardModel(light, footprints(maps, (12, 12)), Clock(WIDTH, BINS, np.full(2, 1e-9), pulse), 2.0)
    gain = 500 / (model.expected() - 2).max()
    recordings = {}
    for number, (name, effects) in enumerate(EFFECTS.items()):
        settings = [find_effect(one["id"]).at(**one["parameters"]) for one in effects]
        counts = np.random.default_rng([3, number]).poisson(model.expected(gain, settings)).astype(np.uint32)
        recordings[name] = Recording(
            counts, [1, 2], WIDTH, np.full(2, 1e-9), times, depth_m=depth, intrinsics=intrinsics,
            image_size=np.array([12, 12]), irf_time_s=pulse.time_s, irf=pulse.probability, laser_cycles=1e6,
            background_counts=np.full(2, 2.0),
        )  # fmt: skip
    return maps, recordings


def write(made, folder, maps_of):
    """The recordings into a new folder, their maps to `maps_of` their names."""
    maps, recordings = made
    folder.mkdir()
    for name, recording in recordings.items():
        save(recording, folder / f"{name}.npz")
        save_maps(maps, maps_of(name))


def ledger(path, cases):
    path.write_text(json.dumps(cases))
    return path


@pytest.fixture
def challenge(made, tmp_path):
    """Recordings made elsewhere, each with maps beside it, and their truth."""
    folder = tmp_path / "made"
    write(made, folder, lambda name: folder / f"{name}_maps.npz")
    cases = [{"file": f"{name}.npz", "effects": effects} for name, effects in EFFECTS.items()]
    return SimpleNamespace(folder=folder, truth=ledger(tmp_path / "truth.json", cases), out=tmp_path / "out")


def test_recordings_made_elsewhere_are_answered_and_scored(challenge, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    where = ("--recordings", challenge.folder, "--truth", challenge.truth, "--out", challenge.out)
    assert run("prove", *where) == 0
    said = capsys.readouterr().out
    for line, figure in (("single causes named ", "1 of 1"), ("false alarms", "0 of 1"), ("both of a pair", "no such")):
        assert any(line in row and figure in row for row in said.splitlines())
    assert "answered as" not in said
    answers = {p.stem: json.loads(p.read_text()) for p in (challenge.out / "answers").iterdir()}
    assert {name: answer["verdict"] for name, answer in answers.items()} == {"plain": "agrees", "lit": "explained"}
    assert (challenge.out / "proof.png").read_bytes().startswith(b"\x89PNG")
    assert sorted(p.name for p in challenge.out.iterdir()) == ["answers", "proof.png"]


def test_a_wrong_answer_is_told(challenge, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    truth = ledger(challenge.truth, [{"file": "plain.npz", "effects": [{"id": "pile_up"}]}])
    assert run("prove", "--recordings", challenge.folder, "--truth", truth, "--out", challenge.out) == 0
    assert "1 × pile_up answered as agrees" in capsys.readouterr().out


@pytest.fixture
def quick(made, monkeypatch):
    """Cases that take no time to draw."""
    maps, recordings = made
    truth = {"kind": "nothing", "effects": [], "stranger": None, "deviance_moved": 0.0, "frames": FRAMES}
    monkeypatch.setattr("mismatch.prove.run.draw_case", lambda rng: Case(recordings["plain"], maps, truth))


def test_cases_of_its_own_are_sealed_before_they_are_answered(quick, tmp_path, capsys, monkeypatch):
    out, seen = tmp_path / "out", []

    def answer(folder, answers, files, progress):
        seen.append((folder / "truth.json").read_bytes())
        answers.mkdir()
        said = {"verdict": "agrees", "effects": [], "fit": {"gap_closed": None}, "seconds": 1.0}
        for name, _ in files:
            (answers / name).with_suffix(".json").write_text(json.dumps(said))

    monkeypatch.setattr("mismatch.prove.run.answer", answer)
    assert run("prove", "--cases", 1, "--seed", 4, "--out", out) == 0
    (truth,) = seen
    assert f"SHA-256 of their truth: {hashlib.sha256(truth).hexdigest()}" in capsys.readouterr().out
    assert (out / "sealed" / "case_000.npz").exists()


def test_a_truth_that_changes_while_answers_are_written_is_refused(quick, tmp_path, capsys, monkeypatch):
    def answer(folder, answers, files, progress):
        path = folder / "truth.json"
        path.write_text(path.read_text().replace('"kind"', '"was"'))

    monkeypatch.setattr("mismatch.prove.run.answer", answer)
    assert "was changed after it was sealed" in refused(capsys, "prove", "--cases", 1, "--out", tmp_path / "out")
    assert not (tmp_path / "out" / "proof.png").exists()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{", "truth.json"),
        ("[3]", "holds no list of cases"),
        ('[{"effects": []}]', "cases[0].file is None"),
        ('[{"file": "plain.npz", "effects": "pile_up"}]', "cases[0].effects is 'pile_up'"),
        ('[{"file": "other.npz", "effects": []}]', "none of its cases is among the recordings"),
    ],
)
def test_a_ledger_that_cannot_be_read_is_refused(challenge, capsys, monkeypatch, text, sentence):
    monkeypatch.setattr("mismatch.prove.run.answer", lambda *given: None)
    challenge.truth.write_text(text)
    where = ("--recordings", challenge.folder, "--truth", challenge.truth, "--out", challenge.out)
    assert sentence in refused(capsys, "prove", *where)
    assert not (challenge.out / "proof.png").exists()


def test_maps_for_all_may_lie_elsewhere(made, tmp_path, capsys, monkeypatch):
    write(made, tmp_path / "made", lambda name: tmp_path / "maps.npz")
    truth = ledger(tmp_path / "truth.json", [{"file": "plain.npz"}])
    where = ("--recordings", tmp_path / "made", "--truth", truth, "--out", tmp_path / "out")
    assert "no lit_maps.npz beside it, expected response maps there or by --calibration" in refused(
        capsys, "prove", *where
    )
    given = []
    monkeypatch.setattr("mismatch.prove.run.answer", lambda *arguments: given.extend(arguments[2]))
    assert run("prove", *where, "--calibration", tmp_path / "maps.npz") == 2
    assert given == [("lit.npz", tmp_path / "maps.npz"), ("plain.npz", tmp_path / "maps.npz")]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--recordings", "made"), "--recordings and --truth go together"),
        (("--truth", "truth.json"), "--recordings and --truth go together"),
        (("--recordings", "made", "--truth", "truth.json"), "truth.json: does not exist"),
        (("--black-box", "--recordings", "made", "--truth", "truth.json"), "--black-box draws its own recordings"),
    ],
)
def test_what_cannot_be_answered_is_refused(tmp_path, capsys, monkeypatch, options, sentence):
    monkeypatch.chdir(tmp_path)
    assert sentence in refused(capsys, "prove", *options)
    assert list(tmp_path.iterdir()) == []


def test_physics_beside_a_black_box(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    made = [
        SideBySide("pile_up", ("pile_up",), (2.0, 3.0), (1.01, 1.02), (1.03, 2.5), (1.0, 1.0), 10.0),
        SideBySide("impulse_tail", (), (2.0, 3.0), (2.0, 3.0), (1.5, 2.9), (1.0, 1.0), 1.0),
    ]
    monkeypatch.setattr("mismatch.prove.extrapolation.sweeps", lambda seed: [(one.cause, one, None) for one in made])
    monkeypatch.setattr("mismatch.prove.extrapolation.compare_on_far", lambda simulation, near, cause: simulation)
    assert run("prove", "--black-box", "--out", tmp_path / "out") == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert any("nothing" in row and "1.500" in row for row in rows)
    assert any("far" in row and "2.500" in row for row in rows)
    held = json.loads((tmp_path / "out" / "black_box.json").read_text())
    assert held[0]["black_box"] == [1.03, 2.5]
    assert (tmp_path / "out" / "black_box.png").read_bytes().startswith(b"\x89PNG")
