"""Each sample is the action that its name says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.core.mirror import mirror
from kinestitch.core.rotation import quat_distance
from kinestitch.samples import sample
from kinestitch.samples.body import joint

MASSES = {
    ("Hips", "Neck"): (0.497, 0.5),
    ("Neck", "HeadTop_End"): (0.081, 0.6),
    ("Arm", "ForeArm"): (0.028, 0.436),
    ("ForeArm", "Hand"): (0.022, 0.682),
    ("UpLeg", "Leg"): (0.100, 0.433),
    ("Leg", "Foot"): (0.0465, 0.433),
    ("Foot", "ToeBase"): (0.0145, 0.5),
}
"""Share of the body's mass and place of its centre along each segment, after Winter."""


def centre_of_mass(seen) -> np.ndarray:
    total, weight = 0.0, 0.0
    for (start, end), (mass, place) in MASSES.items():
        for side in ("",) if start in ("Hips", "Neck") else ("Left", "Right"):
            total = total + mass * ((1 - place) * seen.at(side + start) + place * seen.at(side + end))
            weight += mass
    return total / weight


def yaw(seen, name: str) -> np.ndarray:
    across = seen.at(f"Left{name}") - seen.at(f"Right{name}")
    return np.degrees(np.arctan2(-across[:, 2], across[:, 0]))


@pytest.mark.parametrize(("name", "speed"), [("walk", 1.26), ("run", 3.0)])
def test_gaits_travel_straight_ahead(look, name, speed):
    seen = look(name)
    path = seen.at("Hips")
    assert (path[-1, 2] - path[0, 2]) / seen.motion.duration == pytest.approx(speed, rel=0.02)
    assert np.ptp(path[:, 0]) < 0.06
    assert 0.03 < np.ptp(path[:, 1]) < 0.09


@pytest.mark.parametrize(("name", "half"), [("walk", 30), ("run", 30)])
def test_gaits_are_their_own_mirror_half_a_cycle_later(name, half):
    """At 54 and 90 frames a second half a cycle is 30 frames."""
    motion = sample(name, fps=54.0 if name == "walk" else 90.0)
    other = mirror(motion)
    assert np.degrees(quat_distance(other.rotations[:-half], motion.rotations[half:])).max() < 1e-5
    moved = motion.translations[half:] - other.translations[:-half]
    assert np.abs(moved - moved[0]).max() < 1e-9
    assert moved[0, 0, 2] > 0.5


def test_walk_always_has_a_foot_down_and_run_has_not(look):
    def down(seen):
        return sum(seen.at(f"{side}ToeBase")[:, 1] < 0.045 for side in ("Left", "Right"))

    def heels(seen):
        return sum(seen.at(f"{side}Foot")[:, 1] < 0.085 for side in ("Left", "Right"))

    walk, run = look("walk"), look("run")
    assert (np.maximum(down(walk), heels(walk)) >= 1).all()
    assert 0.08 < ((down(run) == 0) & (heels(run) == 0)).mean() < 0.4


def test_walk_rolls_from_heel_to_toe(look):
    walk = look("walk")
    pitch = np.degrees(
        np.arcsin((walk.at("LeftToeBase") - walk.at("LeftFoot"))[:, 1] / np.linalg.norm([0.136, 0.022 - 0.06825]))
    )
    flat = pitch[walk.held("LeftFoot")].mean()
    assert pitch.max() - flat > 15.0
    assert pitch.min() - flat < -40.0


@pytest.mark.parametrize("name", ["walk", "run"])
def test_arms_swing_against_the_legs(look, name):
    seen = look(name)
    for side, other in (("Left", "Right"), ("Right", "Left")):
        hand = seen.at(f"{side}Hand")[:, 2] - seen.at("Hips")[:, 2]
        foot = seen.at(f"{other}Foot")[:, 2] - seen.at("Hips")[:, 2]
        assert np.corrcoef(hand, foot)[0, 1] > 0.75


def test_jump_flies_on_a_parabola(look):
    seen = look("jump", 120.0)
    height = seen.at("Hips")[:, 1]
    t = np.arange(seen.motion.frames) / 120.0
    air = (t > 0.965) & (t < 1.485)
    fall = np.diff(height, 2) * 120.0**2
    assert np.allclose(fall[(air[2:] & air[:-2])], -9.81, atol=1e-6)
    assert not (seen.held("LeftToeBase") | seen.held("RightToeBase"))[air].any()
    assert seen.at("LeftToe_End")[:, 1].max() > 0.25
    assert height.max() - height[0] > 0.35
    assert height[: np.argmax(height)].min() < 0.65
    assert seen.at("LeftHand")[np.argmax(height), 1] > seen.at("Head")[np.argmax(height), 1]


def test_jumping_jacks_open_hands_and_feet_together(look):
    seen = look("jumping_jacks")
    feet = seen.at("LeftFoot")[:, 0] - seen.at("RightFoot")[:, 0]
    hands = seen.at("LeftHand")[:, 1] - seen.at("Hips")[:, 1]
    assert np.corrcoef(feet, hands)[0, 1] > 0.9
    assert feet.max() > 0.55
    assert (seen.at("LeftHand")[:, 1] > seen.at("HeadTop_End")[:, 1]).any()
    middle = 0.5 * (feet.max() + feet.min())
    assert (np.diff((feet > middle).astype(int)) == 1).sum() == 3
    assert np.abs(mirror(seen.motion).rotations - seen.motion.rotations).max() < 1e-9


def test_kick_reaches_the_chest_and_returns(look):
    seen = look("kick")
    foot = seen.at("RightFoot")
    top = int(np.argmax(foot[:, 1]))
    assert foot[top, 1] > seen.at("Spine1")[top, 1] > seen.at("Hips")[top, 1]
    assert foot[top, 2] - seen.at("Hips")[top, 2] > 0.6
    knee = seen.bend("RightLeg")
    assert knee[top - 12 : top].max() > 110 > 60 > knee[top - 1 : top + 3].min()
    assert knee[top : top + 15].max() > 110
    assert seen.held("LeftFoot").all()
    assert np.linalg.norm(seen.positions[-1] - seen.positions[0], axis=-1).max() < 0.02


def test_kick_is_balanced_on_the_left_foot(look):
    seen = look("kick")
    knee_up = seen.at("RightLeg")[:, 1] > 0.7
    alone = ~seen.held("RightToeBase") & knee_up
    assert alone.sum() > 20
    centre = centre_of_mass(seen)[alone]
    assert np.abs(centre[:, 0] - seen.at("LeftFoot")[0, 0]).max() < 0.06
    assert (centre[:, 2] > seen.at("LeftFoot")[0, 2] - 0.05).all()
    assert (centre[:, 2] < seen.at("LeftToe_End")[0, 2]).all()


def test_heavy_punch_is_heavier_than_light_punch(look):
    heavy, light = look("heavy_punch"), look("light_punch")
    assert heavy.speed("RightHand").max() > 1.5 * light.speed("LeftHand").max() > 3.0
    for name in ("UpLeg", "Arm"):
        assert np.ptp(yaw(heavy, name)) > 3 * np.ptp(yaw(light, name))
    assert np.ptp(heavy.at("Hips")[:, 2]) > 2 * np.ptp(light.at("Hips")[:, 2])
    assert np.ptp(heavy.at("LeftFoot")[:, 2]) > 0.15
    assert light.held("LeftFoot").all()


def test_hips_turn_before_shoulders_before_fist(look):
    seen = look("heavy_punch", 240.0)
    turn = [int(np.argmax(np.diff(yaw(seen, name)))) for name in ("UpLeg", "Arm")]
    assert turn[0] < turn[1]
    assert np.argmax(seen.speed("RightHand")) > turn[0]


def test_idle_breathes_and_stands(look):
    seen = look("idle")
    for foot in ("LeftFoot", "RightFoot"):
        assert seen.held(foot).all()
    assert 0.05 < np.ptp(seen.at("Hips")[:, 0]) < 0.15
    assert max(seen.speed(name).max() for name in ("LeftHand", "RightHand", "Head")) < 0.25
    again = replace(seen.motion, rotations=np.roll(seen.motion.rotations, 1, axis=0))
    assert np.degrees(quat_distance(again.rotations[0], again.rotations[1])).max() < 0.5


def test_standing_clips_keep_their_weight_over_the_feet(look):
    for name in ("idle", "light_punch", "jumping_jacks"):
        seen = look(name)
        centre = centre_of_mass(seen)
        feet = np.stack([seen.at(f) for f in ("LeftFoot", "RightFoot", "LeftToe_End", "RightToe_End")])
        low, high = feet.min(axis=0), feet.max(axis=0)
        assert (centre[:, [0, 2]] > low[:, [0, 2]] - 0.06).all()
        assert (centre[:, [0, 2]] < high[:, [0, 2]] + 0.06).all()


def test_the_chest_faces_where_the_clip_goes(look):
    for name in ("walk", "run", "jump", "jumping_jacks", "idle"):
        world = world_pose(look(name).motion).rotations[:, joint("Spine2")]
        assert np.abs(world[:, 1]).max() < np.sin(np.radians(15))
