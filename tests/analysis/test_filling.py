"""The LAFAN1 measures on motions whose values are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.analysis import filling
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_multiply
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import SkeletonMismatchError
from kinestitch.testing import random_motion

RIG = Skeleton(("Hips", "Arm"), (-1, 0), [[0, 1, 0], [0, 0.3, 0]])


def turning(angles: np.ndarray) -> Motion:
    rotations = np.zeros((len(angles), 2, 4))
    rotations[..., 3] = 1.0
    rotations[:, 1] = quat_about_axis(0, angles)
    return Motion(RIG, np.broadcast_to(RIG.offsets, (len(angles), 2, 3)), rotations, 30.0)


def test_the_truth_has_no_error_whatever_the_signs_of_its_quaternions():
    truth = random_motion(0, frames=60)
    signs = np.where(np.arange(60) % 3 == 0, -1.0, 1.0)[:, None, None]
    same = replace(truth, rotations=signs * truth.rotations)
    assert filling.global_quaternion_error(same, truth) == pytest.approx(0.0, abs=1e-9)
    assert filling.global_position_error(same, truth, *filling.normalisation(truth)) == pytest.approx(0.0, abs=1e-9)
    assert filling.power_spectrum_distance(same, truth) == pytest.approx(0.0, abs=1e-9)


def test_a_constant_turn_between_two_motions():
    """Quaternions that are φ apart differ by 2 sin(φ/4); one joint turns, the other does not."""
    found = filling.global_quaternion_error(turning(np.full(20, 0.8)), turning(np.zeros(20)))
    assert found == pytest.approx(2 * np.sin(0.2))
    all_turned = turning(np.zeros(20))
    body = np.broadcast_to(quat_about_axis(1, np.array(0.8)), (20, 4))
    rotations = all_turned.rotations.copy()
    rotations[:, 0] = quat_multiply(body, rotations[:, 0])
    found = filling.global_quaternion_error(replace(all_turned, rotations=rotations), turning(np.zeros(20)))
    assert found == pytest.approx(np.sqrt(2) * 2 * np.sin(0.2))


def test_a_body_moved_by_one_deviation_is_off_by_the_root_of_its_joints():
    truth = turning(np.zeros(20))
    moved = truth.translations.copy()
    moved[:, 0, 0] += 0.25
    found = filling.global_position_error(
        replace(truth, translations=moved), truth, np.zeros((2, 3)), np.full((2, 3), 0.25)
    )
    assert found == pytest.approx(np.sqrt(2))


def test_normalisation_is_mean_and_deviation_over_all_frames():
    motions = [random_motion(seed, frames=30) for seed in range(2)]
    mean, deviation = filling.normalisation(*motions)
    assert mean.shape == deviation.shape == (4, 3)
    apart = filling.global_position_error(motions[0], motions[1], mean, deviation)
    assert 0.5 < apart < 10


def test_power_moved_by_some_frequencies():
    """All power at frequency 3, and at 5: the earth mover's distance is 2 on either half of the spectrum."""
    phase = 2 * np.pi * np.arange(64) / 64
    small = 1e-4  # so small that quaternions are linear in the angle
    slow, fast = turning(small * np.cos(3 * phase)), turning(small * np.cos(5 * phase))
    found = filling.power_spectrum_distance(fast, slow)
    waves, constant = 2 * (small / 2 * 32) ** 2, 2 * 64**2  # real parts, squared; both joints' w hardly moves
    assert found == pytest.approx(2 * waves / constant, rel=1e-6)


def test_other_lengths_and_rigs_are_refused():
    for other in (turning(np.zeros(19)), random_motion(0, frames=20)):
        with pytest.raises(SkeletonMismatchError, match="frames of the truth"):
            filling.global_quaternion_error(other, turning(np.zeros(20)))
