"""Where the body goes: placed by one yaw and one ground shift, its path joined, whichever joint carries the travel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from solve_oracles import cast, line

from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    quat_about_axis,
    quat_conjugate,
    quat_distance,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    rotvec_to_quat,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import Seam
from kinestitch.rig.carrier import carrier_joint
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.root import Placement, displacement_residuals, seam_yaw
from kinestitch.solve.seam import seam_reach
from kinestitch.solve.stitch import solve_timeline, stitch
from kinestitch.testing import quaternions, random_motion

SEEDS = st.integers(0, 2**32 - 1)
LEGS = Skeleton(("Hips", "LeftLeg", "RightLeg"), (-1, 0, 0), [[0, 1, 0], [0.1, -0.1, 0], [-0.1, -0.1, 0]])
HALF_TURN = np.deg2rad(-90.0)


@given(st.floats(-7, 7), st.floats(-5, 5), st.floats(-5, 5), SEEDS)
def test_placement_turns_then_shifts(yaw: float, x: float, z: float, seed: int):
    points = np.random.default_rng(seed).normal(size=(4, 3))
    placement = Placement(yaw, x, z)
    expected = Rotation.from_rotvec([0, yaw, 0]).apply(points) + np.array([x, 0, z])
    np.testing.assert_allclose(placement.move(points), expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(quat_rotate(placement.rotation, points), placement.rotate(points), rtol=0, atol=1e-14)


@given(quaternions(), quaternions(), st.floats(-3.1, 3.1))
def test_yaw_of_poses_that_are_a_yaw_apart(first: np.ndarray, second: np.ndarray, yaw: float):
    right = np.stack([first, quat_multiply(first, rotvec_to_quat(0.1 * second[:3]))])
    left = quat_multiply(quat_about_axis(1, yaw), right)
    for signs in ([1, 1], [-1, 1], [1, -1]):
        found = seam_yaw(LEGS, left * np.array(signs)[:, None], right)
        assert np.abs(np.angle(np.exp(1j * (found - yaw)))) < 1e-9


@given(SEEDS)
def test_yaw_is_the_one_that_brings_the_poses_nearest(seed: int):
    rng = np.random.default_rng(seed)
    right = quat_normalize(rng.normal(size=(2, 4)) * [0.3, 1, 0.3, 1])
    right[1] = quat_multiply(right[0], rotvec_to_quat(rng.normal(size=3) * 0.05))
    lean = rotvec_to_quat(rng.normal(size=3) * [0.6, 2.0, 0.6])
    left = quat_multiply(lean, right)
    found = seam_yaw(LEGS, left, right)
    here = quat_distance(left, quat_multiply(quat_about_axis(1, found), right)).sum()
    for nearby in (found - 0.02, found + 0.02, found + np.pi):
        assert quat_distance(left, quat_multiply(quat_about_axis(1, nearby), right)).sum() > here


@given(SEEDS, st.floats(-3, 3))
def test_bodies_upside_down_to_each_other_align_their_hip_lines(seed: int, yaw: float):
    rng = np.random.default_rng(seed)
    upright = quat_multiply(quat_about_axis(1, float(rng.uniform(-3, 3))), rotvec_to_quat(rng.normal(size=3) * 0.1))
    axis = quat_rotate(quat_about_axis(1, float(rng.uniform(-3, 3))), [1.0, 0.0, 0.0])
    left = np.stack([upright, upright])
    right = quat_multiply(rotvec_to_quat(axis * np.pi), left)
    relative = quat_multiply(left, quat_conjugate(right))[0]
    assert np.hypot(relative[1], relative[3]) < 0.1
    right = quat_multiply(quat_about_axis(1, yaw), right)
    placed = quat_multiply(quat_about_axis(1, seam_yaw(LEGS, left, right)), right)
    lines = [quat_rotate(side[0], [1.0, 0.0, 0.0]) for side in (left, placed)]
    headings = [np.arctan2(-side[2], side[0]) for side in lines]
    assert np.abs(np.angle(np.exp(1j * (headings[0] - headings[1])))) < 1e-9


def test_without_legs_a_body_upside_down_is_left_as_it_stands():
    rig = Skeleton(("a",), (-1,), [[0, 0, 0]])
    left = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1))
    assert seam_yaw(rig, left, np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))) == 0.0


def test_an_upside_down_clip_is_stitched_without_harm():
    rig = Skeleton(
        ("Hips", "LeftLeg", "RightLeg", "Spine"), (-1, 0, 0, 0), [[0, 1, 0], [0.1, -0.1, 0], [-0.1, -0.1, 0], [0, 1, 0]]
    )
    clips = {key: replace(random_motion(4 + i, bend=0.2), skeleton=rig) for i, key in enumerate("ab")}
    over = quat_multiply(quat_about_axis(0, np.pi), clips["b"].rotations[:, 0])
    rotations = clips["b"].rotations.copy()
    rotations[:, 0] = over
    clips["b"] = replace(clips["b"], rotations=rotations)
    out = stitch(line([("a", 0, 20), ("b", 5, 40)], clips, Seam(stiffness=81.0)), clips)
    assert quat_distance(out.rotations[1:], out.rotations[:-1]).max() < 0.6


def test_the_shift_joins_the_means_of_both_frames():
    clips = cast(2)
    placed = place_timeline(line([("a", 0, 20), ("b", 5, 30)], clips), clips)
    left = clips["a"].translations[19:21, 0].mean(axis=0)
    right = placed.placements[1].move(clips["b"].translations[4:6, 0].mean(axis=0))
    np.testing.assert_allclose(right[[0, 2]], left[[0, 2]], rtol=0, atol=1e-14)


def test_placements_pass_from_segment_to_segment():
    clips = cast(1)
    clips["b"] = turn_about_up(clips["a"], 2.0, (3.0, 0.0, 1.0))
    parts = line([("a", 0, 10), ("b", 10, 20), ("b", 20, 25), ("a", 25, 40)], clips)
    placements = place_timeline(parts, clips).placements
    assert [np.cos(p.yaw) for p in placements] == pytest.approx([1, np.cos(-2.0), np.cos(-2.0), 1])
    assert placements[1] == placements[2]
    assert (placements[3].x, placements[3].z) == pytest.approx((0, 0), abs=1e-12)


@given(SEEDS)
def test_two_sources_on_one_straight_path_leave_nothing_to_solve(seed: int):
    rng = np.random.default_rng(seed)
    step = rng.normal(size=3)
    path = np.arange(4)[:, None] * step
    np.testing.assert_allclose(displacement_residuals(path, path + rng.normal(size=3)), 0, atol=1e-15)


@pytest.mark.parametrize("stiffness", [1.0, 81.0])
def test_the_path_is_rigid_away_from_the_seams_and_has_no_step_at_them(stiffness: float):
    clips = cast(2, frames=400)
    solved = solve_timeline(line([("a", 0, 200), ("b", 120, 400)], clips, Seam(stiffness=stiffness)), clips)
    path, cut = (m.translations[:, 0][:, [0, 2]] for m in (solved.motion, solved.cut))
    reach = seam_reach(stiffness)
    np.testing.assert_allclose(path[: 200 - reach], cut[: 200 - reach], rtol=0, atol=1e-12)
    np.testing.assert_allclose(path[200 + reach :], cut[200 + reach :], rtol=0, atol=1e-12)
    spent = int(20 * stiffness**0.25)
    np.testing.assert_allclose(path[: 200 - spent], cut[: 200 - spent], rtol=0, atol=1e-4)
    steps, before = np.diff(path, axis=0), np.diff(cut, axis=0)
    gap = np.linalg.norm(before[200] - before[198])
    bends = np.linalg.norm(np.diff(steps, axis=0), axis=1)[190:210]
    own = max(np.linalg.norm(np.diff(m.translations[:, 0], axis=0, n=2), axis=1).max() for m in clips.values())
    assert gap > 5 * own
    assert bends.max() < own + gap / (2 * np.sqrt(2) * stiffness**0.25) * 1.02


# ---- which joint carries the travel -------------------------------------------------------------


def human(seed: int) -> Motion:
    return random_human(seed, 60)


def random_human(seed: int, frames: int) -> Motion:
    """A body whose hips are its root and wander about the ground."""
    motion = random_motion(seed, frames=frames, bend=0.5)
    rig = motion.skeleton
    return replace(motion, skeleton=replace(rig, names=("Hips", "Spine", "LeftLeg", "RightLeg")))


def below(motion: Motion, turn: np.ndarray, place: np.ndarray, *, travels: bool) -> Motion:
    """The same world motion on a rig with a joint above the hips, which stands still or carries the ground travel."""
    rig = motion.skeleton
    above = np.zeros((motion.frames, 3)) + place
    if travels:
        above = above + motion.translations[:, 0] * [1, 0, 1]
    undo = quat_conjugate(turn)
    translations = np.concatenate([above[:, None], motion.translations], axis=1)
    translations[:, 1] = quat_rotate(undo, motion.translations[:, 0] - above)
    rotations = np.concatenate([np.tile(turn, (motion.frames, 1, 1)), motion.rotations], axis=1)
    rotations[:, 1] = quat_multiply(undo, motion.rotations[:, 0])
    offsets = np.vstack([np.zeros(3), quat_rotate(undo, [0.0, 1.0, 0.0]), rig.offsets[1:]])
    rest = np.vstack([turn, quat_multiply(undo, rig.rest[0]), rig.rest[1:]])
    taller = Skeleton(("Armature", *rig.names), (-1, *(p + 1 for p in rig.parents)), offsets, rest)
    return Motion(taller, translations, rotations, motion.fps, motion.name)


PARTS = [("a", 0, 30), ("b", 20, 50), ("a", 35, 60)]
STAND = np.zeros(3)
AXES = {"dummy": np.array([0.0, 0, 0, 1]), "armature": quat_about_axis(0, HALF_TURN)}


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize(("original", "reference"), [(False, False), (False, True), (True, False)])
def test_the_same_bodies_stitch_alike_whichever_joint_travels(axes: str, original: bool, reference: bool):
    bare = {"a": human(1), "b": human(2)}
    expected = world_pose(stitch(line(PARTS, bare, Seam(stiffness=81.0)), bare))
    place = STAND if original or reference else np.array([0.4, 0.0, -1.0])
    clips = {
        "a": below(bare["a"], AXES[axes], place, travels=original),
        "b": below(bare["b"], AXES[axes], place, travels=reference),
    }
    assert carrier_joint(clips["a"]) == (0 if original else 1)
    out = stitch(line(PARTS, clips, Seam(stiffness=81.0)), clips)
    pose = world_pose(out)
    np.testing.assert_allclose(pose.positions[:, 1:], expected.positions, rtol=0, atol=1e-9)
    assert quat_distance(pose.rotations[:, 1:], expected.rotations).max() < 1e-9
    if original:  # the travel stands where the original had it
        apart = (pose.positions[:, 0] - pose.positions[:, 1])[:, [0, 2]]
        assert np.ptp(apart, axis=0).max() < 1e-9
    else:
        np.testing.assert_allclose(out.translations[:, 0], place * np.ones((out.frames, 1)), rtol=0, atol=1e-12)


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("yaw", [0.0, 1.5, 3.1, -3.1])
def test_two_clips_whose_root_travels_move_like_bodies_without_one(axes: str, yaw: float):
    """Also where they look in opposite directions: root and hips both turn by almost π, the body does not."""
    bare = {"a": human(1), "b": turn_about_up(human(2), yaw)}
    expected = world_pose(stitch(line(PARTS, bare, Seam(stiffness=81.0)), bare))
    clips = {key: below(motion, AXES[axes], STAND, travels=True) for key, motion in bare.items()}
    pose = world_pose(stitch(line(PARTS, clips, Seam(stiffness=81.0)), clips))
    assert quat_distance(pose.rotations[:, 1:], expected.rotations).max() < 1e-9
    np.testing.assert_allclose(pose.positions[:, 1:], expected.positions, rtol=0, atol=1e-9)


def test_clips_whose_root_travels_keep_their_numbers_away_from_the_seam():
    clips = {key: below(random_human(i, 200), AXES["armature"], STAND, travels=True) for i, key in enumerate("ab")}
    out = stitch(line([("a", 0, 100), ("b", 50, 200)], clips, Seam(stiffness=1.0)), clips)
    np.testing.assert_array_equal(out.translations[:52], clips["a"].translations[:52])
    np.testing.assert_array_equal(out.rotations[:52], clips["a"].rotations[:52])
    np.testing.assert_array_equal(out.rotations[148:, 1:], clips["b"].rotations[98:, 1:])


def test_a_dummy_that_stands_elsewhere_in_the_pasted_clip_does_not_matter():
    bare = {"a": human(1), "b": human(2)}
    expected = world_pose(stitch(line(PARTS, bare), bare)).positions
    clips = {
        "a": below(bare["a"], AXES["armature"], STAND, travels=False),
        "b": below(bare["b"], AXES["dummy"], np.array([2.0, 0.3, 1.0]), travels=False),
    }
    clips["b"] = replace(clips["b"], skeleton=clips["a"].skeleton)
    pose = world_pose(stitch(line(PARTS, clips), clips)).positions
    np.testing.assert_allclose(pose[:, 1:], expected, rtol=0, atol=1e-9)


def test_in_place_clips_are_carried_by_the_hips():
    still = human(1)
    still = replace(
        still,
        translations=np.broadcast_to(still.translations[:1], still.translations.shape),
        rotations=np.broadcast_to(still.rotations[:1], still.rotations.shape),
    )
    assert carrier_joint(below(still, AXES["dummy"], STAND, travels=False)) == 1
    clips = {
        "a": below(still, AXES["dummy"], STAND, travels=False),
        "b": below(human(2), AXES["dummy"], STAND, travels=False),
    }
    out = stitch(line(PARTS, clips), clips)
    assert not np.ptp(out.translations[:, 0], axis=0).any()
