"""Our sample as another program converted it: what we read from its files is what we gave it."""

from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.files import read
from kinestitch.samples import sample

HERE = Path(__file__).parent
FRAMES = slice(12, 36)


@pytest.fixture(scope="module")
def expected():
    motion = sample("kick", fps=30.0)
    return motion.skeleton.names, world_pose(motion).positions[FRAMES]


@pytest.mark.parametrize("suffix", ["fbx", "glb", "bvh"])
def test_blenders_files_show_the_sample(expected, suffix):
    names, positions = expected
    motion = read(HERE / f"kick_blender.{suffix}")
    assert (motion.frames, motion.fps) == (24, 30.0)
    assert sorted(motion.skeleton.names) == sorted(names)
    found = world_pose(motion).positions[:, [motion.skeleton.names.index(name) for name in names]]
    if suffix == "bvh":  # Blender writes BVH in its own world, Z up, and the format has no word for that
        found = np.stack([found[..., 0], found[..., 2], -found[..., 1]], axis=-1)
    np.testing.assert_allclose(found, positions, rtol=0, atol=1e-4)
