"""The house stands: imports go down only, nothing runs in a circle, hardware libraries stay with the devices."""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FLOORS = {
    "recordings": 0,
    "physics": 1,
    "calibrate": 2,
    "mismatch": 3,
    "fusion": 3,
    "devices": 4,
    "viewers": 5,
    "difflidar": 6,
}
HARDWARE = {"pyrealsense2", "serial", "rtde_control", "rtde_receive", "rtde_io"}
LAZY = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)


def modules(root: Path) -> dict[str, Path]:
    """Every module of the rooms under `root` by its dotted name."""
    found = {}
    for room in FLOORS:
        for path in sorted((root / room).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(name: str, path: Path) -> Iterator[tuple[str, int, bool, bool]]:
    """Each import of a module: dotted target, line, whether at module level, whether for type checkers only."""
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]

    def walk(node: ast.AST, top: bool, typing: bool) -> Iterator[tuple[str, int, bool, bool]]:
        for target in targets(node, package):
            yield target, node.lineno, top, typing
        types_only = isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING")
        for child in ast.iter_child_nodes(node):
            in_body = not types_only or child not in node.orelse
            yield from walk(child, top and not isinstance(node, LAZY), typing or (types_only and in_body))

    yield from walk(ast.parse(path.read_text(encoding="utf-8")), True, False)


def targets(node: ast.AST, package: str) -> list[str]:
    """What a statement or call imports, by full names; `from a import b` may mean the module a.b or a name in a."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        base = package.rsplit(".", node.level - 1)[0] if node.level else ""
        source = ".".join(filter(None, [base, node.module]))
        return [f"{source}.{alias.name}" for alias in node.names]
    if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
        return [arg.value for arg in node.args[:1] if isinstance(arg, ast.Constant) and isinstance(arg.value, str)]
    return []


def faults(root: Path) -> list[str]:
    """What in the tree under `root` breaks the house's rules, one line each."""
    known = modules(root)
    wrong, graph = [], {name: set() for name in known}
    for name, path in known.items():
        room = name.partition(".")[0]
        for target, line, at_top, types_only in imports(name, path):
            place = f"{path.relative_to(root)}:{line}"
            other = target.partition(".")[0]
            if other in FLOORS and other != room and FLOORS[other] >= FLOORS[room]:
                wrong.append(f"{place}: {room} imports {target}, expected only rooms on floors below")
            if other in HARDWARE and at_top and room != "devices":
                wrong.append(f"{place}: imports {target} at module level, expected in devices or in a function")
            module = next((m for m in (target, target.rpartition(".")[0]) if m in known), None)
            # What only type checkers read is never run, so it closes no circle.
            if module not in (None, name) and not types_only:
                graph[name].add(module)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as circle:
        wrong.append(f"modules import one another in a circle: {' <- '.join(circle.args[1])}")
    return wrong


def test_the_house_stands():
    assert (ROOT / "recordings").is_dir()
    assert faults(ROOT) == []


@pytest.mark.parametrize(
    ("files", "fault"),
    [
        ({"recordings/a.py": "import physics"}, "recordings imports physics"),
        ({"physics/a.py": "from calibrate.maps import b"}, "physics imports calibrate.maps.b"),
        ({"calibrate/a.py": "def f():\n    import viewers.html"}, "calibrate imports viewers.html"),
        ({"mismatch/a.py": "import fusion.depth"}, "mismatch imports fusion.depth"),
        ({"fusion/a.py": "from mismatch import b"}, "fusion imports mismatch.b"),
        (
            {"physics/a.py": "import importlib\nimportlib.import_module('fusion.b')"},
            "physics imports fusion.b",
        ),
        ({"recordings/a.py": "if TYPE_CHECKING:\n    import devices"}, "recordings imports devices"),
        ({"viewers/a.py": "try:\n    import pyrealsense2\nexcept ImportError:\n    pass"}, "imports pyrealsense2"),
        ({"difflidar/a.py": "class A:\n    from serial import Serial"}, "imports serial.Serial"),
        ({"physics/a.py": "import physics.b", "physics/b.py": "import physics.a"}, "circle"),
        ({"physics/a.py": "from . import b", "physics/b.py": "def f():\n    from physics.a import x"}, "circle"),
        ({"physics/c/__init__.py": "from .d import x", "physics/c/d.py": "from ..c import y"}, "circle"),
        (
            {
                "physics/a.py": "import physics.b",
                "physics/b.py": "from .c import x",
                "physics/c.py": "import physics.a",
            },
            "circle",
        ),
    ],
)
def test_a_crack_is_found(tmp_path, files, fault):
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    found = faults(tmp_path)
    assert len(found) == 1
    assert fault in found[0]


def test_a_sound_house_is_left_alone(tmp_path):
    files = {
        "recordings/a.py": "import numpy\nif TYPE_CHECKING:\n    from recordings.b import B",
        "recordings/b.py": "from recordings import a\nfrom recordings.a import x",
        "devices/c.py": "import serial\nimport recordings.a, calibrate.plan",
        "calibrate/plan.py": "def f():\n    import pyrealsense2",
        "difflidar/d.py": "from devices import c\nimport serial_port",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    assert faults(tmp_path) == []
