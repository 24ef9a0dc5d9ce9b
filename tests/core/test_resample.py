"""Other frame rates for the same movement: exact where they are equal, on the geodesic between frames where not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.core.resample import resample, resampled_bound, resampled_frames, same_rate
from kinestitch.core.rotation import quat_distance, quat_slerp
from kinestitch.errors import ParameterError
from kinestitch.testing import check_motion, random_motion

RATES = st.sampled_from([1.0, 10.0, 23.976, 24.0, 25.0, 29.97, 30.0, 59.94, 60.0, 100.0, 120.0, 1000.0])


def test_equal_rates_touch_nothing():
    motion = random_motion(0, fps=30.0)
    assert resample(motion, 30.0) is motion
    written = random_motion(0, fps=1 / 0.0333333)
    near = resample(written, 30.0)
    assert near.fps == 30.0
    assert near.rotations is written.rotations
    assert near.translations is written.translations


@pytest.mark.parametrize(
    ("a", "b", "same"),
    [
        (30.0, 1 / 0.0333333, True),
        (120.0, 1 / 0.0083333, True),
        (1 / 0.008333, 120.0, True),
        (30.0, 29.97, False),
        (60.0, 59.94, False),
        (24.0, 23.976, False),
    ],
)
def test_which_rates_are_equal(a: float, b: float, same: bool):
    assert same_rate(a, b) is same
    assert same_rate(b, a) is same


@pytest.mark.parametrize("up", [2, 3, 4, 5, 8])
def test_up_and_down_again_is_the_same_motion(up: int):
    motion = random_motion(2, frames=37, fps=30.0, bend=2.0)
    dense = resample(motion, 30.0 * up)
    assert dense.frames == 36 * up + 1
    check_motion(dense)
    back = resample(dense, 30.0)
    np.testing.assert_array_equal(back.rotations, motion.rotations)
    np.testing.assert_array_equal(back.translations, motion.translations)


def test_half_way_is_the_middle_of_the_geodesic():
    motion = random_motion(3, frames=11, fps=30.0, bend=3.0)
    dense = resample(motion, 60.0)
    np.testing.assert_array_equal(dense.rotations[::2], motion.rotations)
    middle = quat_slerp(motion.rotations[:-1], motion.rotations[1:], 0.5)
    assert quat_distance(dense.rotations[1::2], middle).max() < 1e-14
    np.testing.assert_allclose(
        dense.translations[1::2], (motion.translations[:-1] + motion.translations[1:]) / 2, rtol=0, atol=1e-15
    )


def test_down_takes_every_second_frame():
    motion = random_motion(4, frames=10, fps=60.0)
    half = resample(motion, 30.0)
    assert half.frames == 5
    np.testing.assert_array_equal(half.rotations, motion.rotations[::2])
    np.testing.assert_array_equal(half.translations, motion.translations[::2])


@given(st.integers(1, 5000), RATES, RATES)
def test_frame_count_covers_the_duration(frames: int, fps: float, new: float):
    count = resampled_frames(frames, fps, new)
    if same_rate(fps, new):
        assert count == frames
        return
    assert count >= 1
    assert (count - 1) / new <= (frames - 1) / fps + 2e-6 / new
    assert count / new > (frames - 1) / fps


@given(st.integers(1, 60), RATES, RATES)
def test_every_frame_stands_at_its_time(frames: int, fps: float, new: float):
    motion = random_motion(5, joints=2, frames=frames, fps=fps, bend=2.0)
    out = resample(motion, new)
    assert out.frames == resampled_frames(frames, fps, new)
    check_motion(out)
    if same_rate(fps, new):
        return
    for k in {0, out.frames // 2, out.frames - 1}:
        place = min(k * fps / new, frames - 1.0)
        left = min(int(place), frames - 1)
        right = min(left + 1, frames - 1)
        pose = quat_slerp(motion.rotations[left], motion.rotations[right], np.full(2, place - left))
        assert quat_distance(out.rotations[k], pose).max() < 1e-4


@pytest.mark.parametrize(
    ("bound", "expected"), [(0, 0), (1, 1), (2, 1), (3, 2), (4, 2), (5, 3), (10, 5), (11, 6), (12, 6)]
)
def test_bounds_round_to_the_nearest_frame_halves_up(bound: int, expected: int):
    assert resampled_bound(bound, 12, 60.0, 30.0) == expected


def test_bounds_stay_inside_the_new_clip():
    assert resampled_frames(11, 60.0, 30.0) == 6
    assert resampled_bound(11, 11, 60.0, 30.0) == 6
    assert resampled_bound(10, 10, 30.0, 60.0) == 19
    assert resampled_bound(7, 11, 30.0, 1 / 0.0333333) == 7


def test_one_frame_stays_one_frame():
    motion = random_motion(6, frames=1, fps=30.0)
    for fps in (1.0, 24.0, 240.0):
        out = resample(motion, fps)
        assert (out.frames, out.fps) == (1, fps)
        np.testing.assert_array_equal(out.rotations, motion.rotations)


@pytest.mark.parametrize("fps", [0, -30.0, np.nan, np.inf])
def test_impossible_rates_are_refused(fps: float):
    with pytest.raises(ParameterError, match="Expected fps > 0"):
        resample(random_motion(0), fps)


def test_a_rate_that_fills_the_memory_is_refused():
    with pytest.raises(ParameterError, match="at most 50,000,000 joint poses, got 1e"):
        resample(random_motion(0, frames=100), 1e9)
