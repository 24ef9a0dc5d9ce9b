"""What stitching never does, whatever the clips: to be run over random bodies, poses near 0 and near π, and cuts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from solve_oracles import cast, line, reversed_motion

from kinestitch.core.kinematics import turn_about_up, with_joint_axes, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    quat_conjugate,
    quat_distance,
    quat_identity,
    quat_multiply,
    quat_normalize,
    rotvec_to_quat,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.operations import insert
from kinestitch.edit.operations import replace as paste
from kinestitch.edit.timeline import Seam, timeline
from kinestitch.solve.stitch import solve_timeline, stitch
from kinestitch.testing import assert_motion_close, quaternions, random_motion

CHARTS = st.sampled_from(["centred", "principal"])
LAMBDAS = st.sampled_from([0.0, 1e-3, 1.0, 81.0, 1296.0, 1e4])
SEEDS = st.integers(0, 2**32 - 1)
EXACT = {"degrees": float(np.degrees(1e-9)), "metres": 1e-9}


@st.composite
def bodies(draw: st.DrawFn, *, frames: int = 50) -> Motion:
    """A motion whose joints swing about poses near 0, near π, exactly there or anywhere, away from their rest."""
    seed = draw(SEEDS)
    motion = random_motion(seed, frames=frames, bend=draw(st.sampled_from([0.01, 0.3, 1.0, 3.0])))
    centres = np.stack([draw(quaternions()) for _ in range(4)])
    swing = quat_multiply(quat_conjugate(motion.rotations[:1]), motion.rotations)
    return replace(motion, rotations=quat_normalize(quat_multiply(centres, swing)))


@st.composite
def parts(draw: st.DrawFn, frames: int, most: int = 4) -> list[tuple[str, int, int]]:
    out = []
    for _ in range(draw(st.integers(2, most))):
        start = draw(st.integers(0, frames - 1))
        out.append((draw(st.sampled_from("ab")), start, draw(st.integers(start + 1, frames))))
    return out


@given(bodies(), st.lists(st.integers(1, 49), max_size=4), LAMBDAS, CHARTS)
def test_a_clip_cut_and_put_back_is_itself(motion: Motion, cuts: list[int], stiffness: float, chart: str):
    edges = sorted({0, *cuts, 50})
    clips = {"a": motion}
    whole = line([("a", i, j) for i, j in pairwise(edges)], clips, Seam(stiffness=stiffness))
    assert_motion_close(stitch(whole, clips, chart=chart), motion, degrees=1e-12, metres=0)  # type: ignore[arg-type]


@given(bodies(), st.integers(0, 48), st.integers(1, 50), LAMBDAS, CHARTS, st.booleans())
def test_frames_pasted_over_themselves_change_nothing(
    motion: Motion, start: int, stop: int, stiffness: float, chart: str, moved: bool
):
    """The pasted frames come from a clip of their own, so that there are seams; it may stand anywhere."""
    assume(start < stop)
    copy = turn_about_up(motion, 1.3, (5.0, 0.0, -2.0)) if moved else motion
    clips = {"a": motion, "b": copy}
    edited = paste(timeline(clips, "a"), start, stop, "b", start, stop, seam=Seam(stiffness=stiffness))
    out = stitch(edited, clips, chart=chart)  # type: ignore[arg-type]
    root_level = 1e-6 if moved and chart == "principal" else 1e-9  # near π the principal chart amplifies rounding
    if moved and start == 0:
        yaw = quat_multiply(out.rotations[0, 0], quat_conjugate(motion.rotations[0, 0]))
        motion = turn_about_up(motion, 2 * np.arctan2(yaw[1], yaw[3]))
        shift = (out.translations[0, 0] - motion.translations[0, 0]) * [1, 0, 1]
        motion = turn_about_up(motion, 0.0, shift)
    if chart == "centred":
        assert_motion_close(out, motion, degrees=np.degrees(root_level), metres=1e-9)
    elif not moved:
        assert_motion_close(out, motion, **EXACT)


@given(bodies(), SEEDS, st.integers(1, 49), st.integers(1, 30), LAMBDAS)
def test_inserting_keeps_what_was_there(motion: Motion, seed: int, at: int, count: int, stiffness: float):
    other = random_motion(seed, frames=50)
    clips = {"a": motion, "b": other}
    edited = insert(timeline(clips, "a"), at, "b", 5, 5 + count, seam=Seam(stiffness=min(stiffness, 1e-3)))
    solved = solve_timeline(edited, clips)
    np.testing.assert_array_equal(solved.cut.rotations[:at], motion.rotations[:at])
    np.testing.assert_array_equal(solved.cut.rotations[at + count :, 1:], motion.rotations[at:, 1:])
    before = max(0, at - 16)
    np.testing.assert_array_equal(solved.motion.rotations[:before], motion.rotations[:before])
    assert solved.motion.frames == 50 + count


@given(SEEDS, parts(60), LAMBDAS, st.sampled_from([0.3, 1.0, 2.5]))
def test_time_reversal(seed: int, segments: list[tuple[str, int, int]], stiffness: float, bend: float):
    clips = {key: random_motion(seed + i, frames=60, bend=bend) for i, key in enumerate("ab")}
    there = stitch(line(segments, clips, Seam(stiffness=stiffness)), clips)
    back_clips = {key: reversed_motion(motion) for key, motion in clips.items()}
    back_segments = [(key, 60 - stop, 60 - start) for key, start, stop in segments[::-1]]
    back = reversed_motion(stitch(line(back_segments, back_clips, Seam(stiffness=stiffness)), back_clips))
    assert quat_distance(there.rotations[:, 1:], back.rotations[:, 1:]).max() < 1e-8
    # Each is placed by its own first segment; the same rigid move on the ground brings all frames together.
    turn = quat_multiply(there.rotations[0, 0], quat_conjugate(back.rotations[0, 0]))
    back = turn_about_up(back, 2 * np.arctan2(turn[1], turn[3]))
    back = turn_about_up(back, 0.0, (there.translations[0, 0] - back.translations[0, 0]) * [1, 0, 1])
    assert_motion_close(replace(back, name=there.name), there, degrees=1e-6, metres=1e-8)


@given(SEEDS, parts(50), LAMBDAS, st.floats(-3.1, 3.1), CHARTS)
def test_a_world_turned_and_moved_turns_and_moves_the_result(
    seed: int, segments: list[tuple[str, int, int]], stiffness: float, yaw: float, chart: str
):
    clips = cast(2, frames=50)
    rng = np.random.default_rng(seed)
    shift = rng.normal(size=3) * [3, 0.2, 3]
    wish = line(segments, clips, Seam(stiffness=stiffness))
    expected = turn_about_up(stitch(wish, clips), yaw, shift)
    moved = {key: turn_about_up(motion, yaw, shift) for key, motion in clips.items()}
    assert_motion_close(stitch(wish, moved), expected, **EXACT)
    # Moving one clip alone changes nothing but where the first segment stands.
    first = segments[0][0]
    other = "b" if first == "a" else "a"
    alone = clips | {other: turn_about_up(clips[other], yaw, shift * [1, 0, 1])}
    plain = stitch(wish, clips, chart=chart)  # type: ignore[arg-type]
    one = stitch(wish, alone, chart=chart)  # type: ignore[arg-type]
    assert_motion_close(one, plain, **EXACT)


@given(SEEDS, parts(50), LAMBDAS)
def test_the_rest_pose_changes_nothing_in_the_centred_chart(
    seed: int, segments: list[tuple[str, int, int]], stiffness: float
):
    clips = cast(2, frames=50, bend=1.0)
    rig = clips["a"].skeleton
    rest = quat_normalize(np.random.default_rng(seed).normal(size=rig.rest.shape))
    other = Skeleton(rig.names, rig.parents, rig.offsets, rest)
    rested = {key: replace(motion, skeleton=other) for key, motion in clips.items()}
    wish = line(segments, clips, Seam(stiffness=stiffness))
    out, plain = stitch(wish, rested), stitch(wish, clips)
    assert_motion_close(out, plain, **EXACT)


@given(SEEDS, parts(50), st.sampled_from([1.0, 81.0, 1296.0]))
def test_joint_axes_change_nothing_in_the_centred_chart(
    seed: int, segments: list[tuple[str, int, int]], stiffness: float
):
    """Rotations told in other axes, with the rest pose turned along: the same world, the same result."""
    clips = cast(2, frames=50, bend=0.8)
    axes = quat_normalize(np.random.default_rng(seed).normal(size=(4, 4)))
    turned = {key: with_joint_axes(motion, axes) for key, motion in clips.items()}
    wish = line(segments, clips, Seam(stiffness=stiffness))
    out, plain = world_pose(stitch(wish, turned)), world_pose(stitch(wish, clips))
    np.testing.assert_allclose(out.positions, plain.positions, rtol=0, atol=1e-9)


def test_the_rest_pose_matters_in_the_principal_chart():
    clips = cast(2, frames=50, bend=1.0)
    rig = clips["a"].skeleton
    wish = line([("a", 0, 25), ("b", 20, 50)], clips)
    plain = stitch(wish, clips, chart="principal")
    far = quat_multiply(rig.rest, rotvec_to_quat(np.array([[2.8, 0.0, 0.0]])))
    worst = 0.0
    for rest in (far, quat_identity((4,))):
        other = Skeleton(rig.names, rig.parents, rig.offsets, rest)
        rested = {key: replace(motion, skeleton=other) for key, motion in clips.items()}
        out = stitch(wish, rested, chart="principal")
        worst = max(worst, float(quat_distance(out.rotations, plain.rotations).max()))
    assert worst > 0.3
