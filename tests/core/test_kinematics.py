"""Forward kinematics and its inverse, other joint axes for the same body, and legs that reach their targets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinestitch.core import kinematics as kk
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance, quat_identity, quat_normalize, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError
from kinestitch.testing import assert_motion_close, check_motion, motions, random_motion

SEEDS = st.integers(0, 2**32 - 1)


def with_tips(motion: Motion) -> Motion:
    rig = motion.skeleton
    tips = np.full((rig.joint_count, 3), np.nan)
    tips[-1] = [0.1, 0.2, 0.3]
    return replace(motion, skeleton=replace(rig, tips=tips))


@given(motions(joints=6, frames=5))
def test_world_pose_is_the_product_of_matrices(motion: Motion):
    pose = kk.world_pose(motion)
    matrices = np.zeros((motion.frames, 6, 4, 4))
    for f in range(motion.frames):
        for j, parent in enumerate(motion.skeleton.parents):
            local = np.eye(4)
            local[:3, :3] = Rotation.from_quat(motion.rotations[f, j]).as_matrix()
            local[:3, 3] = motion.translations[f, j]
            matrices[f, j] = local if parent < 0 else matrices[f, parent] @ local
    np.testing.assert_allclose(pose.positions, matrices[..., :3, 3], rtol=0, atol=1e-13)
    theirs = Rotation.from_matrix(matrices[..., :3, :3].reshape(-1, 3, 3)).as_quat()
    assert quat_distance(pose.rotations.reshape(-1, 4), theirs).max() < 1e-13
    assert not pose.positions.flags.writeable
    assert not pose.rotations.flags.writeable


@given(motions(joints=7, frames=6), st.data())
def test_some_joints_are_where_they_are_among_all(motion: Motion, data: st.DataObject):
    count = motion.skeleton.joint_count
    joints = data.draw(st.lists(st.integers(0, count - 1), max_size=3))
    whole, some = kk.world_pose(motion), kk.world_pose(motion, joints)
    kept = sorted({above for joint in joints for above in motion.skeleton.chain(joint)})
    others = np.setdiff1d(np.arange(count), kept)
    for theirs, ours in ((whole.positions, some.positions), (whole.rotations, some.rotations)):
        assert ours.shape == theirs.shape
        np.testing.assert_array_equal(ours[:, kept], theirs[:, kept])
        assert np.isnan(ours[:, others]).all()
        assert not ours.flags.writeable


@pytest.mark.parametrize("joint", [-1, 7])
def test_joints_that_the_rig_lacks_are_refused(joint: int):
    with pytest.raises(ParameterError, match=rf"\[0, 7\), got {joint}"):
        kk.world_pose(random_motion(1, joints=7), [0, joint])


@given(motions(joints=7, frames=6))
def test_local_from_world_undoes_world_pose(motion: Motion):
    pose = kk.world_pose(motion)
    translations, rotations = kk.local_from_world(motion.skeleton, pose.positions, pose.rotations)
    assert_motion_close(
        replace(motion, translations=translations, rotations=rotations), motion, degrees=1e-12, metres=1e-13
    )


def test_one_joint_has_no_parents():
    motion = random_motion(3, joints=1)
    pose = kk.world_pose(motion)
    np.testing.assert_array_equal(pose.positions, motion.translations)
    translations, rotations = kk.local_from_world(motion.skeleton, pose.positions, pose.rotations)
    np.testing.assert_array_equal(translations, motion.translations)
    np.testing.assert_array_equal(rotations, pose.rotations)


@given(motions(joints=6, frames=5), SEEDS)
def test_other_joint_axes_show_the_same_body(motion: Motion, seed: int):
    motion = with_tips(motion)
    axes = quat_normalize(np.random.default_rng(seed).normal(size=(6, 4)))
    told = kk.with_joint_axes(motion, axes)
    check_motion(told)
    before, after = kk.world_pose(motion), kk.world_pose(told)
    np.testing.assert_allclose(after.positions, before.positions, rtol=0, atol=1e-13)
    rest, rest_axes = kk.rest_pose(told.skeleton)
    assert quat_distance(rest_axes, axes).max() < 1e-13
    np.testing.assert_allclose(rest, kk.rest_pose(motion.skeleton)[0], rtol=0, atol=1e-13)
    tip = [
        pose.positions[:, -1] + quat_rotate(pose.rotations[:, -1], m.skeleton.tips[-1])
        for pose, m in ((before, motion), (after, told))
    ]
    np.testing.assert_allclose(tip[1], tip[0], rtol=0, atol=1e-13)
    again = kk.with_joint_axes(told, kk.rest_pose(motion.skeleton)[1])
    assert_motion_close(again, motion, degrees=1e-11, metres=1e-13)


def test_identity_axes_make_rest_rotations_vanish():
    told = kk.with_joint_axes(random_motion(5, joints=8), quat_identity())
    assert quat_distance(told.skeleton.rest, quat_identity((8,))).max() < 1e-14


def limb(seed: int, bend: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    hip = rng.normal(size=(20, 3))
    upper, lower = rng.uniform(0.2, 0.6, (2, 20, 1))
    way = quat_rotate(quat_normalize(rng.normal(size=(20, 4))), [1.0, 0, 0])
    turn = way if bend == "straight" else quat_rotate(quat_normalize(rng.normal(size=(20, 4))), [1.0, 0, 0])
    knee = hip + upper * way
    return hip, knee, knee + lower * turn


@pytest.mark.parametrize("bend", ["any", "straight"])
@given(seed=SEEDS)
def test_two_bone_ik_reaches_its_target_and_keeps_the_bones(bend: str, seed: int):
    hip, knee, ankle = limb(seed, bend)
    rng = np.random.default_rng(seed + 1)
    upper, lower = np.linalg.norm(knee - hip, axis=-1), np.linalg.norm(ankle - knee, axis=-1)
    reach = np.abs(upper - lower) + (2 * np.minimum(upper, lower)) * rng.uniform(0.05, 0.999, 20)
    target = hip + quat_rotate(quat_normalize(rng.normal(size=(20, 4))), [1.0, 0, 0]) * reach[:, None]
    thigh, shin = kk.two_bone_ik(hip, knee, ankle, target)
    new_knee = hip + quat_rotate(thigh, knee - hip)
    new_ankle = new_knee + quat_rotate(shin, ankle - knee)
    np.testing.assert_allclose(np.linalg.norm(new_knee - hip, axis=-1), upper, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(new_ankle - new_knee, axis=-1), lower, rtol=1e-12)
    np.testing.assert_allclose(new_ankle, target, rtol=0, atol=2e-7)


@given(SEEDS)
def test_two_bone_ik_leaves_a_limb_that_is_there_already(seed: int):
    hip, knee, ankle = limb(seed, "any")
    size = np.linalg.norm(ankle - hip, axis=-1)
    upper, lower = np.linalg.norm(knee - hip, axis=-1), np.linalg.norm(ankle - knee, axis=-1)
    free = (size > np.abs(upper - lower) * 1.01 + 1e-3) & (size < (upper + lower) * 0.999)
    thigh, shin = kk.two_bone_ik(hip, knee, ankle, ankle)
    one = quat_identity(free.shape)
    assert quat_distance(thigh, one)[free].max(initial=0) < 1e-6
    assert quat_distance(shin, one)[free].max(initial=0) < 1e-6


def test_two_bone_ik_out_of_reach():
    hip, knee, ankle = np.zeros(3), np.array([0.1, -0.4, 0.0]), np.array([0.0, -0.8, 0.05])
    full = np.linalg.norm(knee) + np.linalg.norm(ankle - knee)
    for target in ([0.0, -5.0, 0.0], [3.0, 4.0, 0.0]):
        thigh, shin = kk.two_bone_ik(hip, knee, ankle, target)
        end = quat_rotate(thigh, knee) + quat_rotate(shin, ankle - knee)
        np.testing.assert_allclose(end, 0.9999 * full * np.array(target) / 5.0, atol=1e-7)
    thigh, shin = kk.two_bone_ik(hip, knee, ankle, hip)
    assert np.isfinite(thigh).all()
    end = quat_rotate(thigh, knee) + quat_rotate(shin, ankle - knee)
    assert np.linalg.norm(end) < abs(np.linalg.norm(knee) - np.linalg.norm(ankle - knee)) * 1.001 + 1e-6


def test_a_straight_leg_bends_its_knee_about_the_sideways_axis():
    hip, knee, ankle = np.zeros(3), np.array([0.0, -0.4, 0.0]), np.array([0.0, -0.8, 0.0])
    thigh, shin = kk.two_bone_ik(hip, knee, ankle, [0.0, -0.6, 0.0])
    for turn in (thigh, shin):
        np.testing.assert_allclose(turn[1:3], 0, atol=1e-12)


@given(motions(joints=5, frames=4), st.floats(-10, 10), SEEDS)
def test_turning_about_up_turns_every_world_position(motion: Motion, yaw: float, seed: int):
    shift = np.random.default_rng(seed).normal(size=3)
    before = kk.world_pose(motion).positions.copy()
    turned = Rotation.from_rotvec([0, yaw, 0]).apply(before.reshape(-1, 3)).reshape(before.shape) + shift
    after = kk.world_pose(kk.turn_about_up(motion, yaw, shift)).positions
    np.testing.assert_allclose(after, turned, rtol=0, atol=1e-13)


@pytest.mark.parametrize("yaw", [0.0, 0.5, -2.0, 3.0])
def test_heading_of_a_turned_rest_pose(yaw: float):
    offsets = np.array([[0, 1.0, 0], [0.1, 0, 0], [-0.1, 0, 0]])
    rest = quat_identity((3,))
    rest[0] = Rotation.from_rotvec([0, yaw, 0]).as_quat()
    rig = Skeleton(("Hips", "LeftLeg", "RightLeg"), (-1, 0, 0), offsets, rest)
    assert kk.heading(rig) == pytest.approx(yaw)
    assert kk.heading(Skeleton(("a",), (-1,), [[0, 0, 0]])) == 0.0
