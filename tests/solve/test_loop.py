"""Loops against dense periodic least squares written out frame by frame, and what a loop never does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from rig_bodies import hips_first, turning_walk
from rig_builders import below_a_dummy
from scipy.spatial.transform import Rotation
from solve_oracles import reversed_motion

import kinestitch as ks
from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    quat_about_axis,
    quat_conjugate,
    quat_distance,
    quat_multiply,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.errors import ParameterError, RangeError
from kinestitch.rig.carrier import with_world_carrier
from kinestitch.rig.root_motion import extract_root
from kinestitch.solve.loop import Looped, around_seam, loop, loop_carrier, opened, repeated, solve_loop
from kinestitch.solve.periodic import loop_curves, loop_interval_curves
from kinestitch.solve.seam import seam_reach
from kinestitch.solve.weld import SPIN
from kinestitch.testing import assert_motion_close, check_motion, random_motion

SEEDS = st.integers(0, 2**32 - 1)
LAMBDAS = st.sampled_from([1e-3, 1.0, 81.0, 1296.0, 1e6])
EXACT = {"degrees": float(np.degrees(1e-9)), "metres": 1e-9}


def periodic_laplacian(frames: int) -> np.ndarray:
    out = np.zeros((frames, frames))
    for t in range(frames):
        for frame, value in ((t - 1, 1.0), (t, -2.0), (t + 1, 1.0)):
            out[t, frame % frames] += value
    return out


def dense(error: np.ndarray, stiffness: float) -> np.ndarray:
    """argmin ‖c‖² + λ‖L c − error‖² by ``numpy.linalg.lstsq``, L periodic; (N, C)."""
    root = np.sqrt(stiffness)
    left = np.vstack([np.eye(len(error)), root * periodic_laplacian(len(error))])
    return np.linalg.lstsq(left, np.vstack([np.zeros_like(error), root * error]), rcond=None)[0]


def residual(frames: int, rows: dict[int, np.ndarray]) -> np.ndarray:
    """Rows (N, C) of e, given by frame number; in a short cycle several may be one."""
    out = np.zeros((frames, next(iter(rows.values())).size))
    for row, value in rows.items():
        out[row % frames] += value.ravel()
    return out


def about_y(yaw: float) -> Rotation:
    return Rotation.from_rotvec([0.0, yaw, 0.0])


def naive_loop(motion: Motion, start: int, stop: int, stiffness: float) -> Motion:
    """The cycle of a clip whose root is its hips, with frames of its own two places beyond both ends."""
    count = stop - start
    rotations, translations = motion.rotations[start - 1 : stop + 1].copy(), motion.translations.copy()
    hips = Rotation.from_quat(rotations[:, 0].copy())
    relative = (hips[[-2, -1]] * hips[[0, 1]].inv()).as_quat()
    mean = relative[0] + relative[1] * np.sign(relative[0] @ relative[1])
    yaw = (2 * np.arctan2(mean[1], mean[3]) + np.pi) % (2 * np.pi) - np.pi
    turns = [about_y(-yaw * t / count) for t in range(-1, count + 1)]
    rotations[:, 0] = [(turn * q).as_quat() for turn, q in zip(turns, hips, strict=True)]
    out = np.empty((count + 1, motion.skeleton.joint_count, 4))
    for joint in range(motion.skeleton.joint_count):
        around = rotations[[-2, -1, 0, 1], joint]
        centre = Rotation.from_quat(np.linalg.eigh(around.T @ around)[1][:, -1])
        vectors = (centre.inv() * Rotation.from_quat(rotations[:, joint].copy())).as_rotvec()
        before, after = vectors[0] - vectors[-2], vectors[1] - vectors[-1]
        solved = vectors[1:-1] + dense(residual(count, {-1: -after, 0: before}), stiffness)
        out[:-1, joint] = (centre * Rotation.from_rotvec(solved)).as_quat()
    for frame in range(count):
        out[frame, 0] = (turns[frame + 1].inv() * Rotation.from_quat(out[frame, 0].copy())).as_quat()
    out[-1] = out[0]
    out[-1, 0] = (about_y(yaw) * Rotation.from_quat(out[0, 0].copy())).as_quat()
    moved = naive_translations(translations, start, stop, yaw, stiffness)
    return replace(motion, rotations=out, translations=moved)


def naive_translations(values: np.ndarray, start: int, stop: int, yaw: float, stiffness: float) -> np.ndarray:
    count = stop - start
    before, after = values[start - 1] - values[stop - 1], values[start] - values[stop]
    cycle = values[start:stop].reshape(count, -1)
    cycle = cycle + dense(residual(count, {-1: -after, 0: before}), stiffness)
    out = np.concatenate([cycle, cycle[:1]]).reshape(count + 1, -1, 3)
    steps = {
        k: about_y(-yaw * (k + 0.5) / count).apply(np.diff(values[start + k : start + k + 2, 0], axis=0))[0]
        for k in range(-2, count + 1)
    }
    gap = {k: steps[count - 1 + k] - steps[k - 1] for k in (-1, 0, 1)}
    error = residual(count, {-2: gap[0] / 2, -1: (gap[1] - gap[-1]) / 2, 0: -gap[0] / 2})
    steps[count - 1] = (steps[count - 1] + steps[-1]) / 2
    solved = np.array([steps[k] for k in range(count)]) + dense(error, stiffness)
    path = [np.zeros(3)]
    for k in range(count):
        path.append(path[-1] + about_y(yaw * (k + 0.5) / count).apply(solved[k]))
    at = np.array(path)
    own, middle = values[start:stop, 0], [(count - 1) // 2, count // 2]
    at += (own[middle] - at[middle]).mean(axis=0)
    out[:, 0, [0, 2]] = at[:, [0, 2]]
    return out


@settings(max_examples=40, deadline=None)
@given(SEEDS, st.integers(2, 3), st.integers(3, 40), LAMBDAS)
def test_a_loop_is_dense_periodic_least_squares(seed, start, count, stiffness):
    motion = hips_first(random_motion(seed, frames=50, bend=0.4))
    cycle = loop(motion, start, start + count, stiffness=stiffness)
    assert_motion_close(cycle, naive_loop(motion, start, start + count, stiffness), **EXACT)


@given(st.integers(2, 60), LAMBDAS)
def test_curves_of_windows_longer_than_the_cycle_wrap_around(frames, stiffness):
    assume(2 * seam_reach(stiffness) > frames)
    units = np.eye(frames)
    before, after = units[[-1]] * -1.0, units[[0]]  # residual rows of d_N and of d_{N−1}
    wanted = np.hstack([dense(after.T, stiffness), dense(before.T, stiffness)])
    np.testing.assert_allclose(loop_curves(stiffness, frames), wanted, atol=1e-9)
    rows = np.hstack([dense(units[:, [row % frames]], stiffness) for row in (-2, -1, 0)])
    np.testing.assert_allclose(loop_interval_curves(stiffness, frames), rows, atol=1e-9)
    assert np.abs(loop_interval_curves(stiffness, frames).sum(axis=0)).max() < 1e-9


def random_cycle(seed: int, frames: int, yaw: float) -> Motion:
    """Joints that swing in harmonics of the cycle, on a body that walks and turns; the last frame repeats the first."""
    motion, rng = hips_first(random_motion(seed, frames=frames + 1)), np.random.default_rng(seed)
    phase = 2 * np.pi * np.arange(frames + 1)[:, None, None] / frames
    waves = sum(rng.normal(size=(1, 4, 6)) * 0.1 * np.sin(k * phase + rng.uniform(0, 6.28, (1, 4, 6))) for k in (1, 2))
    waves[-1] = waves[0]
    rotations = quat_multiply(motion.rotations[:1], rotvec_to_quat(waves[..., :3]))
    turn = Rotation.from_rotvec(np.linspace(0, yaw, frames + 1)[:, None] * [0.0, 1.0, 0.0])
    rotations[:, 0] = (turn * Rotation.from_quat(rotations[:, 0].copy())).as_quat()
    translations = np.broadcast_to(motion.skeleton.offsets, (frames + 1, 4, 3)).copy()
    translations[:, 0, 1] += waves[:, 0, 3]
    pace = waves[:-1, 0, 4:] / frames + np.array([1.0, 0.5]) / frames
    for frame in range(frames):
        step = np.array([pace[frame, 0], 0.0, pace[frame, 1]])
        middle = about_y(yaw * (frame + 0.5) / frames)
        translations[frame + 1, 0, [0, 2]] = translations[frame, 0, [0, 2]] + middle.apply(step)[[0, 2]]
    return replace(motion, rotations=rotations, translations=translations)


@given(SEEDS, st.integers(40, 90), st.sampled_from([0.0, 0.3, -2.0]), LAMBDAS)
def test_a_clip_that_is_a_cycle_comes_back(seed, frames, yaw, stiffness):
    cycle = random_cycle(seed, frames, yaw)
    assert_motion_close(loop(cycle, stiffness=stiffness), cycle, **EXACT)
    twice = repeated(cycle, 3)
    inside = _part(twice, 5, 5 + frames + 1)
    assert_motion_close(loop(twice, 5, 5 + frames, stiffness=stiffness), inside, **EXACT)


@given(SEEDS, st.integers(40, 90), st.sampled_from([0.0, 0.3, -2.0]), LAMBDAS)
def test_so_does_one_that_stops_a_frame_before_its_first_pose(seed, frames, yaw, stiffness):
    """Only how far it goes and turns over the seam is not in the clip, and taken from the steps beside it."""
    cycle = random_cycle(seed, frames, yaw)
    found = loop(opened(cycle), 0, frames, stiffness=stiffness)
    assert_motion_close(opened(found), opened(cycle), **EXACT)
    apart = quat_distance(found.rotations[-1], cycle.rotations[-1])
    assert apart[1:].max() < 1e-7
    assert apart[0] < 0.05
    steps = np.linalg.norm(np.diff(found.translations[:, 0, [0, 2]], axis=0), axis=-1)
    assert steps[-1] == pytest.approx((steps[0] + steps[-2]) / 2, rel=0.05)


def _part(motion: Motion, start: int, stop: int) -> Motion:
    return replace(motion, rotations=motion.rotations[start:stop], translations=motion.translations[start:stop])


@given(SEEDS, st.integers(0, 3), st.integers(8, 40), LAMBDAS)
def test_looping_again_moves_only_what_kinks(seed, start, count, stiffness):
    """A joint is left alone whose velocity changes no more at the seam than elsewhere in the cycle, plus 5°/s."""
    motion = hips_first(random_motion(seed, frames=50, bend=0.6))
    cycle = loop(motion, start, start + count, stiffness=stiffness)
    again = solve_loop(cycle, 0, count, stiffness=stiffness)
    assert_motion_close(again.cut, cycle, **EXACT)
    changes = np.linalg.norm(second_differences(repeated(cycle, 2)), axis=-1)
    smooth = changes[count - 2 : count].max(axis=0) < changes[: count - 2].max(axis=0) + 0.99 * SPIN / 30
    moved = quat_distance(again.motion.rotations, cycle.rotations)
    assert moved[:, smooth].max(initial=0.0) < 1e-7


@given(SEEDS, st.integers(0, 2), st.integers(5, 48), LAMBDAS, st.floats(-3, 3), st.floats(-5, 5))
def test_turning_and_moving_the_clip_turns_and_moves_the_loop(seed, start, count, stiffness, yaw, shift):
    motion = random_motion(seed, frames=50, bend=1.5)
    place = (shift, 0.0, -2 * shift)
    moved = turn_about_up(motion, yaw, place)
    cycle = loop(motion, start, start + count, stiffness=stiffness)
    wanted = turn_about_up(cycle, yaw, place)
    assert_motion_close(loop(moved, start, start + count, stiffness=stiffness), wanted, degrees=1e-5, metres=1e-8)


@given(SEEDS, st.integers(0, 2), st.integers(5, 48), LAMBDAS)
def test_the_reversed_clip_gives_the_reversed_loop(seed, start, count, stiffness):
    motion = hips_first(random_motion(seed, frames=50, bend=0.6))
    there = loop(motion, start, start + count, stiffness=stiffness, closed=False)
    back = loop(reversed_motion(motion), 50 - start - count, 50 - start, stiffness=stiffness, closed=False)
    assert_motion_close(reversed_motion(back), there, degrees=1e-5, metres=1e-8)


@given(SEEDS, st.integers(0, 3), st.integers(3, 47), LAMBDAS, st.sampled_from([0.3, 1.5, 3.0]))
def test_the_last_frame_repeats_the_first_but_for_place_and_heading(seed, start, count, stiffness, bend):
    motion = random_motion(seed, frames=50, bend=bend)
    looped = solve_loop(motion, start, start + count, stiffness=stiffness)
    for cycle in (looped.motion, looped.cut):
        check_motion(cycle)
        assert cycle.frames == count + 1
        assert_closed(cycle, looped.carrier)


def assert_closed(cycle: Motion, carrier: int) -> None:
    """Rotations and translations of the last frame are the first one's, but for the carrier's yaw and place."""
    told = with_world_carrier(cycle, carrier)
    turns = quat_distance(told.rotations[0], told.rotations[-1])
    moves = np.abs(told.translations[0] - told.translations[-1])
    between = quat_multiply(told.rotations[-1, carrier], told.rotations[0, carrier] * [-1, -1, -1, 1])
    assert np.hypot(between[0], between[2]) < 1e-9
    moves[carrier, [0, 2]] = turns[carrier] = 0.0
    assert turns.max() < 1e-7
    assert moves.max() < 1e-9


@given(SEEDS, st.integers(3, 48), st.integers(1, 4))
def test_a_repeated_cycle_goes_on_as_it_began(seed, count, times):
    motion = random_motion(seed, frames=50, bend=1.0)
    cycle = loop(motion, 1, 1 + count)
    many = repeated(cycle, times)
    assert many.frames == times * count + 1
    assert_motion_close(_part(many, 0, count + 1), cycle, **EXACT)
    world = world_pose(many)
    for copy in range(times):
        shown = slice(copy * count, (copy + 1) * count + 1)
        apart = world.positions[shown] - world.positions[shown, :1]  # rigid on the ground: distances and heights stay
        first = world.positions[: count + 1] - world.positions[: count + 1, :1]
        np.testing.assert_allclose(np.linalg.norm(apart, axis=-1), np.linalg.norm(first, axis=-1), atol=1e-8)
        np.testing.assert_allclose(world.positions[shown, :, 1], world.positions[: count + 1, :, 1], atol=1e-8)


def second_differences(motion: Motion) -> np.ndarray:
    """Changes (F − 2, J, 3) of every joint's step in its own axes, from frame to frame."""
    turns = quat_to_rotvec(quat_multiply(quat_conjugate(motion.rotations[:-1]), motion.rotations[1:]))
    return np.diff(turns, axis=0)


@given(SEEDS, st.integers(20, 48), st.sampled_from([0.0, 1.3]))
def test_three_copies_show_no_seam(seed, count, per_second):
    """Across the copies every second difference is found again one cycle later, and the largest is the clip's own but
    for what the gap adds.
    """
    walk = turning_walk(per_second) if per_second else random_motion(seed, frames=50, bend=0.6)
    looped = solve_loop(walk, 1, 1 + count, smoothing=0.1)
    many = second_differences(repeated(looped.motion, 3))
    np.testing.assert_allclose(many[:count], many[count : 2 * count], atol=1e-9)
    np.testing.assert_allclose(many[count - 2 : 2 * count - 2], many[2 * count - 2 : 3 * count - 2], atol=1e-9)
    seam = np.linalg.norm(many[count - 2 : count], axis=-1).max()
    cut = np.linalg.norm(second_differences(repeated(looped.cut, 2))[count - 2 : count], axis=-1).max()
    own = np.linalg.norm(second_differences(looped.cut), axis=-1)[: count - 2].max()
    assert seam <= own + 0.25 * max(cut, own)


@given(SEEDS, st.sampled_from([0.0, 0.7]))
def test_far_from_its_ends_a_loop_is_the_clip_joined_to_itself(seed, bend):
    """Joints below the hips as in the stitch of the clip with itself; the hips too where the cycle does not turn."""
    motion = hips_first(random_motion(seed, frames=202, bend=0.6))
    looped = solve_loop(motion, 1, 201, stiffness=81.0)
    clips = {"a": motion}
    infos = (ClipInfo("a", 202, 30.0),)
    parts = (Segment("a", FrameRange(1, 201)),) * 2
    stitched = ks.stitch(Timeline(infos, parts, (Seam(81.0),), 30.0), clips)
    for joint in (1, 2, 3):
        both = [q[:, joint] for q in (stitched.rotations, looped.motion.rotations)]
        assert quat_distance(both[0][100:200], both[1][100:200]).max() < 1e-7
        assert quat_distance(both[0][200:300], both[1][:100]).max() < 1e-7
    heights = stitched.translations[200:300, 0, 1] - looped.motion.translations[:100, 0, 1]
    assert np.abs(heights).max() < 1e-9


def test_frames_out_of_reach_stay():
    walk = ks.sample("walk")
    looped = solve_loop(walk, 3, 190, stiffness=1.0)
    reach = seam_reach(1.0)
    inside = _part(looped.motion, reach, looped.motion.frames - 1 - reach)
    assert_motion_close(inside, _part(walk, 3 + reach, 190 - reach), **EXACT)
    assert quat_distance(looped.motion.rotations[0], walk.rotations[3]).max() > 0.01


def test_a_body_below_a_dummy_loops_like_one_without():
    walk = turning_walk()
    plain, below = loop(walk, 5, 150), loop(below_a_dummy(walk), 5, 150)
    assert_motion_close(
        replace(
            below, skeleton=plain.skeleton, translations=below.translations[:, 1:], rotations=below.rotations[:, 1:]
        ),
        plain,
        **EXACT,
    )


def test_a_root_that_travels_keeps_travelling():
    rooted = extract_root(turning_walk(), smooth=0.5)
    looped = solve_loop(rooted, 5, 150)
    assert looped.carrier == 0
    assert_closed(looped.motion, 0)
    there, here = (world_pose(motion).positions for motion in (looped.motion, loop(turning_walk(), 5, 150)))
    assert np.abs(there[:, 1:] - here).max() < 0.02


def test_hips_that_travel_below_a_turning_root_are_the_carrier():
    walk = below_a_dummy(ks.sample("walk"))
    turns = quat_about_axis(1, np.linspace(0, 1, walk.frames))
    rotations = walk.rotations.copy()
    rotations[:, 0] = turns
    assert loop_carrier(replace(walk, rotations=rotations)) == 1
    idle = below_a_dummy(ks.sample("idle"))
    assert (
        loop_carrier(
            replace(idle, rotations=np.concatenate([turns[:1].repeat(241, 0)[:, None], idle.rotations[:, 1:]], 1))
        )
        == 1
    )
    rotations = idle.rotations.copy()
    rotations[:, 0] = quat_about_axis(1, np.linspace(0, 1, 241))
    assert loop_carrier(replace(idle, rotations=rotations)) == 0


@pytest.mark.parametrize("tilt", [0.1, 0.5])
def test_a_joint_that_turns_all_the_way_round_in_a_short_cycle_does_not_jump(tilt):
    """Its two halves lie on different sheets of the chart where they meet, in the middle of the cycle."""
    motion, count = hips_first(random_motion(3, frames=33, bend=0.2)), 30
    rotations, time = motion.rotations.copy(), np.linspace(0, 1, 33)[:, None]
    way = Rotation.from_rotvec(time * [tilt, 0.0, 0.0]) * Rotation.from_rotvec(time * [0.0, 0.0, 6.4])
    rotations[:, 2] = (Rotation.from_quat(rotations[:, 2].copy()) * way).as_quat()
    looped = solve_loop(replace(motion, rotations=rotations), 1, 1 + count, stiffness=1296.0)
    pair = (m.rotations[:-1, 2] for m in (looped.cut, looped.motion))
    moved = quat_to_rotvec(quat_multiply(*(q * sign for q, sign in zip(pair, ([-1, -1, -1, 1], 1), strict=True))))
    steps = np.linalg.norm(np.diff(moved, axis=0), axis=-1)[count // 2 - 4 : count // 2 + 3]
    assert steps[3] < 3 * np.delete(steps, 3).max()


def test_four_frames_around_the_seam():
    walk = ks.sample("walk")
    four = around_seam(walk, FrameRange(20, 80))
    assert_motion_close(_part(four, 0, 2), _part(walk, 19, 21), **EXACT)
    assert_motion_close(_part(four, 2, 4), _part(walk, 79, 81), **EXACT)
    ends = around_seam(walk, FrameRange(0, 200))  # three whole strides
    before = turn_about_up(_part(walk, 199, 200), 0.0, walk.translations[0, 0] - walk.translations[200, 0])
    assert_motion_close(_part(ends, 0, 1), before, degrees=1e-5, metres=1e-6)


def test_a_hard_cut_only_repeats_the_first_frame():
    walk = ks.sample("walk")
    looped = solve_loop(walk, 10, 90, stiffness=0.0)
    assert looped.motion is looped.cut
    assert_motion_close(_part(looped.motion, 0, 80), _part(walk, 10, 90), **EXACT)
    assert loop(walk, 10, 90, closed=False).frames == 80
    assert isinstance(looped, Looped)


def test_what_cannot_be_looped_is_refused():
    walk = ks.sample("walk")
    with pytest.raises(RangeError, match="at least 3 frames to loop, got 2"):
        loop(_part(walk, 0, 2))
    with pytest.raises(RangeError, match="at least 2 of the clip's 201 frames, got 5:6"):
        loop(walk, 5, 6)
    with pytest.raises(RangeError, match="got 5:202"):
        loop(walk, 5, 202)
    with pytest.raises(ParameterError, match="stiffness"):
        loop(walk, stiffness=-1.0)
    with pytest.raises(ParameterError, match="at least once, got 0"):
        repeated(loop(walk), 0)


@pytest.mark.parametrize("frames", [3, 4, 5])
def test_a_clip_of_few_frames_is_solved(frames):
    short = random_motion(3, frames=frames)
    assert solve_loop(short).motion.frames == frames + 1
