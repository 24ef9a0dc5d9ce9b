"""Continuity of rotation vectors on movements whose values are known."""

from __future__ import annotations

import numpy as np
import pytest

from kinestitch.analysis import continuity as c
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_distance, quat_multiply, quat_normalize, rotvec_to_quat
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError

REST = quat_normalize(np.array([[0.1, 0.2, 0.3, 1.0], [0.5, -0.2, 0.1, 0.4]]))
RIG = Skeleton(("Hips", "Arm"), (-1, 0), [[0, 1, 0], [0, 0.3, 0]], REST)


def turning(vectors: np.ndarray) -> Motion:
    """Hips at rest, an arm turned from its rest pose by (F, 3) rad."""
    rotations = np.broadcast_to(REST, (len(vectors), 2, 4)).copy()
    rotations[:, 1] = quat_multiply(REST[1], rotvec_to_quat(vectors))
    return Motion(RIG, np.broadcast_to(RIG.offsets, (len(vectors), 2, 3)), rotations, 30.0)


def about_x(angles: np.ndarray) -> Motion:
    return turning(np.stack([angles, 0 * angles, 0 * angles], axis=-1))


def test_vectors_are_told_from_the_rest_pose():
    vectors = np.random.default_rng(0).normal(size=(20, 3))
    found = c.principal_vectors(turning(vectors))
    np.testing.assert_allclose(found[:, 1], vectors, atol=1e-12)
    np.testing.assert_allclose(found[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(c.angles(turning(vectors))[:, 1], np.linalg.norm(vectors, axis=1), atol=1e-12)


def test_a_turn_about_one_axis_is_continuous_and_a_joint_at_rest_has_no_axis():
    values = c.axis_continuity(about_x(np.linspace(0.1, 3.0, 50)))
    assert len(values) == 49
    np.testing.assert_allclose(values, 1.0, atol=1e-12)


def test_a_sine_through_zero_turns_its_axis_round_and_crosses_nothing():
    """Three periods pass zero five times inside; u · u' is −1 there and +1 elsewhere."""
    motion = about_x(np.sin(np.linspace(0, 6 * np.pi, 301) + 0.03))
    found = c.continuity([c.clip_steps(motion)])
    assert found.share_flipped * found.values == pytest.approx(5, abs=1)
    assert found.crossings == 0
    assert found.largest_angle == pytest.approx(1.0, abs=1e-3)


def test_a_constant_turn_crosses_once_in_each_whole_turn():
    """Three and a quarter turns pass π three times; there u · u' is −1, as where they pass zero."""
    motion = about_x(np.linspace(0.05, 0.05 + 6.5 * np.pi, 400))
    assert c.branch_crossings(motion) == 3
    steps = c.clip_steps(motion)
    assert int(steps.flips.sum()) == 6
    assert steps.theta[steps.crossings].min() > np.pi - 0.1


def test_the_threshold_decides_what_has_an_axis():
    motion = about_x(np.full(10, 5e-4))
    assert len(c.axis_continuity(motion)) == 0
    assert len(c.axis_continuity(motion, threshold=1e-4)) == 9
    with pytest.raises(ParameterError, match="threshold"):
        c.axis_continuity(motion, threshold=0.0)


def test_an_axis_that_turns_by_a_known_angle():
    angle = np.arange(40) * 0.1
    motion = turning(np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1))
    np.testing.assert_allclose(c.axis_continuity(motion), np.cos(0.1), atol=1e-12)


def test_boundaries_of_known_clips():
    """Ends and starts: x→y are at right angles, y→x opposite."""
    x = turning(np.array([[-1.0, 0, 0], [1.0, 0, 0]]))
    y = turning(np.array([[0, 1.0, 0], [2.0, 0, 0]]))
    steps = c.end_to_start({"x": x, "y": y})
    np.testing.assert_allclose(steps.values, [0.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(steps.jumps[:, 1], [np.sqrt(2), 3.0])
    found = c.continuity([steps])
    assert (found.values, found.joint_steps, found.crossings) == (2, 4, 0)
    assert (found.share_above_half, found.share_flipped) == (0.0, 0.5)


def test_random_boundaries_are_repeatable_and_join_different_clips():
    clips = {"x": turning(np.tile([1.0, 0, 0], (5, 1))), "y": turning(np.tile([0, 1.0, 0], (9, 1)))}
    steps = [c.random_boundaries(clips, 50, np.random.default_rng(1)) for _ in range(2)]
    np.testing.assert_array_equal(steps[0].products, steps[1].products)
    np.testing.assert_allclose(steps[0].values, 0.0, atol=1e-12)


def test_a_flipped_vector_is_the_same_rotation():
    vectors = np.random.default_rng(2).normal(size=(50, 3))
    flipped = c.flip(vectors)
    assert quat_distance(rotvec_to_quat(vectors), rotvec_to_quat(flipped)).max() < 1e-12
    np.testing.assert_allclose(np.linalg.norm(flipped, axis=1), 2 * np.pi - np.linalg.norm(vectors, axis=1))
    np.testing.assert_allclose(c.flip(flipped), vectors, atol=1e-12)
    np.testing.assert_array_equal(c.flip(np.zeros((1, 3))), np.zeros((1, 3)))


def test_nothing_to_sum_up():
    found = c.continuity([])
    assert (found.values, found.joint_steps, found.crossings, found.largest_angle) == (0, 0, 0, 0.0)
    still = Motion(RIG, RIG.offsets[None], quat_multiply(REST, quat_about_axis(0, np.zeros(2)))[None], 30.0)
    assert c.continuity([c.clip_steps(still)]).values == 0
