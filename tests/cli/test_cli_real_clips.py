"""The main job on real clips: a Mixamo walk with a kick pasted in, to every format, and damaged files."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.files import read
from kinestitch.rig.hips import hips_joint


@pytest.fixture(scope="module")
def data() -> Path:
    folder = os.environ.get("KINESTITCH_DATA")
    if not folder:
        pytest.skip("KINESTITCH_DATA, the folder of real clips, is not set")
    return Path(folder)


def hips_path(motion) -> np.ndarray:
    """World positions (F, 3) m of the hips."""
    return world_pose(motion).positions[:, hips_joint(motion.skeleton)]


def test_walk_kick_walk(kinestitch, data):
    walk, kick = (data / "mixamo_xbot_60fps" / f"{name}.fbx" for name in ("Walking", "Kicking"))
    outputs = [f"out{suffix}" for suffix in (".bvh", ".fbx", ".glb")]
    for output in outputs:
        words = ("--append", f"{kick}@20:110", "--append", walk, "--report", "r.json")
        assert kinestitch("stitch", walk, *words, "-o", output).code == 0
    sources = [hips_path(read(walk)), hips_path(read(kick))]
    largest = max(float(np.linalg.norm(np.diff(path, axis=0), axis=1).max()) for path in sources)
    told = json.loads(Path("r.json").read_text())
    assert [seam["frame"] for seam in told["seams"]] == [99, 189]
    assert all(seam["root_step_m_after"] <= 1.1 * largest for seam in told["seams"])
    paths = [hips_path(read(output)) for output in outputs]
    for path in paths:
        assert path.shape == (288, 3)
        assert np.abs(path - paths[0]).max() < 1e-4
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= 1.1 * largest
    first, last = sources[0], paths[0][-99:]
    assert np.linalg.norm(last[-1] - last[0]) == pytest.approx(np.linalg.norm(first[-1] - first[0]), abs=0.2)


def test_other_rates_and_prefixes_fit(kinestitch, data):
    ran = kinestitch(
        *("stitch", data / "mixamo_xbot_60fps" / "Walking.fbx", "--append", data / "mixamo_prefix8" / "idle.fbx@10:40"),
        *("--insert", 50, data / "mixamo_xbot_30fps" / "Jumping Jacks.fbx@3:21", "-o", "out.glb"),
    )
    assert ran.code == 0
    assert read("out.glb").fps == 60


def test_every_damaged_file_is_one_line(kinestitch, data):
    found = sorted((data / "conformance_fbx" / "fuzz").iterdir())
    assert found
    for path in found:
        ran = kinestitch("info", path)
        assert ran.code in {0, 2}
        assert "fault of our own" not in ran.err, (path.name, ran.err)
        assert ran.err.count("\n") <= 1 or ran.code == 0
