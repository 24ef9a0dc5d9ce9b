"""Another pace: the time map, the poses between frames, and what they have in common with plain resampling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from kinestitch.core.motion import Motion
from kinestitch.core.retime import poses_at, retime, time_map
from kinestitch.core.rotation import (
    quat_conjugate,
    quat_distance,
    quat_multiply,
    quat_normalize,
    quat_slerp,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.errors import ParameterError
from kinestitch.samples import sample
from kinestitch.testing import random_motion

STEPS = st.lists(st.tuples(st.floats(0.05, 2.0), st.floats(0.1, 10.0)), min_size=1, max_size=6)


def knots_of(steps: list[tuple[float, float]]) -> list[tuple[float, float]]:
    knots = [(0.0, 0.3)]
    for length, speed in steps:
        knots.append((knots[-1][0] + length, knots[-1][1] + length * speed))
    return knots


def wild(seed: int, frames: int = 9, joints: int = 3) -> Motion:
    """Rotations that have nothing to do with each other from frame to frame."""
    rng = np.random.default_rng(seed)
    calm = random_motion(seed, joints=joints, frames=frames)
    return replace(
        calm,
        rotations=quat_normalize(rng.normal(size=calm.rotations.shape)),
        translations=rng.normal(size=calm.translations.shape),
    )


def backwards(motion: Motion) -> Motion:
    return replace(motion, rotations=motion.rotations[::-1], translations=motion.translations[::-1])


@given(STEPS)
def test_time_rises_monotonely_through_all_knots(steps):
    knots = knots_of(steps)
    x, y = np.array(knots).T
    assert np.allclose(time_map(knots, x), y, rtol=0, atol=1e-12 * y[-1])
    inside = time_map(knots, np.linspace(0, x[-1], 500))
    assert (np.diff(inside) > 0).all()
    speeds = np.diff(time_map(knots, [-2.0, -1.0])), np.diff(time_map(knots, [x[-1] + 1, x[-1] + 2]))
    assert min(*speeds) > 0 or len(knots) > 2  # a curve may start at rest


@given(STEPS, st.floats(0.1, 10.0))
def test_another_pace_of_a_time_map_is_the_map_of_scaled_knots(steps, speed):
    knots = knots_of(steps)
    times = np.linspace(0, knots[-1][0], 50)
    scaled = [(time / speed, shown) for time, shown in knots]
    assert np.allclose(time_map(scaled, times / speed), time_map(knots, times), rtol=0, atol=1e-10 * knots[-1][1])


def test_the_time_map_is_the_monotone_cubic():
    knots = knots_of([(0.5, 1.0), (0.2, 3.0), (1.0, 0.4), (0.3, 1.0)])
    times = np.linspace(0, knots[-1][0], 101)
    assert np.allclose(time_map(knots, times), PchipInterpolator(*np.array(knots).T)(times))


def test_a_straight_stretch_of_three_knots_is_the_clip_itself_to_the_bit_of_a_frame():
    knots = [(0.0, 0.0), (0.9, 0.9), (1.0, 1.0), (1.5, 1.2), (2.0, 1.7)]
    times = np.arange(54) / 60
    assert np.abs(time_map(knots, times) - times).max() < 1e-12


@given(st.integers(0, 50))
def test_speed_1_is_the_clip_itself(seed):
    motion = random_motion(seed, joints=3, frames=12, fps=29.97)
    end = motion.duration
    same = retime(motion, [(0.0, 0.0), (end, end)], motion.frames, motion.fps)
    assert np.array_equal(same.rotations, motion.rotations)
    assert np.array_equal(same.translations, motion.translations)
    assert same.fps == motion.fps


@given(st.integers(0, 50))
def test_frames_of_the_source_are_shown_unchanged(seed):
    motion = wild(seed)
    slow = retime(motion, [(0.0, 0.0), (2 * motion.duration, motion.duration)], 2 * motion.frames - 1, motion.fps)
    assert np.array_equal(slow.rotations[::2], motion.rotations)
    assert np.array_equal(slow.translations[::2], motion.translations)
    fast = retime(slow, [(0.0, 0.0), (slow.duration / 2, slow.duration)], motion.frames, motion.fps)
    assert np.array_equal(fast.rotations, motion.rotations)


@given(st.integers(0, 50), st.floats(0.3, 0.99))
def test_slowed_down_and_back_again_passes_through_the_frames(seed, speed):
    motion = random_motion(seed, joints=3, frames=20)
    there = (motion.duration / speed, motion.duration)
    slow = retime(motion, [(0.0, 0.0), there], int(there[0] * motion.fps + 1e-6) + 1, motion.fps)
    ends = (slow.duration * speed, slow.duration)
    back = retime(slow, [(0.0, 0.0), ends], int(ends[0] * motion.fps + 1e-6) + 1, motion.fps)
    steps = quat_distance(motion.rotations[1:], motion.rotations[:-1]).max()
    assert quat_distance(back.rotations, motion.rotations[: back.frames]).max() < 0.1 * steps


@given(st.integers(0, 50), st.lists(st.floats(0, 8), min_size=1, max_size=20))
def test_time_runs_backwards_just_as_well(seed, places):
    motion = wild(seed)
    there = poses_at(motion, places)
    back = poses_at(backwards(motion), motion.frames - 1 - np.array(places))
    assert quat_distance(there.rotations, back.rotations).max() < 1e-7
    assert np.allclose(there.translations, back.translations, rtol=0, atol=1e-9)


def angular_velocity(motion: Motion, at: float, step: float = 1e-5) -> np.ndarray:
    q = poses_at(motion, [at, at + step]).rotations
    return quat_to_rotvec(quat_multiply(quat_conjugate(q[0]), q[1])) / step


@pytest.mark.parametrize("seed", range(5))
def test_velocity_is_that_of_both_neighbours_and_does_not_jump(seed):
    """Even where joints turn by up to half a turn from frame to frame."""
    motion = wild(seed)
    turns = quat_to_rotvec(quat_multiply(quat_conjugate(motion.rotations[:-1]), motion.rotations[1:]))
    moves = np.diff(motion.translations, axis=0)
    for frame in range(1, motion.frames - 1):
        mean = (turns[frame - 1] + turns[frame]) / 2
        assert np.allclose(angular_velocity(motion, frame - 2e-5), mean, atol=2e-3)
        assert np.allclose(angular_velocity(motion, frame + 1e-5), mean, atol=2e-3)
        near = poses_at(motion, [frame - 2e-5, frame - 1e-5, frame + 1e-5, frame + 2e-5]).translations
        for pair in (near[:2], near[2:]):
            assert np.allclose((pair[1] - pair[0]) / 1e-5, (moves[frame - 1] + moves[frame]) / 2, atol=1e-3)


def test_steady_turning_and_moving_is_told_exactly():
    frames = np.arange(8)[:, None]
    rotations = rotvec_to_quat(frames * np.array([[0.3, -0.5, 0.2]]))[:, None]
    translations = (frames * np.array([[0.1, 0.0, -0.2]]))[:, None]
    motion = replace(random_motion(0, joints=1, frames=8), rotations=rotations, translations=translations)
    places = np.linspace(0, 7, 40)
    found = poses_at(motion, places)
    assert quat_distance(found.rotations[:, 0], rotvec_to_quat(places[:, None] * [[0.3, -0.5, 0.2]])).max() < 1e-7
    assert np.allclose(found.translations[:, 0], places[:, None] * [[0.1, 0.0, -0.2]], rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", ["walk", "run", "kick"])
def test_slow_motion_is_nearer_the_truth_than_straight_lines_and_does_not_stutter(name):
    """The samples are functions of time: at 60 fps they say what a 30-fps clip ought to look like at half its speed."""
    coarse, fine = sample(name, fps=30.0), sample(name, fps=60.0)
    places = np.arange(2 * coarse.frames - 1) / 2
    ours = poses_at(coarse, places).rotations
    left = np.minimum(places.astype(int), coarse.frames - 2)
    lines = quat_slerp(coarse.rotations[left], coarse.rotations[left + 1], (places - left)[:, None])
    truth = fine.rotations[: len(places)]
    errors = [np.sqrt((quat_distance(found, truth) ** 2).mean()) for found in (ours, lines)]
    assert errors[0] < 0.5 * errors[1]
    bends = [_bends(found).max() / _bends(truth).max() for found in (ours, lines)]
    assert bends[0] < 1.2 < bends[1]


def _bends(rotations: np.ndarray) -> np.ndarray:
    turns = quat_to_rotvec(quat_multiply(quat_conjugate(rotations[:-1]), rotations[1:]))
    return np.linalg.norm(np.diff(turns, axis=0), axis=-1)


def test_one_frame_and_places_outside():
    one = random_motion(0, joints=2, frames=1)
    assert np.array_equal(poses_at(one, [0.0, 5.0]).rotations, one.rotations[[0, 0]])
    motion = random_motion(0, joints=2, frames=5)
    assert np.array_equal(poses_at(motion, [-3.0, 9.0]).rotations, motion.rotations[[0, 4]])


def test_refusals():
    motion = random_motion(0, joints=2, frames=5)
    with pytest.raises(ParameterError, match="fps"):
        retime(motion, [(0.0, 0.0), (1.0, 1.0)], 5, 0.0)
    with pytest.raises(ParameterError, match="joint poses"):
        retime(motion, [(0.0, 0.0), (1e9, 0.1)], 10**9, 30.0)
