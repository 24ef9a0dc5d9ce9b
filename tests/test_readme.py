"""What the README shows first is as short as it looks, and does what the demo does."""

from __future__ import annotations

import re
from pathlib import Path

from kinestitch.cli import main
from kinestitch.files import read
from kinestitch.testing import assert_motion_close

README = Path(__file__).parents[1] / "README.md"


def test_seven_lines_make_the_demo(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    block = re.search(r"^```python\n(.*?)^```$", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert block is not None
    assert sum(bool(line.strip()) for line in block[1].splitlines()) == 7
    exec(block[1], {})
    assert main(["demo", "demo"]) == 0
    for name in ("walk_kick.bvh", "walk_kick.glb"):
        assert_motion_close(read(name), read(f"demo/{name}"))
