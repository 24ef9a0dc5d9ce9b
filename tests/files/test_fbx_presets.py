"""FBX files as other programs like them: the same world poses whatever the axes, units and root."""

from dataclasses import replace

import numpy as np
import pytest

import kinestitch.files
from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance, quat_multiply, quat_normalize, rotvec_to_quat
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError
from kinestitch.files.fbx import PRESETS, read_fbx, write_fbx
from kinestitch.files.fbx.binary import parse_binary
from kinestitch.files.fbx.scene import Scene

NAMES = ("Hips", "Spine", "LeftLeg", "LeftFoot")


def walker(names=NAMES, hips=1.0):
    """Four joints, hips on top, that go about and turn."""
    offsets = [[0, hips, 0], [0, 0.5, 0], [0.1, -0.1, 0], [0, -0.8, 0.05]]
    rest = quat_normalize(np.random.default_rng(1).normal(size=(4, 4)) * 0.2 + [0, 0, 0, 1])
    skeleton = Skeleton(names, (-1, 0, 0, 2), rotated(offsets, rest), rest)
    time = np.arange(40)[:, None, None] / 24
    swing = rotvec_to_quat(np.array([[0, 1.0, 0.2], [0.5, 0, 0], [0, 0, 0.9], [0.3, 0, 0]]) * np.sin(3 * time))
    translations = np.repeat(skeleton.offsets[None], 40, axis=0)
    translations[:, 0] += time[:, 0] * [0.3, 0.0, 1.2]
    return Motion(skeleton, translations, quat_normalize(quat_multiply(rest, swing)), 24, "walk")


def rotated(places, rest):
    """Offsets in turned parents that put the joints where plain ones would."""
    from kinestitch.core.kinematics import local_from_world

    bare = Skeleton(tuple("abcd"), (-1, 0, 0, 2), np.array(places, dtype=float))
    world = rest_pose(replace(bare, rest=rest))[1]
    return local_from_world(bare, rest_pose(bare)[0], world)[0]


def read_back(motion, tmp_path, preset):
    path = tmp_path / f"{preset}.fbx"
    kinestitch.files.write(motion, path, preset=preset)
    return read_fbx(path), Scene(parse_binary(path.read_bytes()))


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_world_poses_are_the_same_under_every_preset(tmp_path, preset):
    motion = walker()
    again, _ = read_back(motion, tmp_path, preset)
    assert (again.fps, again.frames) == (24, 40)
    pick = [again.skeleton.names.index(name) for name in NAMES]
    one, other = world_pose(motion), world_pose(again)
    assert np.abs(one.positions - other.positions[:, pick]).max() < 1e-6
    assert np.degrees(quat_distance(one.rotations, other.rotations[:, pick])).max() < 1e-3
    rest, told = rest_pose(motion.skeleton), rest_pose(again.skeleton)
    assert np.abs(rest[0] - told[0][pick]).max() < 1e-9
    assert np.degrees(quat_distance(rest[1], told[1][pick])).max() < 1e-5


@pytest.mark.parametrize(
    ("preset", "up", "metres", "joints"),
    [("unity", 1, 0.01, 4), ("maya", 1, 0.01, 4), ("unreal", 2, 0.01, 5), ("blender", 2, 1.0, 4)],
)
def test_the_file_says_what_the_preset_says(tmp_path, preset, up, metres, joints):
    again, scene = read_back(walker(), tmp_path, preset)
    assert scene.settings["UpAxis"] == (up,)
    assert np.linalg.det(scene.axes) == 1
    assert scene.metres_per_unit == metres
    assert again.skeleton.joint_count == joints
    says = PRESETS[preset].says
    assert ("Z up" in says) == (up == 2)
    assert ("centimetres" in says) == (metres == 0.01)
    assert ("root" in says) == (joints == 5)


def test_unreal_gets_a_still_root_on_the_ground_above_hips(tmp_path):
    again, scene = read_back(walker(), tmp_path, "unreal")
    assert again.skeleton.names[0] == "root"
    root = next(iter(scene.models.values()))
    for name in ("Lcl Translation", "Lcl Rotation", "PreRotation"):
        assert np.abs(root.vector(name)).max() < 1e-6
    assert np.abs(world_pose(again).positions[:, 0]).max() < 1e-9


def test_unreal_keeps_a_root_on_the_ground_and_turns_its_axes_only(tmp_path):
    names = ("Base", "Spine", "LeftLeg", "LeftFoot")
    skeleton = Skeleton(names, (-1, 0, 1, 2), [[0, 0, 0], [0, 1, 0], [0, 0.5, 0], [0, 0.2, 0]])
    motion = replace(walker(), skeleton=skeleton)
    again, scene = read_back(motion, tmp_path, "unreal")
    assert again.skeleton.names == names
    assert np.abs(world_pose(again).positions - world_pose(motion).positions).max() < 1e-6
    assert np.abs(next(iter(scene.models.values())).vector("PreRotation")).max() < 1e-6


def test_the_new_root_takes_no_name_that_is_in_use(tmp_path):
    again, _ = read_back(walker(("Root", "_root", "a", "b")), tmp_path, "unreal")
    assert again.skeleton.names == ("__root", "Root", "_root", "a", "b")


def test_an_unknown_preset_and_one_beside_a_kept_file_are_refused(tmp_path):
    motion = walker()
    with pytest.raises(ParameterError, match="unity, unreal, blender, maya, got 'max'"):
        write_fbx(motion, tmp_path / "a.fbx", preset="max")
    write_fbx(motion, tmp_path / "a.fbx")
    with pytest.raises(ParameterError, match=r"like= or preset="):
        write_fbx(motion, tmp_path / "b.fbx", like=tmp_path / "a.fbx", preset="unity")
    with pytest.raises(ParameterError, match="preset"):
        kinestitch.files.write(motion, tmp_path / "a.bvh", preset="unity")
