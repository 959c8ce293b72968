import json

import numpy as np
import pytest

from difflidar.cli import main
from physics.presets import preset
from physics.scene.view import View, Views
from physics.simulate import simulate
from recordings.files import save
from recordings.maps import ResponseMaps
from recordings.maps_file import save_maps

INTRINSICS = np.array([[30.0, 0, 15.5], [0, 30, 11.5], [0, 0, 1]])


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Maps of 3 × 3 zones and two frames of a wall."""
    made = tmp_path_factory.mktemp("fuse")
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-4, 68, 25), np.linspace(-4, 52, 20)))
    centres = [(a, b) for b in (10, 24, 38) for a in (16, 32, 48)]
    bells = np.stack([1e4 * np.exp(-(((x - a) / 7) ** 2) - ((y - b) / 6) ** 2) for a, b in centres])
    maps = ResponseMaps(bells.reshape(3, 3, -1), x, y, np.arange(x.size).astype(str), '{"image_size": [64, 48]}')
    save_maps(maps, made / "maps.npz")
    rgb = np.random.default_rng(0).integers(0, 255, (24, 32, 3)).astype(np.uint8)
    views = (View(0.1 * i, np.full((24, 32), 1.5, np.float32), rgb=rgb, camera_pose=np.eye(4)) for i in range(2))
    sensor = preset("tmf8828-3x3-wide-long")
    save(simulate(Views(INTRINSICS, views, 2), maps, sensor, np.random.default_rng(1))[0], made / "wall.npz")
    return made


@pytest.mark.parametrize("method", [[], ["--method", "splat"]])
def test_a_recording_becomes_a_folder(folder, tmp_path, capsys, method):
    arguments = ("fuse", folder / "wall.npz", "--calibration", folder / "maps.npz", "--out", tmp_path / "out")
    assert run(*arguments, *method) == 0
    said = capsys.readouterr().out
    assert f"wrote {tmp_path / 'out'}: 2 frames by {method[1] if method else 'unmix'}" in said
    assert "hold 2 of 2 frames, by recorded poses" in said
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["calibration"] == "maps.npz"
    assert summary["frames"][1]["depth_m"] == pytest.approx(1.5, rel=0.1)
    for name in ("color/000001.png", "depth/000001.png", "frames/000001.npz", "clouds/000001.ply", "mesh.ply"):
        assert (tmp_path / "out" / name).stat().st_size > 0


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (["--method", "magic"], "method 'magic' is unknown"),
        (["--sensor", "tmf8828-8x8-long"], "the sensor has 8 x 8 zones but the recording 3 x 3"),
        (["--sensor", "tmf8828-3x3-wide-short"], "expected the same range mode"),
        (["--calibration", "wall.npz"], "this is a recording, not response maps"),
        (["--voxel", "0"], "voxel_m is 0"),
        (["--out", "no/where"], "does not exist"),
    ],
)
def test_one_sentence_says_what_is_wrong(folder, tmp_path, capsys, monkeypatch, change, sentence):
    monkeypatch.chdir(folder)
    out = tmp_path / "out"
    assert run("fuse", "wall.npz", "--calibration", "maps.npz", "--out", out, *change) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
