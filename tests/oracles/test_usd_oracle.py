"""USD that we write, as Blender shows it; and USD that Blender writes, as we read it."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.files import read, write
from kinestitch.files.usd_writing import joint_paths
from kinestitch.samples import sample
from kinestitch.testing import random_motion

pytestmark = pytest.mark.oracle
HERE = Path(__file__).parent
METRES = 1e-5  # measured 1.7e-6


def legal(motion):
    return [path.rsplit("/", 1)[-1] for path in joint_paths(motion.skeleton)]


def test_blender_puts_the_joints_where_we_do(ask_blender, tmp_path):
    motions = {"walk": sample("walk"), "random": random_motion(4, joints=8, frames=20)}
    requests = []
    for name, motion in motions.items():
        for suffix, unit in ((".usda", "m"), (".usdc", "cm")):
            path = tmp_path / f"{name}{suffix}"
            write(motion, path, unit=unit)
            requests.append({"path": path, "fps": motion.fps, "frames": min(motion.frames, 30)})
    for request, answer in zip(requests, ask_blender(requests), strict=True):
        motion = motions[request["path"].stem]
        assert "error" not in answer, answer["error"]
        order = [list(answer["names"]).index(name) for name in legal(motion)]
        expected = world_pose(motion).positions[: request["frames"]]
        np.testing.assert_allclose(answer["positions"][:, order], expected, atol=METRES)


def test_what_blender_writes_reads_as_it_was(tmp_path):
    python = HERE.parents[1] / ".venv-bpy" / "bin" / "python"
    if not python.exists():
        pytest.skip(".venv-bpy is missing; tests/oracles/setup.sh makes it")
    motion = sample("kick")
    write(motion, tmp_path / "ours.usda")
    command = [python, HERE / "export_usd.py", tmp_path / "ours.usda", tmp_path / "theirs.usdc", str(motion.fps)]
    subprocess.run([str(word) for word in command], check=True, capture_output=True, timeout=300)
    theirs = read(tmp_path / "theirs.usdc")
    assert (theirs.frames, theirs.fps) == (motion.frames, motion.fps)
    order = [theirs.skeleton.names.index(name) for name in legal(motion)]
    np.testing.assert_allclose(world_pose(theirs).positions[:, order], world_pose(motion).positions, atol=METRES)
