import json

import numpy as np
import pytest
from rerun.chunk import RrdReader

from difflidar.cli import main
from physics.presets import preset
from physics.scene.view import View, Views
from physics.simulate import simulate
from recordings.files import load, save
from recordings.maps import ResponseMaps
from recordings.maps_file import save_maps

FRAMES = 3
INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Maps of 3 × 3 zones, frames of a wall at 1.5 m, the same with a wrong depth, and the fused wall."""
    made = tmp_path_factory.mktemp("view")
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-4, 68, 25), np.linspace(-4, 52, 20)))
    centres = [(a, b) for b in (10, 24, 38) for a in (16, 32, 48)]
    bells = np.stack([1e4 * np.exp(-(((x - a) / 7) ** 2) - ((y - b) / 6) ** 2) for a, b in centres])
    maps = ResponseMaps(bells.reshape(3, 3, -1), x, y, np.arange(x.size).astype(str), '{"image_size": [64, 48]}')
    save_maps(maps, made / "maps.npz")
    rgb = np.random.default_rng(0).integers(0, 255, (24, 32, 3)).astype(np.uint8)
    wall = np.full((24, 32), 1.5, np.float32)
    views = (View(0.1 * i, wall, rgb=rgb, camera_pose=np.eye(4)) for i in range(FRAMES))
    sensor = preset("tmf8828-3x3-wide-long")
    recording = simulate(Views(INTRINSICS, views, FRAMES), maps, sensor, np.random.default_rng(1))[0].collect()
    save(recording, made / "wall.npz")
    given = dict(recording.present())
    save(type(recording)(**{**given, "depth_m": recording.depth_m + np.float32(0.3)}), made / "wrong.npz")
    bare = ("depth_m", "rgb", "reflectance", "incidence_cosine", "camera_pose", "irf", "irf_time_s", "intrinsics")
    save(type(recording)(**{n: v for n, v in given.items() if n not in (*bare, "image_size")}), made / "bare.npz")
    arguments = ("fuse", made / "wall.npz", "--calibration", made / "maps.npz", "--out", made / "fused")
    assert run(*arguments, "--method", "splat") == 0
    return made


def entities(path):
    """Record batches by entity."""
    found = {}
    for chunk in RrdReader(path).stream():
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def residuals(path):
    """(F, P, T) of a session."""
    batches = entities(path)["/residual"]
    rows = [row for batch in batches for row in batch.column("Tensor:data").to_pylist()]
    return np.array([row[0]["buffer"] for row in rows]).reshape(len(rows), 9, -1)


@pytest.mark.parametrize("method", ["splat", "unmix"])
def test_a_recording_becomes_a_session(folder, tmp_path, capsys, method):
    out = tmp_path / "wall.rrd"
    assert (
        run("view", folder / "wall.npz", "--calibration", folder / "maps.npz", "--method", method, "--save", out) == 0
    )
    assert capsys.readouterr().out == f"wrote {out}\n"
    there = entities(out)
    for name in ("world/cloud", "world/rig/camera/rgb", "world/trajectory", "fused/depth", "fused/sigma", "about"):
        assert there[f"/{name}"]
    for name in ("lidar/zone/2_2", "lidar/zone/0_0/depths", "world/rig/camera/footprint/1_1", "recorded_depth"):
        assert there[f"/{name}"]
    assert method in there["/about"][0].column("TextDocument:text").to_pylist()[0][0]
    # The camera's image has grain as fine as its pixels, but the wall is one.
    marks = [row for batch in there["/depth_of_zone"] for row in column(batch, "Scalars:scalars")]
    middle = np.array(marks)[:, 4]
    np.testing.assert_allclose(middle, 1.5, atol=0.03)


def column(batch, name):
    return [row for row in batch.column(name).to_pylist() if row] if name in batch.schema.names else []


def test_residuals_of_the_right_depth_are_noise_and_of_a_wrong_one_are_not(folder, tmp_path):
    squares = {}
    for name in ("wall", "wrong"):
        out = tmp_path / f"{name}.rrd"
        given = ("--calibration", folder / "maps.npz", "--method", "splat", "--save", out)
        assert run("view", folder / f"{name}.npz", *given) == 0
        squares[name] = (residuals(out) ** 2).mean()
    assert 0.8 < squares["wall"] < 1.3
    assert squares["wrong"] > 3


def test_a_folder_of_fused_frames_becomes_a_session(folder, tmp_path):
    out = tmp_path / "fused.rrd"
    assert run("view", folder / "fused", "--save", out) == 0
    there = entities(out)
    for name in ("world/cloud", "world/rig/camera/rgb", "fused/depth", "depth_of_zone"):
        assert there[f"/{name}"]
    assert "/lidar/zone/0_0" not in there


def test_a_recording_alone_shows_what_it_has(folder, tmp_path):
    out = tmp_path / "bare.rrd"
    assert run("view", folder / "bare.npz", "--save", out) == 0
    there = entities(out)
    assert there["/lidar/zone/0_0"]
    assert not [name for name in there if name.startswith(("/world/cloud", "/fused", "/residual", "/recorded"))]
    assert run("view", folder / "wall.npz", "--save", out) == 0
    assert entities(out)["/lidar/zone/0_0/depths"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["wall.npz", "--sensor", "tmf8828-3x3-wide-long"], "without response maps, expected --calibration"),
        (["wall.npz", "--calibration", "maps.npz", "--method", "magic"], "method 'magic' is unknown"),
        (["fused", "--calibration", "maps.npz"], "is fused already"),
        (["maps.npz"], "holds response maps, expected a recording"),
        (["none.npz"], "no such file"),
        (["wall.npz", "--connect", "rerun+http://127.0.0.1:1/proxy", "--save", "x.rrd"], "expected one of them"),
    ],
)
def test_what_cannot_be_shown_is_refused_in_a_sentence(folder, tmp_path, capsys, monkeypatch, arguments, sentence):
    monkeypatch.chdir(folder)
    saves = [] if "--save" in arguments else ["--save", tmp_path / "x.rrd"]
    assert run("view", *arguments, *saves) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_without_a_display_save_is_named(folder, capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("viewers.viewer.ADDRESS", "rerun+http://127.0.0.1:1/proxy")
    monkeypatch.setattr("sys.platform", "linux")
    assert run("view", folder / "wall.npz") == 2
    assert "--save FILE.rrd" in capsys.readouterr().err


def test_a_summary_that_lists_nothing_is_refused(folder, tmp_path, capsys):
    broken = tmp_path / "fused"
    broken.mkdir()
    said = json.loads((folder / "fused" / "summary.json").read_text())
    (broken / "summary.json").write_text(json.dumps({**said, "frames": []}))
    assert run("view", broken, "--save", tmp_path / "x.rrd") == 2
    assert "lists no frames" in capsys.readouterr().err


def test_depth_in_the_session_is_that_of_fusion(folder, tmp_path):
    recording = load(folder / "wall.npz")
    assert recording.depth_m.shape == (FRAMES, 24, 32)
    out = tmp_path / "fused.rrd"
    assert run("view", folder / "fused", "--save", out) == 0
    clouds = [row for batch in entities(out)["/world/cloud"] for row in column(batch, "Points3D:positions")]
    assert len(clouds) == FRAMES
    np.testing.assert_allclose(np.median(np.array(clouds[0])[:, 2]), 1.5, atol=0.05)
