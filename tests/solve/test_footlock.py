"""Feet locked after the solve: what stays, what must not happen, and what comes out on real clips."""

from __future__ import annotations

import os
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch import files
from kinestitch.analysis.skating import skating_report, slide_in_contact
from kinestitch.analysis.smoothness import added_acceleration
from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_conjugate, quat_distance, quat_multiply, quat_rotate, rotvec_to_quat
from kinestitch.edit.operations import append
from kinestitch.edit.operations import replace as paste
from kinestitch.edit.pinning import come_back
from kinestitch.edit.timeline import Seam, timeline
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.rig.hips import hip_height, hips_joint
from kinestitch.samples import SAMPLE_NAMES, sample
from kinestitch.solve.contacts import Contacts, find_contacts, legs_of, runs
from kinestitch.solve.footlock import lock_feet, locked, placed_contacts
from kinestitch.solve.legs import stretched
from kinestitch.solve.planting import MOST
from kinestitch.solve.seam import clusters
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline
from kinestitch.testing import assert_motion_close, check_motion, random_motion

SEAM = Seam(smoothing=0.1)


def joined(left: str, right: str, stop: int, start: int, *, fps: float = 60.0, turn: float = 0.0) -> Solved:
    """Two samples cut together; `turn` rad and a shift are given to the whole world."""
    clips = {name: turn_about_up(sample(name, fps=fps), turn, (turn, 0.0, -turn)) for name in (left, right)}
    line = paste(timeline(clips, left), stop, clips[left].frames, right, start, clips[right].frames)
    return solve_timeline(line, clips)


def walk_kick(**clips: Motion) -> Solved:
    own = clips or {"walk": sample("walk"), "kick": sample("kick")}
    return solve_timeline(paste(timeline(own, "walk"), 84, 130, "kick", 30, 112), own)


@st.composite
def cuts(draw: st.DrawFn) -> Solved:
    left, right = draw(st.sampled_from(SAMPLE_NAMES)), draw(st.sampled_from(SAMPLE_NAMES))
    stop = draw(st.integers(10, sample(left).frames - 2))
    return joined(
        left, right if right != left else "idle" if left != "idle" else "walk", stop, draw(st.integers(1, 40))
    )


def hinges(motion: Motion, leg) -> np.ndarray:
    """Where the knee points (F, 3), told in the thigh's axes, as long as the knee is bent."""
    pose = world_pose(motion)
    hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    return quat_rotate(quat_conjugate(pose.rotations[:, leg.thigh]), np.cross(knee - hip, ankle - knee))


def test_without_contacts_nothing_changes():
    solved = walk_kick()
    contacts = placed_contacts(solved.placed)
    none = Contacts(contacts.joints, np.zeros_like(contacts.held))
    assert lock_feet(solved, none) is solved.motion


def test_the_hard_cut_and_a_clip_without_seams_are_left_alone():
    clips = {"walk": sample("walk"), "kick": sample("kick")}
    line = append(timeline(clips, "walk"), "kick")
    cut = solve_timeline(line, clips, method="cut")
    assert lock_feet(cut) is cut.motion
    alone = solve_timeline(timeline(clips, "walk"), clips)
    assert np.array_equal(lock_feet(alone).rotations, alone.motion.rotations)


@settings(max_examples=25, deadline=None)
@given(cuts())
def test_whatever_is_cut(solved: Solved):
    after = locked(solved)
    check_motion(after.motion)
    skeleton = solved.motion.skeleton
    hips, legs = hips_joint(skeleton), legs_of(skeleton)
    lower = {joint for leg in legs for joint in (leg.thigh, leg.shin, leg.foot, leg.toe)}
    others = [j for j in range(skeleton.joint_count) if j not in lower]
    assert np.array_equal(after.motion.rotations[:, others], solved.motion.rotations[:, others])
    still = [j for j in range(skeleton.joint_count) if j != hips]
    assert np.array_equal(after.motion.translations[:, still], solved.motion.translations[:, still])
    pose, before = world_pose(after.motion).positions, world_pose(solved.motion).positions
    sunk = before[:, hips] - pose[:, hips]
    assert np.abs(sunk[:, [0, 2]]).max() < 1e-12
    assert sunk[:, 1].min() > -1e-12
    assert sunk[:, 1].max() < 0.06 * hip_height(skeleton) + 1e-9
    assert not (after.contacts.held & ~placed_contacts(solved.placed).held).any()
    for leg in legs:
        front = hinges(sample("walk"), leg).sum(axis=0)
        sound = hinges(solved.motion, leg) @ front > 0
        assert (hinges(after.motion, leg) @ front)[sound].min() > 0
        reach = np.linalg.norm(pose[:, leg.foot] - pose[:, leg.thigh], axis=-1)
        source = world_pose(solved.cut).positions
        was = [np.linalg.norm(p[:, leg.foot] - p[:, leg.thigh], axis=-1) for p in (before, source)]
        length = np.linalg.norm(skeleton.offsets[[leg.shin, leg.foot]], axis=-1).sum()
        over = (reach - np.maximum(np.max(was, axis=0), 0.998 * length)) / length
        assert over.max() < 1e-6, over.max()


@settings(max_examples=15, deadline=None)
@given(cuts())
def test_feet_that_stand_go_the_way_they_go_in_their_source(solved: Solved):
    """Ankle and toe move over the ground from frame to frame as far as in the clip, wherever the leg is long enough."""
    after = locked(solved)
    ours, theirs = world_pose(after.motion), world_pose(solved.cut)
    joined_over = round(0.6 * solved.motion.fps)  # stances of both sides of a seam are tested in test_stances
    for leg in legs_of(solved.motion.skeleton):
        length = np.linalg.norm(solved.motion.skeleton.offsets[[leg.shin, leg.foot]], axis=-1).sum()
        loose = stretched(ours, leg) < 0.969 * length
        for start, stop in runs(after.contacts.of(leg.foot, leg.toe)):
            if any(start - joined_over < seam.frame < stop + joined_over for seam in solved.seams):
                continue
            steps = loose[start + 1 : stop] & loose[start : stop - 1]
            for joint in (leg.foot, leg.toe):
                places = (pose.positions[start:stop, joint][:, [0, 2]] for pose in (ours, theirs))
                ways = [np.linalg.norm(np.diff(side, axis=0), axis=1)[steps] for side in places]
                assert np.abs(ways[0] - ways[1]).max(initial=0.0) < 1e-4


@pytest.mark.parametrize(("left", "right", "stop", "start"), [("walk", "kick", 84, 30), ("run", "jump", 60, 10)])
def test_planted_feet_do_not_move(left: str, right: str, stop: int, start: int):
    """Where a stance is not one of two made one, and the leg is long enough, its toes stay within a millimetre."""
    solved = joined(left, right, stop, start)
    after = locked(solved)
    pose = world_pose(after.motion).positions
    checked = 0
    for leg in legs_of(solved.motion.skeleton):
        length = np.linalg.norm(solved.motion.skeleton.offsets[[leg.shin, leg.foot]], axis=-1).sum()
        loose = np.linalg.norm(pose[:, leg.foot] - pose[:, leg.thigh], axis=-1) < 0.97 * length
        for a, b in runs(after.contacts.of(leg.toe)):
            inner = pose[a + 3 : b - 3, leg.toe][loose[a + 3 : b - 3]]
            if len(inner) and not a < stop < b:
                assert np.linalg.norm(inner - np.median(inner, axis=0), axis=-1).max() < 1e-3
                checked += len(inner)
    assert checked > 30
    slides = [slide_in_contact(motion, after.contacts) for motion in (solved.motion, after.motion)]
    assert slides[1] < 0.1 * slides[0]


def test_frames_outside_the_windows_are_the_same_bits():
    clips = {"idle": sample("idle"), "light_punch": sample("light_punch")}
    line = append(timeline(clips, "idle"), "light_punch")
    line = replace(line, seams=(Seam(stiffness=1.0),))
    solved = solve_timeline(line, clips)
    after = lock_feet(solved)
    (window,) = clusters(solved.seams, solved.motion.frames)
    same = (after.rotations == solved.motion.rotations).all(axis=(1, 2))
    assert window.start > 0
    assert window.stop < after.frames
    assert same[: window.start].all()
    assert same[window.stop :].all()
    assert not same.all()


@pytest.mark.parametrize("yaw", [0.7, -2.9])
def test_turning_the_world_turns_the_result(yaw: float):
    plain, turned = lock_feet(joined("walk", "kick", 84, 30)), lock_feet(joined("walk", "kick", 84, 30, turn=yaw))
    expected = turn_about_up(plain, yaw, (yaw, 0.0, -yaw))
    assert_motion_close(turned, expected, degrees=1e-4, metres=1e-6, world=True)


def test_no_joint_pops_where_a_lock_begins_or_ends():
    solved = walk_kick()
    after = lock_feet(solved)
    legs = [joint for leg in legs_of(after.skeleton) for joint in (leg.thigh, leg.shin, leg.foot)]
    steps = quat_distance(after.rotations[1:, legs], after.rotations[:-1, legs])
    own = max(quat_distance(m.rotations[1:, legs], m.rotations[:-1, legs]).max() for m in map(sample, ("walk", "kick")))
    assert steps.max() < 1.5 * own


@pytest.mark.parametrize(("left", "right", "stop", "start"), [("walk", "kick", 84, 30), ("run", "jump", 60, 10)])
def test_time_may_run_backwards(left: str, right: str, stop: int, start: int):
    clips = {name: sample(name) for name in (left, right)}
    back = {name: backwards(motion) for name, motion in clips.items()}
    counts = {name: motion.frames for name, motion in clips.items()}
    line = paste(timeline(clips, left), stop, counts[left], right, start, counts[right], seam=SEAM)
    turned = paste(
        timeline(back, right), counts[right] - start, counts[right], left, counts[left] - stop, counts[left], seam=SEAM
    )
    forth, there = (lock_feet(solve_timeline(*edit)) for edit in ((line, clips), (turned, back)))
    aligned = onto(backwards(there), forth)
    assert_motion_close(aligned, forth, degrees=0.02, metres=2e-4, world=True)


def backwards(motion: Motion) -> Motion:
    return replace(motion, rotations=motion.rotations[::-1], translations=motion.translations[::-1])


def onto(motion: Motion, like: Motion) -> Motion:
    """The motion turned and moved on the ground so that its hips begin as `like`'s do: placement starts elsewhere."""
    ours, theirs = world_pose(motion), world_pose(like)
    turn = quat_multiply(theirs.rotations[0, 0], quat_conjugate(ours.rotations[0, 0]))
    yaw = 2 * np.arctan2(turn[1], turn[3])
    moved = turn_about_up(motion, yaw)
    shift = theirs.positions[0, 0] - world_pose(moved).positions[0, 0]
    return turn_about_up(moved, 0.0, shift)


def test_feet_without_a_stance_near_a_seam_are_kept_off_the_ground():
    """A stance released everywhere still does not let its foot fall through the ground."""
    solved = joined("run", "idle", 60, 1)
    after = locked(solved)
    pose, before = world_pose(after.motion).positions, world_pose(solved.motion).positions
    toes = [leg.toe for leg in legs_of(solved.motion.skeleton)]
    floor = min(world_pose(motion).positions[:, toes, 1].min() for motion in solved.placed.sources.values())
    assert before[:, toes, 1].min() < floor - 0.01
    assert pose[:, toes, 1].min() > floor - 0.008


@pytest.mark.parametrize("name", ["walk", "run"])
def test_a_clip_put_back_where_it_was_is_left_alone(name: str):
    clips = {name: sample(name)}
    line = paste(timeline(clips, name), 50, 100, name, 50, 100, seam=SEAM)
    solved = solve_timeline(line, clips)
    assert np.abs(lock_feet(solved).rotations - solved.motion.rotations).max() < 1e-9


@pytest.mark.parametrize("name", ["walk", "run", "kick"])
@pytest.mark.parametrize("fps", [30.0, 60.0])
def test_a_seam_without_a_gap_moves_no_leg(name: str, fps: float):
    """A clip joined to its own copy, wherever it is cut: in a stance, in a swing, or where one becomes the other."""
    clip = sample(name, fps=fps)
    clips = {"original": clip, "copy": clip}
    for frame in range(5, clip.frames - 5, 7):
        line = paste(timeline(clips, "original"), frame, clip.frames, "copy", frame, clip.frames, seam=SEAM)
        solved = solve_timeline(line, clips)
        assert len(solved.seams) == 1
        after = locked(solved)
        assert_motion_close(after.motion, clip, degrees=1e-5, metres=1e-8, world=True)
        assert (after.contacts.held == placed_contacts(solved.placed).held).all()


@pytest.mark.parametrize(("name", "frame"), [("walk", 60), ("walk", 75), ("run", 40)])
def test_what_a_lock_does_vanishes_with_the_gap(name: str, frame: int):
    """A thousandth of a gap moves legs by about a thousandth, whatever the foot is doing at the cut."""
    clip = sample(name)
    moved = []
    for share in (1e-3, 1e-6):
        legs = [leg.thigh for leg in legs_of(clip.skeleton)]
        other = clip.rotations.copy()
        other[:, legs] = quat_multiply(other[:, legs], rotvec_to_quat([share, 0.0, 0.0]))
        clips = {"original": clip, "copy": replace(clip, rotations=other)}
        line = paste(timeline(clips, "original"), frame, clip.frames, "copy", frame, clip.frames, seam=SEAM)
        solved = solve_timeline(line, clips)
        moved.append(quat_distance(lock_feet(solved).rotations, solved.motion.rotations).max())
    assert moved[0] < 30e-3
    assert moved[1] < 30e-6


def test_a_hard_cut_near_by_loosens_no_bound():
    clips = {"walk": sample("walk"), "kick": sample("kick")}
    line = paste(timeline(clips, "walk"), 84, 130, "kick", 30, 72)
    added = []
    for hard in (Seam(smoothing=0.1), Seam(stiffness=0.0)):
        solved = solve_timeline(replace(line, seams=(Seam(smoothing=0.1), hard)), clips)
        first = solved.seams[0]
        added.append(added_acceleration(lock_feet(solved), solved.placed, first, 30).peak)
    assert added[1] < max(added[0], MOST) + 0.05


def test_a_lock_adds_little_acceleration():
    """Beside the solve's own share no leg is thrown harder than the bound, but on few seams: where a foot would
    sink into the ground or rush along it.
    """
    more = []
    for left, right in list(permutations(SAMPLE_NAMES, 2))[::3]:
        solved = joined(left, right, sample(left).frames // 2, 20)
        (seam,) = solved.seams
        before, after = (
            added_acceleration(motion, solved.placed, seam, 60).peak for motion in (solved.motion, lock_feet(solved))
        )
        more.append(after - max(before, MOST))
    assert len(more) == 19
    assert np.sum(np.array(more) > 0.03) <= 2


@pytest.mark.filterwarnings("ignore:The way back")
@pytest.mark.parametrize(("at", "other"), [(60, "jumping_jacks"), (60, "kick"), (100, "jumping_jacks")])
def test_hips_come_down_without_a_step_where_the_body_is_back_on_its_path(at: int, other: str):
    clips = {"walk": sample("walk"), other: sample(other)}
    line = come_back(paste(timeline(clips, "walk"), at, at + 10, other, 30, 100, seam=SEAM), 0.5)
    solved = solve_timeline(line, clips)
    down = (lock_feet(solved).translations - solved.motion.translations)[:, hips_joint(solved.motion.skeleton)]
    assert np.abs(down).max() > 0.01
    assert not down[solved.placed.firm[0] :].any()
    assert np.abs(np.diff(down, n=2, axis=0)).max() < 2e-3


def test_refusals():
    solved = walk_kick()
    with pytest.raises(ParameterError, match="blend"):
        lock_feet(solved, blend=0.0)
    with pytest.raises(ParameterError, match="frames"):
        lock_feet(solved, find_contacts(sample("walk")))
    clips = {"a": random_motion(0), "b": random_motion(1)}
    with pytest.raises(SkeletonMismatchError, match="two feet") as caught:
        lock_feet(solve_timeline(append(timeline(clips, "a"), "b"), clips))
    assert "\n" not in str(caught.value)


def test_the_report_tells_before_after_and_the_sources():
    solved = walk_kick()
    after = locked(solved)
    told = skating_report(solved, after.motion, after.contacts)
    for name in ("slide_in_contact_m_s", "skate_near_seams_m_s"):
        assert told[f"{name}_after"] < 0.5 * told[f"{name}_before"]
    assert told["skating_share_after"] <= told["skating_share_before"]
    assert set(told["contacts"]) == {solved.motion.skeleton.names[joint] for joint in after.contacts.joints}


WALK, KICK = "mixamo_xbot_60fps/Walking (1).fbx", "mixamo_xbot_60fps/Kicking.fbx"
REAL = {
    "walk → kick → walk, mixamo": (WALK, KICK, (50, 90), (15, 115), 1.1),
    "walk → kick → walk, bandai": (
        "bandai/dataset-1_walk_normal_001.bvh",
        "bandai/dataset-1_kick_normal_001.bvh",
        (80, 110),
        (100, 200),
        5.0,
    ),
    "run → jump → run": (
        "mixamo_xbot_60fps/Running.fbx",
        "mixamo_xbot_60fps/Running Jump.fbx",
        (20, 25),
        (0, 100),
        3.6,
    ),
}
"""Two clips, frames replaced and frames pasted, and how many times the clips' own feet may skate near the seams."""


@pytest.mark.parametrize("name", REAL)
def test_real_feet_slide_about_as_little_as_in_their_sources(name: str):
    folder = os.environ.get("KINESTITCH_DATA")
    if not folder:
        pytest.skip("KINESTITCH_DATA is not set")
    first, second, over, of, skates = REAL[name]
    clips = {key: files.read(Path(folder) / place) for key, place in (("a", first), ("b", second))}
    solved = solve_timeline(paste(timeline(clips, "a"), *over, "b", *of), clips)
    after = locked(solved)
    told = skating_report(solved, after.motion, after.contacts)
    assert told["slide_in_contact_m_s_after"] < 1.01 * told["slide_in_contact_m_s_sources"]
    assert told["slide_in_contact_m_s_after"] < 0.7 * told["slide_in_contact_m_s_before"]
    assert told["skate_near_seams_m_s_after"] < skates * told["skate_near_seams_m_s_sources"]
    for seam in solved.seams:
        assert added_acceleration(after.motion, solved.placed, seam, round(solved.motion.fps)).peak < 0.6
