"""Two clips of one rig under other names, in another order, of another size, in other axes; all else is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.core.kinematics import with_joint_axes, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_identity, quat_normalize
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import SkeletonMismatchError
from kinestitch.rig.hips import hip_height
from kinestitch.rig.match import match_motion
from kinestitch.testing import assert_motion_close, check_motion, random_motion

NAMES = ("Hips", "Spine", "LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg", "RightFoot")
PARENTS = (-1, 0, 0, 2, 3, 0, 5, 6)
OFFSETS = np.array(
    [
        [0, 1.0, 0],
        [0.0, 0.3, 0.02],
        [0.1, -0.05, 0],
        [0.0, -0.42, 0.01],
        [0, -0.4, -0.01],
        [-0.1, -0.05, 0],
        [0, -0.42, 0.01],
        [0, -0.4, -0.01],
    ]
)


def body(prefix: str = "", *, scale: float = 1.0, order: tuple[int, ...] | None = None) -> Skeleton:
    order = order or tuple(range(8))
    return Skeleton(
        tuple(prefix + NAMES[j] for j in order),
        tuple(-1 if PARENTS[j] < 0 else order.index(PARENTS[j]) for j in order),
        OFFSETS[list(order)] * scale,
    )


def moving(skeleton: Skeleton, seed: int = 1) -> Motion:
    source = random_motion(seed, joints=8, frames=12)
    translations = np.broadcast_to(skeleton.offsets, (12, 8, 3)).copy()
    translations[:, 0] += source.translations[:, 0]
    translations[:, 1] += 0.01 * np.sin(np.arange(12))[:, None]
    return replace(source, skeleton=skeleton, translations=translations)


def test_the_same_skeleton_is_the_same_motion():
    motion = moving(body())
    assert match_motion(motion, motion.skeleton) is motion
    assert match_motion(motion, body()).rotations is motion.rotations


@pytest.mark.parametrize("there", ["", "mixamorig:", "mixamorig8:", "mixamorig_", "Guard:"])
@pytest.mark.parametrize("here", ["", "mixamorig:", "mixamorig12:"])
def test_prefixes_do_not_count(here: str, there: str):
    motion = moving(body(here))
    matched = match_motion(motion, body(there))
    assert matched.skeleton == body(there)
    np.testing.assert_array_equal(matched.rotations, motion.rotations)
    np.testing.assert_array_equal(matched.translations, motion.translations)


@pytest.mark.parametrize("order", [(0, 5, 6, 7, 2, 3, 4, 1), (0, 2, 5, 1, 6, 3, 4, 7)])
def test_the_order_of_joints_does_not_count(order: tuple[int, ...]):
    motion = moving(body("mixamorig:", order=order))
    matched = match_motion(motion, body())
    check_motion(matched)
    assert matched.skeleton == body()
    there, here = world_pose(motion).positions, world_pose(matched).positions
    np.testing.assert_allclose(here[:, list(order)], there, rtol=0, atol=1e-14)


@pytest.mark.parametrize("scale", [0.5, 0.9, 1.3, 100.0])
def test_longer_bones_keep_rotations_and_scale_the_travel(scale: float):
    motion = moving(body())
    big = body(scale=scale)
    matched = match_motion(motion, big)
    np.testing.assert_array_equal(matched.rotations, motion.rotations)
    np.testing.assert_allclose(matched.translations, motion.translations * scale, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(
        world_pose(matched).positions, world_pose(motion).positions * scale, rtol=0, atol=1e-11 * scale
    )


def test_longer_legs_take_longer_steps_and_leave_the_spine():
    legs = OFFSETS.copy()
    legs[[3, 4, 6, 7]] *= 1.2
    tall = Skeleton(NAMES, PARENTS, legs)
    motion = moving(body())
    matched = match_motion(motion, tall)
    ratio = hip_height(tall) / hip_height(body())
    assert ratio == pytest.approx(1.2)
    np.testing.assert_allclose(matched.translations[:, 0], motion.translations[:, 0] * ratio)
    np.testing.assert_allclose(matched.translations[:, 2:], np.broadcast_to(legs[2:], (12, 6, 3)), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(matched.rotations, motion.rotations)


@given(st.integers(0, 2**32 - 1))
def test_other_joint_axes_of_the_same_pose(seed: int):
    motion = moving(body(), seed % 1000)
    axes = quat_normalize(np.random.default_rng(seed).normal(size=(8, 4)))
    told = with_joint_axes(motion, axes)
    matched = match_motion(told, body("mixamorig:"))
    np.testing.assert_allclose(world_pose(matched).positions, world_pose(motion).positions, rtol=0, atol=1e-12)
    assert_motion_close(replace(matched, skeleton=motion.skeleton), motion, degrees=1e-11, metres=1e-12)


def other(**changes: object) -> Skeleton:
    parts = {"names": NAMES, "parents": PARENTS, "offsets": OFFSETS} | changes
    return Skeleton(**parts)  # type: ignore[arg-type]


RENAMED = ("Hips", "Spine", "LeftUpLeg", "LeftLeg", "L_Foot", *NAMES[5:])
SHUFFLED = (0, 5, 6, 7, 2, 3, 4, 1)


@pytest.mark.parametrize(
    ("skeleton", "words"),
    [
        (other(names=RENAMED), r"Skeletons differ at joint 4: 'L_Foot' and 'LeftFoot' \(8 and 8 joints\)"),
        (other(names=("root", *NAMES[1:])), "joint 0: 'root' and 'Hips'"),
        (
            other(names=(*NAMES, "Tail"), parents=(*PARENTS, 0), offsets=np.vstack([OFFSETS, OFFSETS[:1]])),
            r"joint 8: 'Tail' and nothing \(9 and 8 joints\)",
        ),
        (other(names=NAMES[:7], parents=PARENTS[:7], offsets=OFFSETS[:7]), "joint 7: nothing and 'RightFoot'"),
        (other(parents=(-1, 0, 1, 2, 3, 0, 5, 6)), "joint 2: 'LeftUpLeg' hangs on 'Spine' and on 'Hips'"),
    ],
)
def test_what_differs_is_named(skeleton: Skeleton, words: str):
    with pytest.raises(SkeletonMismatchError, match=words) as error:
        match_motion(moving(body()), skeleton)
    assert "\n" not in str(error.value)
    assert "etarget first" in str(error.value)


def test_a_difference_of_order_is_not_named():
    lacking = body(order=SHUFFLED)
    renamed = Skeleton(tuple("Chest" if n == "Spine" else n for n in lacking.names), lacking.parents, lacking.offsets)
    with pytest.raises(SkeletonMismatchError, match="Skeletons differ at joint 1: 'Spine'"):
        match_motion(moving(renamed), body())


def test_names_that_are_told_apart_by_their_prefix_only():
    twice = ("a:Hips", "b:Hips", *NAMES[2:])
    with pytest.raises(SkeletonMismatchError, match="differ at joint"):
        match_motion(moving(other(names=twice)), body())
    with pytest.raises(SkeletonMismatchError, match="differ at joint 0"):
        match_motion(moving(other(names=twice)), other(names=("Hips", "c:Hips", *NAMES[2:])))


def test_another_rest_pose_in_other_axes_is_refused():
    motion = moving(body())
    spread = OFFSETS.copy()
    spread[2:5] = spread[2:5] @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    turned = np.tile(quat_about_axis(2, np.pi / 2), (8, 1))
    told = with_joint_axes(replace(motion, skeleton=other(offsets=spread)), turned)
    with pytest.raises(SkeletonMismatchError, match=r"Rest poses differ at joint 2: 'LeftUpLeg'.*Retarget first"):
        match_motion(told, body())


def test_where_the_rest_pose_stands_does_not_count():
    motion = moving(body())
    elsewhere = OFFSETS.copy()
    elsewhere[0] = [50.0, -3.0, 7.0]
    matched = match_motion(motion, other(offsets=elsewhere, rest=quat_identity((8,))))
    np.testing.assert_array_equal(matched.translations, motion.translations)
    np.testing.assert_array_equal(matched.rotations, motion.rotations)


def test_real_clips_under_another_prefix(real_clip: Callable[[str], Motion]):
    theirs = real_clip("mixamo_prefix8/walking.fbx")
    ours = real_clip("mixamo_xbot_30fps/Idle.fbx")
    matched = match_motion(theirs, ours.skeleton)
    check_motion(matched)
    assert matched.skeleton == ours.skeleton
    ratio = hip_height(ours.skeleton) / hip_height(theirs.skeleton)
    travel = [np.linalg.norm(m.translations[-1, 0] - m.translations[0, 0]) for m in (theirs, matched)]
    assert travel[1] == pytest.approx(ratio * travel[0], rel=1e-9)
    lowest = world_pose(matched).positions[:, :, 1].min(axis=1)
    assert -0.05 < lowest.min() < lowest.max() < 0.12


def test_real_rigs_that_differ(real_clip: Callable[[str], Motion]):
    with pytest.raises(SkeletonMismatchError, match=r"joint 0: 'mixamorig:Hips' and '.*' \(65 and 22 joints\)"):
        match_motion(
            real_clip("bandai/dataset-1_walk_normal_001.bvh"), real_clip("mixamo_xbot_30fps/Idle.fbx").skeleton
        )


def test_hips_below_a_root_go_where_their_own_size_takes_them():
    """Their place is not a bone: a rig may put the height of the hips into the rest pose or into the motion."""
    names, parents = ("Reference", *NAMES), (-1, *(parent + 1 for parent in PARENTS))
    small = Skeleton(names, parents, np.vstack([np.zeros((1, 3)), OFFSETS]))
    offsets = np.vstack([np.zeros((1, 3)), OFFSETS * 1.5])
    offsets[1] = 0.0
    tall = Skeleton(names, parents, offsets)
    source = moving(body())
    translations = np.concatenate([np.zeros((12, 1, 3)), source.translations], axis=1)
    rotations = np.concatenate([np.broadcast_to(quat_identity(), (12, 1, 4)), source.rotations], axis=1)
    matched = match_motion(Motion(small, translations, rotations, source.fps), tall)
    ratio = hip_height(tall) / hip_height(small)
    assert ratio == pytest.approx(1.5)
    np.testing.assert_allclose(matched.translations[:, 1], translations[:, 1] * 1.5)
