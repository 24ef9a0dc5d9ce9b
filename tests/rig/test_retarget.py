"""The same body with other rest poses, joint axes, names and sizes shows the same motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig_builders import a_posed, below_a_dummy, drawn_along_x, hanging, renamed, scaled, with_rest, without

import kinestitch as ks
from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.core.rotation import quat_distance, quat_multiply, rotvec_to_quat
from kinestitch.errors import KinestitchWarning, SkeletonMismatchError
from kinestitch.experiments.retargeting import direction_errors
from kinestitch.rig.mapping import Mapping, Pair, find_mapping
from kinestitch.rig.retarget import retarget, retargeted
from kinestitch.testing import assert_motion_close, check_motion, random_motion

JOINTS = 33
CLIPS = ("walk", "kick", "jumping_jacks")


def gap(one, other) -> float:
    """Largest distance in m between joints of the sample body."""
    ours, theirs = (world_pose(motion).positions[:, -JOINTS:] for motion in (one, other))
    return float(np.linalg.norm(ours - theirs, axis=-1).max())


def turned_apart(one, other) -> float:
    """Largest angle in degrees between the world rotations of two motions of one rig."""
    return float(np.degrees(quat_distance(world_pose(one).rotations, world_pose(other).rotations).max()))


def test_a_motion_of_the_rig_comes_back():
    motion = ks.sample("walk")
    assert retarget(motion, motion.skeleton) is motion
    assert_motion_close(retargeted(motion, motion.skeleton).motion, motion, degrees=1e-5, metres=1e-9)


@pytest.mark.parametrize("rig", [a_posed, hanging, below_a_dummy])
@pytest.mark.parametrize("clip", CLIPS)
def test_rest_poses_and_axes_drop_out(rig, clip):
    plain = ks.sample(clip)
    other = rig(plain)
    assert gap(other, plain) < 1e-9
    there, back = retargeted(plain, other.skeleton).motion, retargeted(other, plain.skeleton).motion
    check_motion(there)
    assert gap(there, plain) < 1e-4
    assert gap(back, plain) < 1e-4
    assert turned_apart(there, other) < 0.01  # twist too
    assert turned_apart(back, plain) < 0.01
    assert there.skeleton is other.skeleton


@pytest.mark.parametrize("clip", CLIPS)
def test_a_rest_pose_of_zero_angles_is_understood_from_the_motion(clip):
    """Trunk bones are taken as upright there, which the sample's neck is not quite."""
    plain = ks.sample(clip)
    zero = drawn_along_x(plain)
    for result, truth in (
        (retargeted(zero, plain.skeleton).motion, plain),
        (retargeted(plain, zero.skeleton, example=zero).motion, zero),
    ):
        errors = direction_errors(result, plain)
        assert max(errors[limb] for limb in ("upper arm", "forearm", "thigh", "shin", "foot")) < 0.1
        assert errors["trunk"] < 1
        limbs = [j for j, name in enumerate(plain.skeleton.names) if name.endswith(("Arm", "Leg", "Hand", "Foot"))]
        ours, theirs = (world_pose(motion).rotations[:, limbs] for motion in (result, truth))
        assert np.degrees(quat_distance(ours, theirs)).max() < 0.5


def test_twist_is_kept():
    """A forearm that turns about itself turns about itself on a rig with another rest pose."""
    plain = ks.sample("idle")
    joint = plain.skeleton.index("mixamorig:LeftForeArm")
    rotations = plain.rotations.copy()
    turns = np.linspace(0, 2.5, plain.frames)[:, None] * [1.0, 0.0, 0.0]
    rotations[:, joint] = quat_multiply(rotations[:, joint], rotvec_to_quat(turns))
    twisted = replace(plain, rotations=rotations)
    other = a_posed(twisted)
    assert turned_apart(retargeted(twisted, other.skeleton).motion, other) < 0.01


def test_facing_elsewhere_at_rest_and_in_the_world():
    plain = ks.sample("walk")
    turned = with_rest(plain, {"Hips": [0, 135, 0]})
    assert gap(retargeted(plain, turned.skeleton).motion, plain) < 1e-4
    moved = turn_about_up(plain, 1.0, (1.0, 0.0, -2.0))
    there = retargeted(moved, a_posed(plain).skeleton).motion
    assert gap(there, moved) < 1e-4


@pytest.mark.parametrize("factor", [0.001, 0.5, 1.0, 2.0])
def test_the_path_is_scaled_by_the_height_of_the_hips(factor):
    plain = ks.sample("walk")
    small = scaled(plain, factor)
    result = retargeted(plain, small.skeleton).motion
    assert gap(result, small) < 1e-4 * factor


def test_other_names_are_matched_by_role():
    plain = ks.sample("kick")
    other = renamed(plain, {"hips": "pelvis", "left_hand": "hand_l", "spine_2": "spine_02"})
    assert_motion_close(retargeted(plain, other.skeleton).motion, other, degrees=1e-4, metres=1e-6)


def long_legged(motion):
    """Longer thighs, shorter shins, hips further apart: legs as long as before."""
    offsets = motion.skeleton.offsets.copy()
    for side, out in (("Left", 0.03), ("Right", -0.03)):
        leg, foot, top = (motion.skeleton.index(f"mixamorig:{side}{part}") for part in ("Leg", "Foot", "UpLeg"))
        offsets[leg, 1] -= 0.05
        offsets[foot, 1] += 0.05
        offsets[top, 0] += out
    return replace(motion.skeleton, offsets=offsets)


def test_feet_stand_where_the_source_s_do():
    plain = ks.sample("walk")
    skeleton = long_legged(plain)
    planted = retargeted(plain, skeleton).motion
    kept = retargeted(plain, skeleton, foot_ik=False).motion
    toe = plain.skeleton.index("mixamorig:LeftToeBase")
    paths = {
        name: world_pose(motion).positions[:, toe]
        for name, motion in (("source", plain), ("planted", planted), ("kept", kept))
    }
    steps = {name: np.diff(path, axis=0) for name, path in paths.items()}
    still = np.linalg.norm(steps["source"], axis=-1) < 1e-3
    assert still.sum() > 20
    planted_slide, kept_slide = (
        np.linalg.norm(steps[name] - steps["source"], axis=-1)[still].max() for name in ("planted", "kept")
    )
    assert planted_slide < kept_slide / 3
    assert np.abs(paths["planted"][:, 1] - paths["source"][:, 1]).max() < 5e-3
    errors = direction_errors(kept, plain)
    assert max(errors[limb] for limb in ("thigh", "shin", "foot")) < 0.01


@pytest.mark.parametrize("factor", [0.8, 1.0])
def test_rigs_without_toes_stand_too(factor):
    plain = ks.sample("walk")
    bare = without(scaled(plain, factor), "Toe")
    back = retargeted(bare, plain.skeleton).motion
    there = retargeted(plain, bare.skeleton, example=bare).motion
    ankle = plain.skeleton.index("mixamorig:LeftFoot")
    heights = [world_pose(motion).positions[:, ankle, 1].min() for motion in (plain, back)]
    assert abs(heights[0] - heights[1]) < 0.01
    ankle = bare.skeleton.index("mixamorig:LeftFoot")
    heights = [world_pose(motion).positions[:, ankle, 1].min() for motion in (bare, there)]
    assert abs(heights[0] - heights[1]) < 0.01


def test_an_example_moves_the_target():
    plain = ks.sample("walk")
    with pytest.raises(SkeletonMismatchError, match="an example that moves the target rig"):
        retargeted(plain, a_posed(plain).skeleton, example=plain)


def test_unmapped_joints_keep_their_rest_and_are_told():
    plain = ks.sample("walk")
    other = renamed(plain, {f"left_middle_{n}": f"claw {n}" for n in range(1, 5)})
    with pytest.warns(KinestitchWarning, match=r"4 of 33 joints keep their rest: claw 1, claw 2, claw 3, claw 4\.$"):
        result = retarget(plain, other.skeleton)
    claw = other.skeleton.index("claw 2")
    assert np.abs(result.rotations[:, claw] - other.skeleton.rest[claw]).max() < 1e-12
    assert np.array_equal(
        result.translations[:, claw], np.broadcast_to(other.skeleton.offsets[claw], (plain.frames, 3))
    )
    assert retargeted(plain, other.skeleton).unmapped == ("claw 1", "claw 2", "claw 3", "claw 4")


def test_doubt_is_an_error_and_a_mapping_mends_it():
    plain = ks.sample("walk")
    other = renamed(plain, {"left_lower_arm": "Tentacle"})
    with pytest.raises(SkeletonMismatchError, match="do not tell left_lower_arm, left_hand of the target"):
        retarget(plain, other.skeleton)
    mapping = find_mapping(plain.skeleton, other.skeleton)
    mended = Mapping((*mapping.pairs, Pair("Tentacle", "mixamorig:LeftForeArm")))
    assert_motion_close(retargeted(plain, other.skeleton, mended).motion, other, degrees=1e-4, metres=1e-6)


def test_a_mapping_of_the_upper_body_leaves_the_legs_at_rest():
    plain = ks.sample("kick")
    pairs = tuple(pair for pair in find_mapping(plain.skeleton, plain.skeleton).pairs if "Leg" not in pair.target)
    result = retargeted(plain, plain.skeleton, Mapping(pairs))
    leg = plain.skeleton.index("mixamorig:LeftUpLeg")
    assert np.abs(result.motion.rotations[:, leg] - plain.skeleton.rest[leg]).max() < 1e-9
    assert "mixamorig:LeftUpLeg" in result.unmapped


def test_bodies_without_limbs_need_a_mapping():
    snake = random_motion(1, joints=5)
    with pytest.raises(SkeletonMismatchError, match="any limb of the source; any limb of the target"):
        retarget(snake, random_motion(2, joints=5, skeleton_seed=3).skeleton)
    pairs = tuple(Pair(name, name) for name in snake.skeleton.names)
    result = retargeted(snake, snake.skeleton, Mapping(pairs)).motion
    assert_motion_close(result, snake, degrees=1e-5, metres=1e-6)


def test_one_frame_is_a_motion():
    plain = ks.sample("kick")
    one = replace(plain, rotations=plain.rotations[:1], translations=plain.translations[:1])
    assert gap(retargeted(one, hanging(plain).skeleton).motion, one) < 1e-4
    check_motion(retargeted(drawn_along_x(one), plain.skeleton).motion)
