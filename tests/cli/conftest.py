"""The command line as a function: arguments in, exit code and both streams out; and small clips to give it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from kinestitch.cli import main
from kinestitch.core.motion import Motion
from kinestitch.files import write
from kinestitch.testing import random_motion


@dataclass(frozen=True)
class Ran:
    code: int
    out: str
    err: str

    @property
    def error(self) -> str:
        """The one line of a refusal; fails if there is anything else."""
        lines = self.err.splitlines()
        assert self.code == 2, (self.code, self.err)
        assert len(lines) == 1, lines
        assert lines[0].startswith("error: "), lines
        assert self.out == ""
        return lines[0]


@pytest.fixture
def kinestitch(capsys, monkeypatch, tmp_path):
    """Run the command line inside an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("KINESTITCH_TRACEBACK", raising=False)

    def run(*arguments: object) -> Ran:
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return Ran(code, out, err)

    return run


@pytest.fixture
def clip(tmp_path):
    """Write a random motion of one skeleton into the folder; returns what was written."""

    def make(name: str, *, frames: int = 60, fps: float = 30.0, seed: int = 0, joints: int = 4) -> Motion:
        motion = random_motion(seed, joints=joints, frames=frames, fps=fps)
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write(replace(motion, name=Path(name).stem), path)
        return motion

    return make
