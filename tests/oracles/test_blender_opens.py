"""Blender opens every file that we write, and finds every joint where we put it."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.errors import MissingExtraError
from kinestitch.files import read, write
from kinestitch.files.bvh import UNITS
from kinestitch.samples import sample
from kinestitch.testing import random_motion

pytestmark = pytest.mark.oracle

METRES = 5e-4
SUFFIXES = (".bvh", ".fbx", ".glb", ".gltf", ".usd", ".usda", ".usdc")
CHARACTERS = ("mixamo_skinned/Michelle.glb", "mixamo_skinned/Xbot.glb", "mixamo_skinned/Soldier.glb", "gltf/Knight.glb")


def clips():
    walk = sample("walk", fps=30)
    return {
        "walk": replace(walk, translations=walk.translations[:40], rotations=walk.rotations[:40]),
        "random": random_motion(4, joints=12, frames=40, fps=60.0, bend=3.0, skeleton_seed=4),
        "slow": random_motion(5, joints=3, frames=10, fps=24.0, bend=1.0),
    }


def asked(path, motion, **more):
    return {"path": path, "fps": motion.fps, "frames": motion.frames, "unit": UNITS["cm"], **more}


def assert_joints_there(motion, answer, what):
    assert "error" not in answer, (what, answer["error"])
    names = list(answer["names"])
    spelt = [name if name in names else name.replace(":", "_") for name in motion.skeleton.names]
    theirs = answer["positions"][:, [names.index(name) for name in spelt]]
    apart = np.linalg.norm(world_pose(motion).positions - theirs, axis=-1)
    assert apart.max() <= METRES, (what, apart.max(), np.unravel_index(apart.argmax(), apart.shape))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_joint_of_every_format(ask_blender, tmp_path, suffix):
    pairs = [(tmp_path / f"{name}{suffix}", motion) for name, motion in clips().items()]
    try:
        for path, motion in pairs:
            write(motion, path, **({"unit": "cm"} if suffix == ".bvh" else {}))
    except MissingExtraError as error:
        pytest.skip(str(error))
    for (path, motion), answer in zip(pairs, ask_blender([asked(*pair) for pair in pairs]), strict=True):
        assert_joints_there(motion, answer, path.name)


def test_kept_characters_move_as_told(ask_blender, tmp_path):
    """Another motion in a file with mesh, skin and several animations."""
    home = os.environ.get("KINESTITCH_DATA")
    if not home:
        pytest.skip("KINESTITCH_DATA is unset: no real characters")
    pairs, requests = [], []
    for name in CHARACTERS:
        source = Path(home) / name
        motion = read(source)
        frames = slice(None, None, -1)
        back = replace(motion, translations=motion.translations[frames], rotations=motion.rotations[frames])
        path = tmp_path / source.name
        write(back, path, like=source)
        pairs.append((path, back))
        requests.append(asked(path, back, take=back.name))
    for (path, motion), answer in zip(pairs, ask_blender(requests), strict=True):
        assert_joints_there(motion, answer, path.name)
