"""Reading a file beside Blender's importers and ufbx: same file, same run, each in the program's own process.

Blender builds an armature with keys, ufbx a scene; ours gives a motion on every frame. The times are of different work
to the same end, a clip that can be used, and do not count starting the programs.
"""

import json
import subprocess
from pathlib import Path
from time import perf_counter

import pytest

from kinestitch.files import read, write
from kinestitch.testing import random_motion

JOINTS, FRAMES, ROUNDS = 65, 600, 5
HERE = Path(__file__).parent


def timed_by(environment, program, rounds, path):
    """Seconds by importer, of a program in an environment of its own; skips where there is none."""
    python = HERE.parent / environment / "bin" / "python"
    if not python.exists():
        pytest.skip(f"{environment} is missing; tests/oracles/setup.sh makes it")
    command = [str(python), str(HERE / "time_importers.py"), program, str(rounds), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr[-500:]
    return json.loads(done.stdout)[str(path)]


@pytest.mark.parametrize(
    ("suffix", "environment", "program"),
    [(".bvh", ".venv-bpy", "bpy"), (".fbx", ".venv-bpy", "bpy"), (".fbx", ".venv-ufbx", "ufbx")],
)
def test_reading_beside_another_program(tmp_path, note, quick, suffix, environment, program):
    frames, rounds = (30, 1) if quick else (FRAMES, ROUNDS)
    path = tmp_path / f"clip{suffix}"
    write(random_motion(1, joints=JOINTS, frames=frames, bend=1.0), path)
    before = least_reading(path, rounds)
    theirs = timed_by(environment, program, rounds, path)
    ours = min(before, least_reading(path, rounds))
    assert theirs
    for name, seconds in theirs.items():
        what = f"read {suffix}, {JOINTS} joints, {frames} frames, {1000 * ours:.0f} ms"
        note(what, name, ours / seconds, "for scale" if "no poses" in name else "at most 1")


def least_reading(path, rounds):
    """Seconds that our reader takes at best, after one warm-up."""
    read(path)
    times = []
    for _ in range(rounds):
        begun = perf_counter()
        read(path)
        times.append(perf_counter() - begun)
    return min(times)
