"""The house rules, read off the source: who imports whom, one door for each library, and how long anything may be.

Imports inside functions and under TYPE_CHECKING count like all others: whoever needs a type from above depends on it.
"""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]
SOURCE = PROJECT / "src" / "kinestitch"
MODULES = sorted(SOURCE.rglob("*.py"))

BELOW = {
    "errors": "",
    "core": "errors",
    "files": "errors core",
    "edit": "errors core",
    "rig": "errors core",
    "samples": "errors core",
    "solve": "errors core edit rig",
    "search": "errors core edit rig solve",
    "analysis": "errors core edit rig solve",
    "render": "errors core edit rig solve analysis",
    "testing": "errors core",
    "experiments": "errors core files edit rig samples solve search analysis render",
    "cli": "errors core files edit rig samples solve search analysis render experiments",
    "__main__": "cli",
    "__init__": "errors core files edit rig samples solve search analysis render",
}
"""Each room and what it may import. The front door (`__init__`) hands out names from all of them when they are asked
for.
"""

ABOVE_ERRORS = tuple(room for room in BELOW if room not in ("errors", "__init__", "__main__", "testing"))

DOORS = {
    "numpy": (*ABOVE_ERRORS, "testing.py"),
    "scipy": ("core", "solve", "samples"),
    "matplotlib": ("analysis/plots.py", "render", "experiments/page.py", "experiments/pdf.py"),
    "bpy": ("experiments/blender_side.py",),
    "opentimelineio": ("edit/document.py",),
    "click": ("cli",),
    "rich": ("cli",),
    "hypothesis": ("testing.py",),
    "av": ("render/encoder.py",),
    "pxr": ("files/usd.py", "files/usd_animation.py", "files/usd_rig.py", "files/usd_writing.py"),
    "ezc3d": ("files/c3d.py",),
}
"""Each library and the only places that may import it."""

MOST_LINES, LONGEST_BODY = 400, 40

LONG_BODIES: dict[str, str] = {}
"""Functions that may be longer, as ``room/module.py:function``, each with its reason."""


def room_of(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def imports(tree: ast.AST, package: tuple[str, ...] = ()) -> Iterator[tuple[str, int]]:
    """Every imported module as a dotted name, and its line; ``from a import b`` gives ``a.b``.

    What `files.extras.optional` imports when it is asked for counts too.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (base, node.module) if part)
            yield from ((f"{module}.{alias.name}", node.lineno) for alias in node.names)
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "optional":
            yield from ((str(arg.value), node.lineno) for arg in node.args[:1] if isinstance(arg, ast.Constant))


def imports_of(path: Path) -> list[tuple[str, int]]:
    package = ("kinestitch", *path.relative_to(SOURCE).parts[:-1])
    return list(imports(ast.parse(path.read_text(encoding="utf-8")), package))


def upward(path: Path) -> list[str]:
    """Imports of a module that its room may not have."""
    room, wrong = room_of(path), []
    allowed = {room, *BELOW.get(room, "").split()}
    for name, line in imports_of(path):
        parts = name.split(".")
        if parts[0] != "kinestitch" or name == "kinestitch.__version__":
            continue
        other = parts[1] if len(parts) > 1 else "__init__"
        if other not in BELOW:
            other = "__init__"  # a name from the front door
        if other not in allowed and not (room == "cli" and other == "__init__"):
            wrong.append(f"{path.relative_to(SOURCE)}:{line} imports {name}")
    return wrong


def foreign(path: Path) -> list[str]:
    """Imports of libraries that have their door elsewhere, or none."""
    place, wrong = path.relative_to(SOURCE).as_posix(), []
    for name, line in imports_of(path):
        library = name.split(".")[0]
        if library == "kinestitch" or library in sys.stdlib_module_names:
            continue
        if not any(place == door or place.startswith(door + "/") for door in DOORS.get(library, ())):
            wrong.append(f"{place}:{line} imports {name}")
    return wrong


def long_bodies(path: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            documented = ast.get_docstring(node) is not None and len(node.body) > 1
            first = node.body[1 if documented else 0]
            length = (node.end_lineno or 0) - first.lineno + 1
            name = f"{path.relative_to(PROJECT).as_posix()}:{node.name}"
            if length > LONGEST_BODY and name not in LONG_BODIES:
                found.append(f"{name} has {length} lines")
    return found


def test_there_are_modules_to_look_at():
    assert len(MODULES) > 30
    assert {room_of(path) for path in MODULES} <= set(BELOW)
    assert {"core", "files", "edit", "rig", "solve", "cli"} <= {room_of(path) for path in MODULES}


def test_no_import_goes_upward():
    assert [wrong for path in MODULES for wrong in upward(path)] == []


def test_every_library_has_one_door():
    assert [wrong for path in MODULES for wrong in foreign(path)] == []


def test_rooms_form_no_circle():
    for room, below in BELOW.items():
        for other in below.split():
            assert room not in BELOW[other].split(), f"{room} and {other} import each other"
            assert set(BELOW[other].split()) <= set(below.split()) or room in ("__main__",), (
                f"{room} skips what {other} rests on"
            )


def test_every_room_is_in_the_plan_of_the_house():
    plan = (PROJECT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    missing = [room for room in sorted({room_of(p) for p in MODULES if p.parent != SOURCE}) if room not in plan]
    assert missing == []


@pytest.mark.parametrize("folder", ["src", "tests", "benchmarks", "examples"])
def test_nothing_grows_too_long(folder: str):
    files = sorted(path for path in (PROJECT / folder).rglob("*.py") if "node_modules" not in path.parts)
    assert files
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in files}
    assert {path.name: count for path, count in lines.items() if count > MOST_LINES} == {}
    assert [long for path in files for long in long_bodies(path)] == []


def test_no_module_is_a_drawer_for_odds_and_ends():
    words = {"utils", "util", "helpers", "helper", "common", "misc", "shared"}
    assert [path for path in (*MODULES, *(PROJECT / "tests").rglob("*.py")) if words & set(path.stem.split("_"))] == []


def modules_after(code: str) -> set[str]:
    script = f"import sys, json\n{code}\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_importing_the_package_imports_no_library():
    loaded = {name.split(".")[0] for name in modules_after("import kinestitch")}
    assert "kinestitch" in loaded
    assert loaded & {"scipy", "matplotlib", "opentimelineio", "click", "rich", "hypothesis"} == set()


def test_the_front_door_needs_no_pictures_and_no_documents():
    code = "import kinestitch\nfor name in kinestitch.__all__: getattr(kinestitch, name)"
    loaded = {name.split(".")[0] for name in modules_after(code)}
    assert "numpy" in loaded
    assert loaded & {"matplotlib", "opentimelineio", "click", "rich", "hypothesis"} == set()


def test_this_test_sees_imports_wherever_they_stand():
    text = """
from __future__ import annotations
import a.b, c
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    from kinestitch.cli import main
def f():
    try:
        from kinestitch import files
    except ImportError:
        import scipy.linalg as la
    from . import sibling
    from ..core.motion import Motion
"""
    found = {name for name, _ in imports(ast.parse(text), ("kinestitch", "solve"))}
    assert {
        "a.b",
        "c",
        "kinestitch.cli.main",
        "kinestitch.files",
        "scipy.linalg",
        "kinestitch.solve.sibling",
        "kinestitch.core.motion.Motion",
    } <= found


@pytest.mark.parametrize(
    ("place", "text", "check"),
    [
        ("core/x.py", "from kinestitch.edit.timeline import Seam", upward),
        ("files/x.py", "def f():\n    from kinestitch.edit import timeline", upward),
        ("edit/x.py", "import kinestitch.files", upward),
        ("solve/x.py", "from kinestitch import stitch", upward),
        ("solve/x.py", "import matplotlib.pyplot", foreign),
        ("files/x.py", "import scipy", foreign),
        ("edit/schema.py", "import opentimelineio", foreign),
        ("render/x.py", "import click", foreign),
        ("core/x.py", "import pandas", foreign),
        ("core/x.py", "def f():\n" + "    x = 1\n" * 41, long_bodies),
    ],
)
def test_this_test_finds_what_is_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str, text: str, check):
    monkeypatch.setattr(sys.modules[__name__], "SOURCE", tmp_path)
    monkeypatch.setattr(sys.modules[__name__], "PROJECT", tmp_path)
    path = tmp_path / place
    path.parent.mkdir(parents=True)
    path.write_text(text, encoding="utf-8")
    assert check(path)
