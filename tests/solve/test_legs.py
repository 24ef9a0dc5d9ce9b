"""Legs bent to targets: what they can reach, what the hips have to do, and which way a knee points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_conjugate, quat_multiply, quat_rotate, quat_to_rotvec, rotvec_to_quat
from kinestitch.samples import sample
from kinestitch.solve.contacts import legs_of
from kinestitch.solve.legs import (
    LegPose,
    ankle_moved,
    bent_leg,
    knee_hinge,
    leg_pose,
    lowered,
    missing_height,
    pivot_of,
    slightly_bent,
    sound_leg,
    stretched,
    within_reach,
)

CLIPS = {name: sample(name) for name in ("walk", "kick", "idle")}


def standing(stretch: float = 0.0) -> LegPose:
    hip, knee, ankle = np.array([[0, 1.0, 0]]), np.array([[0, 0.55, 0.1]]), np.array([[0, 0.15, 0.0]])
    return LegPose(hip, knee, ankle, np.array([stretch]))


def test_what_is_in_reach_stays_and_what_is_not_is_approached():
    leg = standing()
    near = np.array([[0.1, 0.3, 0.1]])
    assert np.allclose(within_reach(leg, near), near)
    reached = [
        float(np.linalg.norm(within_reach(leg, np.array([[0.0, 1.0 - far, 0.0]])) - leg.hip)) for far in (0.9, 1.0, 2.0)
    ]
    assert reached == sorted(reached)
    assert reached[-1] <= 0.998 * leg.length[0]


@pytest.mark.parametrize("far", [0.9, 1.0, 1.3])
def test_a_leg_may_be_as_straight_as_in_its_source(far: float):
    leg = standing(stretch=0.999 * standing().length[0])
    found = np.linalg.norm(within_reach(leg, np.array([[0.0, 1.0 - far, 0.0]])) - leg.hip)
    assert found == pytest.approx(min(far, 0.999 * leg.length[0]))


@settings(max_examples=60, deadline=None)
@given(st.floats(-0.5, 0.5), st.floats(0.0, 0.6), st.floats(-0.5, 0.5))
def test_hips_that_come_down_by_what_is_missing_bring_a_foot_into_reach(x: float, y: float, z: float):
    leg, target = standing(), np.array([[x, y, z]])
    down = missing_height(leg, target, np.array([True]))
    assert down[0] <= 0
    assert missing_height(leg, target, np.array([False]))[0] == 0
    moved = LegPose(leg.hip + np.array([0, down[0], 0]), leg.knee, leg.ankle, leg.stretch)
    limit = max(0.97 * leg.length[0], leg.own[0])
    if np.hypot(x, z) < limit and moved.hip[0, 1] > y:
        assert np.linalg.norm(target - moved.hip) <= limit + 1e-9


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 120), st.sampled_from([30.0, 60.0]), st.integers(0, 2**32 - 1))
def test_hips_come_down_far_enough_and_softly(count: int, fps: float, seed: int):
    rng = np.random.default_rng(seed)
    missing = np.where(rng.random(count) < 0.1, -0.04 * rng.random(count), 0.0)
    path = lowered(missing, fps, 0.9)
    assert (path <= missing + 1e-12).all()
    assert path.min() >= missing.min() - 1e-12
    assert np.abs(np.diff(path, n=2)).max(initial=0.0) * fps**2 < 2.0
    assert lowered(np.full(count, -1.0), fps, 0.9) == pytest.approx(-0.06 * 0.9)


def bent(motion: Motion, side: int, offsets: np.ndarray) -> tuple[Motion, Motion]:
    leg = legs_of(motion.skeleton)[side]
    pose = world_pose(motion)
    local = bent_leg(pose, motion.rotations, leg, offsets, stretched(pose, leg), motion.skeleton.parents)
    rotations = motion.rotations.copy()
    for joint, values in local.items():
        rotations[:, joint] = values
    return motion, Motion(motion.skeleton, motion.translations, rotations, motion.fps)


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from(sorted(CLIPS)),
    st.integers(0, 1),
    st.lists(st.floats(-0.08, 0.08), min_size=3, max_size=3),
    st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6),
)
def test_a_foot_goes_where_it_is_moved_and_turned(name: str, side: int, moved: list[float], turned: list[float]):
    motion = CLIPS[name]
    leg = legs_of(motion.skeleton)[side]
    offsets = np.tile([*moved, *turned], (motion.frames, 1))
    before, after = (world_pose(one) for one in bent(motion, side, offsets))
    pose = leg_pose(before, leg, stretched(before, leg))
    there = ankle_moved(before, leg, offsets)
    near = np.linalg.norm(there - pose.hip, axis=1) <= np.maximum(0.97 * pose.length, pose.own)
    assume(near.any())
    assert np.abs(after.positions[near, leg.foot] - there[near]).max() < 1e-7
    aim = before.positions[near, pivot_of(leg)] + moved
    assert np.abs(after.positions[near, pivot_of(leg)] - aim).max() < 1e-7
    turn = quat_multiply(after.rotations[near, leg.foot], quat_conjugate(before.rotations[near, leg.foot]))
    assert np.abs(quat_to_rotvec(turn) - turned[:3]).max() < 1e-7
    assert np.allclose(after.positions[:, leg.thigh], before.positions[:, leg.thigh])


@settings(max_examples=20, deadline=None)
@given(st.sampled_from(sorted(CLIPS)), st.lists(st.floats(-0.15, 0.15), min_size=3, max_size=3))
def test_bones_keep_their_length_and_knees_their_direction(name: str, moved: list[float]):
    motion = CLIPS[name]
    leg = legs_of(motion.skeleton)[0]
    before, after = (world_pose(one) for one in bent(motion, 0, np.tile([*moved, *[0.0] * 6], (motion.frames, 1))))
    fronts = []
    for pose in (before, after):
        hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
        fronts.append(quat_rotate(quat_conjugate(pose.rotations[:, leg.thigh]), np.cross(knee - hip, ankle - knee)))
        if pose is after:
            lengths = [np.linalg.norm(b - a, axis=1) for a, b in ((hip, knee), (knee, ankle))]
    offsets = motion.skeleton.offsets
    for length, joint in zip(lengths, (leg.shin, leg.foot), strict=True):
        assert np.allclose(length, np.linalg.norm(offsets[joint]), atol=1e-9)
    front = fronts[0].sum(axis=0)
    assert (fronts[1] @ front > 0).all()


def test_nothing_asked_changes_nothing():
    motion = CLIPS["walk"]
    _, after = bent(motion, 1, np.zeros((motion.frames, 9)))
    assert np.abs(after.rotations - motion.rotations).max() < 1e-9


@settings(max_examples=40, deadline=None)
@given(st.floats(-0.3, 1.0), st.floats(0.0, 1.0))
def test_straight_knees_are_bent_forward_and_bent_ones_left(bend: float, share: float):
    """A knee overstretched by `bend` < 0 comes to lie on the right side; well bent ones change by nothing to see."""
    upper, hinge = np.array([[0.0, -0.45, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    lower = np.array([[0.0, -0.4 * np.cos(bend), -0.4 * np.sin(bend)]])
    first, second = slightly_bent(upper, lower, hinge, np.array([share]))
    u, v = quat_rotate(first, upper), quat_rotate(second, lower)
    now = float(np.arctan2((np.cross(u, v) @ hinge[0])[0], (u * v).sum()))
    assert now >= bend - 1e-12
    if share == 1.0:
        assert now > np.radians(7.9)
    if bend > np.radians(25):
        assert now - bend < np.radians(0.01)


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(sorted(CLIPS)), st.integers(0, 1), st.floats(-1.2, 0.0))
def test_no_knee_that_was_turned_stays_bent_backwards(name: str, side: int, straightened: float):
    """A shin turned too far forward comes to lie on the right side, its ankle where it was; a leg is not lengthened."""
    motion = CLIPS[name]
    leg, before = legs_of(motion.skeleton)[side], world_pose(motion)
    upper, lower = (
        before.positions[:, a] - before.positions[:, b] for a, b in ((leg.shin, leg.thigh), (leg.foot, leg.shin))
    )
    hinge = quat_rotate(quat_conjugate(before.rotations[:, leg.thigh]), np.cross(upper, lower)).sum(axis=0)
    hinge /= np.linalg.norm(hinge)
    rotations = motion.rotations.copy()
    rotations[:, leg.shin] = quat_multiply(rotvec_to_quat(hinge * straightened), rotations[:, leg.shin])
    pose = world_pose(replace(motion, rotations=rotations))
    moved = np.linalg.norm(pose.positions[:, leg.foot] - before.positions[:, leg.foot], axis=1)
    limit = leg_pose(before, leg, stretched(before, leg)).longest
    local = sound_leg(pose, rotations, leg, moved, limit, knee_hinge(before, leg), motion.skeleton.parents)
    for joint, values in local.items():
        rotations[:, joint] = values
    after = world_pose(replace(motion, rotations=rotations))
    ways = [after.positions[:, a] - after.positions[:, b] for a, b in ((leg.shin, leg.thigh), (leg.foot, leg.shin))]
    found = quat_rotate(quat_conjugate(after.rotations[:, leg.thigh]), np.cross(*ways)) @ hinge
    assert found[moved > 0.1].min(initial=0.0) > -1e-4
    reach = np.linalg.norm(after.positions[:, leg.foot] - after.positions[:, leg.thigh], axis=1)
    assert (reach <= limit + 1e-9).all()
    near = np.linalg.norm(pose.positions[:, leg.foot] - pose.positions[:, leg.thigh], axis=1) < limit
    assert np.abs(after.positions[near, leg.foot] - pose.positions[near, leg.foot]).max(initial=0.0) < 1e-4
