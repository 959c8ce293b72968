import json
import re
from pathlib import Path

import pytest
import trimesh

from difflidar.cli import main

FILES = ["bracket.stl", "column.stl", "cover.stl", "drawing.pdf", "front.stl"]


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture
def rig(tmp_path):
    def written(**said):
        path = tmp_path / "rig.json"
        path.write_text(json.dumps(said))
        return path

    return written


def test_the_example_is_a_rig_file_that_can_be_built(tmp_path, capsys):
    assert run("mount", "--example") == 0
    example = tmp_path / "rig.json"
    example.write_text(capsys.readouterr().out)
    said = json.loads(example.read_text())
    assert said["mount"]["camera_m3_spacing"] == 45
    out = tmp_path / "parts"
    assert run("mount", example, "--out", out) == 0
    printed = capsys.readouterr().out
    assert "as arm.tool says" in printed
    assert "2 x M3 x 16" in printed
    assert sorted(path.name for path in out.iterdir()) == FILES
    assert (out / "drawing.pdf").read_bytes().startswith(b"%PDF")
    for name in FILES:
        if name.endswith(".stl"):
            # Binary: 80 bytes, the number of triangles, and 50 bytes for each.
            assert trimesh.load_mesh(out / name).is_watertight
            triangles = int.from_bytes((out / name).read_bytes()[80:84], "little")
            assert (out / name).stat().st_size == 84 + 50 * triangles


def test_a_tool_that_is_not_the_holder_is_said(rig, tmp_path, capsys):
    assert run("mount", rig(arm={"tool": [0, 0, 0.1, 0, 0, 0]}), "--out", tmp_path / "parts") == 0
    assert "arm.tool is at (0, 0, 100) mm but this holder puts the patch at (0, 0, 35) mm" in capsys.readouterr().out


def test_the_rig_of_the_lab_page_can_be_built(rig, tmp_path, capsys):
    page = (Path(__file__).parents[2] / "docs" / "lab.md").read_text()
    said = json.loads(re.search(r"```json\n(.*?)```", page, re.DOTALL)[1])
    assert run("mount", rig(**said), "--out", tmp_path / "parts") == 0
    assert "as arm.tool says" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("said", "says"),
    [
        ({"lidar_position_m": [0.03, 0, -0.005]}, "puts the sensor into the camera"),
        ({"mount": {"sheat": 1}}, "did you mean 'sheet'"),
        ({"mount": {"sheet": -1}}, "expected millimetres above 0"),
        ({"mount": {"front_radius": 20}}, "recess"),
        ({"mount": {"bed": 60}}, "the printer's bed"),
        ({"lidar_position": [0, 0, 0]}, "lidar_position"),
    ],
)
def test_refusals_leave_nothing(rig, tmp_path, capsys, said, says):
    assert run("mount", rig(**said), "--out", tmp_path / "parts") == 2
    printed = capsys.readouterr()
    assert says in printed.err
    assert printed.err.count("\n") == 1
    assert printed.out == ""
    assert not (tmp_path / "parts").exists()


def test_places_that_cannot_be(rig, tmp_path, capsys):
    path = rig()
    assert run("mount", path, "--out", tmp_path / "gone" / "parts") == 2
    assert "does not exist" in capsys.readouterr().err
    assert run("mount", path, "--out", path) == 2
    assert "is a file" in capsys.readouterr().err
    assert run("mount", tmp_path / "gone.json", "--out", tmp_path / "parts") == 2
    assert "gone.json" in capsys.readouterr().err
