"""Another motion in real FBX files: everything that is no animation stays, and the motion comes back."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.core.rotation import quat_distance, quat_multiply, quat_normalize, rotvec_to_quat
from kinestitch.errors import FormatError
from kinestitch.files import has_character
from kinestitch.files.fbx import read_fbx, write_fbx
from kinestitch.files.fbx.binary import is_binary, parse_binary, serialise
from kinestitch.files.fbx.nodes import Document

HOME = os.environ.get("KINESTITCH_DATA")
pytestmark = pytest.mark.skipif(not HOME, reason="KINESTITCH_DATA is unset: no real clips")
ANIMATION = {"AnimationCurve", "AnimationCurveNode", "AnimationLayer", "AnimationStack"}
TOLD = {"Objects", "Connections", "Definitions", "GlobalSettings", "Takes"}
FOLDERS = {"mixamo_skinned": 3, "mixamo_other_rigs": 10, "mixamo_prefix8": 1, "ue_mannequin": 2, "conformance_fbx": 25}
FLAT = "ufbx_maya_zero_scale_pivot_7700_binary.fbx"


def files(folder):
    """Binary FBX 7 files of a folder."""
    found = []
    for path in sorted((Path(HOME) / folder).iterdir()):
        if path.suffix.lower() == ".fbx":
            with path.open("rb") as stream:
                head = stream.read(27)
            if is_binary(head) and int.from_bytes(head[23:27], "little") >= 7000:
                found.append(path)
    return found


def another(motion, frames, fps):
    rng = np.random.default_rng(frames)
    time = np.arange(frames)[:, None, None] / fps
    joints = motion.skeleton.joint_count
    swing = rng.normal(size=(joints, 3)) * np.sin(2 * time + rng.uniform(0, 6, size=(joints, 3)))
    translations = np.repeat(motion.translations[:1], frames, axis=0)
    translations[:, 0] += 0.3 * np.sin(time[:, 0] * np.array([1.0, 2.0, 3.0]))
    rotations = quat_normalize(quat_multiply(motion.rotations[:1], rotvec_to_quat(swing)))
    return replace(motion, translations=translations, rotations=rotations, fps=fps)


def assert_same_in_the_world(again, motion):
    """World poses of all joints but the one that stands for the scene, which no file can move."""
    assert (again.frames, again.fps, again.skeleton) == (motion.frames, motion.fps, motion.skeleton)
    joints = [j for j, name in enumerate(motion.skeleton.names) if j or name != "Root"]
    one, other = world_pose(again), world_pose(motion)
    assert np.linalg.norm((one.positions - other.positions)[:, joints], axis=-1).max() < 1e-4
    assert np.degrees(quat_distance(one.rotations, other.rotations)[:, joints]).max() < 0.01


def assert_kept(path, new):
    before, after = (parse_binary(Path(file).read_bytes()) for file in (path, new))
    assert before.version == after.version

    def encoded(entry):
        return serialise(Document(before.version, (entry,)))

    for one, other in zip(before.nodes, after.nodes, strict=True):
        if one.name == "Objects":
            pair = [[e for e in home.children if e.name not in ANIMATION] for home in (one, other)]
            assert [encoded(e) for e in pair[0]] == [encoded(e) for e in pair[1]]
        elif one.name not in TOLD:
            assert encoded(one) == encoded(other)


@pytest.mark.parametrize(("folder", "least"), FOLDERS.items())
def test_another_motion_comes_back_and_the_rest_is_kept(folder, least, tmp_path):
    kept = 0
    for path in files(folder):
        try:
            motion = read_fbx(path)
        except FormatError:
            continue
        if path.name == FLAT:
            continue
        for told in (motion, another(motion, 21, 120.0 if motion.fps < 50 else 24.0)):
            write_fbx(told, tmp_path / "new.fbx", like=path)
            assert_same_in_the_world(read_fbx(tmp_path / "new.fbx"), told)
        assert_kept(path, tmp_path / "new.fbx")
        kept += 1
    assert kept >= least


def test_scale_of_nothing_is_refused(tmp_path):
    path = Path(HOME) / "conformance_fbx" / FLAT
    with pytest.raises(FormatError, match="scale"):
        write_fbx(read_fbx(path), tmp_path / "never.fbx", like=path)


def test_the_skinned_files_have_characters():
    skinned = [path for path in (Path(HOME) / "mixamo_skinned").iterdir() if path.suffix == ".fbx"]
    assert len(skinned) == 3
    assert all(map(has_character, skinned))
    assert not has_character(Path(HOME) / "mixamo_xbot_60fps" / "Walking.fbx")
