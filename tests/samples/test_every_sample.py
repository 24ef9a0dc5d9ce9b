"""What all eight samples promise: one body, the same numbers every time, the same movement at every rate, no pops."""

from __future__ import annotations

import hashlib
import subprocess
import sys

import numpy as np
import pytest

from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.core.mirror import mirror_pairs
from kinestitch.errors import ParameterError
from kinestitch.samples import SAMPLE_NAMES, humanoid, sample, sample_contacts
from kinestitch.samples.body import HEIGHT, joint
from kinestitch.testing import check_motion


def test_names_and_lengths(seen):
    check_motion(seen.motion)
    assert seen.motion.name in SAMPLE_NAMES
    assert 60 <= seen.motion.frames <= 241
    assert 2.0 <= seen.motion.duration <= 4.0
    assert seen.motion.skeleton == humanoid()


def test_the_body_is_a_person_in_t_pose():
    body = humanoid()
    positions, rotations = rest_pose(body)
    assert body.joint_count >= 22
    assert all(name.startswith("mixamorig:") for name in body.names)
    assert np.array_equal(rotations, np.tile([0.0, 0, 0, 1], (body.joint_count, 1)))
    assert positions[joint("HeadTop_End"), 1] == pytest.approx(HEIGHT)
    assert positions[joint("LeftUpLeg"), 1] == pytest.approx(0.530 * HEIGHT)
    assert positions[joint("LeftArm"), 1] == pytest.approx(positions[joint("LeftHand"), 1])
    assert positions[joint("LeftArm"), 1] == pytest.approx(0.818 * HEIGHT)
    assert positions[joint("LeftHand"), 0] > positions[joint("LeftArm"), 0] > 0
    assert positions[joint("LeftToe_End"), 2] > 0.1
    across = positions[list(mirror_pairs(body))] * [-1, 1, 1]
    assert np.allclose(across, positions, atol=1e-15)


def test_bones_keep_their_length(seen):
    assert np.array_equal(
        seen.motion.translations[:, 1:], np.broadcast_to(humanoid().offsets[1:], seen.motion.translations[:, 1:].shape)
    )


def test_the_same_numbers_in_another_process():
    def digest() -> str:
        return hashlib.sha256(sample("kick").rotations.tobytes()).hexdigest()

    script = (
        "import hashlib; from kinestitch.samples import sample; "
        "print(hashlib.sha256(sample('kick').rotations.tobytes()).hexdigest())"
    )
    other = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == digest() == digest()


@pytest.mark.parametrize("fps", [24.0, 30.0, 120.0])
def test_another_rate_is_the_same_movement(seen, fps):
    other = sample(seen.motion.name, fps=fps)
    assert other.fps == fps
    assert other.duration == pytest.approx(seen.motion.duration, abs=1e-9)
    common = sample(seen.motion.name, fps=120.0)
    step = round(120 / fps)
    assert np.abs(other.rotations - common.rotations[::step]).max() < 1e-9
    assert np.abs(other.translations - common.translations[::step]).max() < 1e-9


def test_no_pops(seen):
    """Accelerations stay what they are when time is cut four times finer, so that positions have no kinks."""
    fine = world_pose(sample(seen.motion.name, fps=240.0)).positions
    acceleration = np.linalg.norm(np.diff(seen.positions, 2, axis=0), axis=-1).max() * 60**2
    finer = np.linalg.norm(np.diff(fine, 2, axis=0), axis=-1).max() * 240**2
    assert finer < 1.35 * acceleration
    assert finer < 300.0


def test_clips_without_travel_start_and_end_at_rest(seen):
    if seen.motion.name in ("walk", "run"):
        assert seen.at("Hips")[-1, 2] - seen.at("Hips")[0, 2] > 1.2 * seen.motion.duration
        return
    assert np.linalg.norm(np.diff(seen.positions, axis=0), axis=-1)[[0, -1]].max() * 60 < 0.7


def test_knees_and_elbows_bend_one_way(seen):
    for side in ("Left", "Right"):
        assert seen.bend(f"{side}Leg").min() > 10.0
        assert seen.bend(f"{side}Leg").max() < 145.0
        elbow = seen.motion.rotations[:, joint(f"{side}ForeArm")]
        hinge = 2 * np.degrees(np.arctan2(elbow[:, 1], elbow[:, 3])) * (-1 if side == "Left" else 1)
        assert 0 < hinge.min() < hinge.max() < 150.0


def test_legs_are_never_stretched_out(seen):
    for side in ("Left", "Right"):
        length = np.linalg.norm(seen.at(f"{side}Foot") - seen.at(f"{side}UpLeg"), axis=1)
        assert length.max() < 0.99 * (0.245 + 0.246) * HEIGHT


def test_arms_stay_out_of_the_trunk(seen):
    """Wrist and elbow keep their distance from the line from hips to neck."""
    low, high = seen.at("Hips"), seen.at("Neck")
    for name in ("LeftHand", "RightHand", "LeftForeArm", "RightForeArm"):
        share = np.einsum("fi,fi->f", seen.at(name) - low, high - low) / np.einsum("fi,fi->f", high - low, high - low)
        nearest = low + np.clip(share, 0, 1)[:, None] * (high - low)
        assert np.linalg.norm(seen.at(name) - nearest, axis=1).min() > 0.12


def test_the_head_is_steady(seen):
    """The head turns slower than the chest hurries: never faster than 250 degrees a second."""
    world = world_pose(seen.motion).rotations[:, joint("Head")]
    turn = 2 * np.arccos(np.clip(np.abs(np.einsum("fi,fi->f", world[1:], world[:-1])), 0, 1))
    assert np.degrees(turn.max()) * 60 < 250.0


@pytest.mark.parametrize("verb", [sample, sample_contacts])
def test_unknown_names_and_rates(verb):
    with pytest.raises(ParameterError, match="walk, run, jump, jumping_jacks, kick, light_punch, heavy_punch, idle"):
        verb("moonwalk")
    for fps in (0.0, -30.0, float("nan")):
        with pytest.raises(ParameterError, match="fps > 0"):
            verb("walk", fps=fps)
