"""Every reader survives the kept cases and some fresh damage; `make fuzz` tries far more."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
FRESH = 200
LIBRARIES = {"usd": "pxr.Usd", "c3d": "ezc3d"}
"""That readers need and not everybody has."""


def names():
    """The names in the table of targets.py."""
    told = (HERE / "targets.py").read_text(encoding="utf-8")
    return re.findall(r'^    "(\w+)": Target\(', told, re.MULTILINE)


def test_there_are_readers():
    assert {"bvh", "fbx", "glb", "amc", "amass", "usd", "c3d"} <= set(names())
    assert all(folder.name in names() for folder in (HERE / "corpus").iterdir() if folder.is_dir())


@pytest.mark.skipif(sys.platform == "win32", reason="memory is limited with RLIMIT_AS, which Windows does not have")
@pytest.mark.parametrize("name", names())
def test_damaged_files_are_read_or_refused(name):
    if name in LIBRARIES:
        pytest.importorskip(LIBRARIES[name], reason=f"{LIBRARIES[name]}, of the extra {name}, is not installed")
    command = [sys.executable, str(HERE / "run.py"), name, "--count", str(FRESH), "--seed", "test"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, env=os.environ)
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
    assert f"{name}: " in done.stdout
