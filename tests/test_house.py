"""House rules a reader of one file would not see broken."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROOMS = sorted(path.parent.name for path in ROOT.glob("*/__init__.py") if path.parent.name != "tests")
MOST_LINES = 200


def test_every_room_is_packaged():
    built = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert sorted(built["packages"]) == ROOMS


@pytest.mark.parametrize("room", ROOMS)
def test_a_file_is_one_idea(room):
    lengths = {path: len(path.read_text().splitlines()) for path in (ROOT / room).rglob("*.py")}
    assert {path: length for path, length in lengths.items() if length > MOST_LINES} == {}


def test_pinned_versions_carry_no_address():
    for line in (ROOT / "constraints.txt").read_text().splitlines():
        assert re.fullmatch(r"(#.*|[\w.-]+==[\w.+!-]+( ;.*)?)?", line), line
