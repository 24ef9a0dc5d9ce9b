"""The body that is drawn around a skeleton, and the camera that looks at it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.kinematics import turn_about_up
from kinestitch.core.skeleton import Skeleton
from kinestitch.render.mannequin import anchor, bones, hull, joint_positions, mannequin, soles, with_tips
from kinestitch.render.view import facing, view_of
from kinestitch.samples import humanoid, sample


def test_the_humanoid_has_two_arms_two_legs_a_trunk_a_neck_and_a_head():
    body = humanoid()
    parts = mannequin(body)
    ends = {body.names[part.joints[-1]].removeprefix("mixamorig:"): part for part in parts if len(part.joints) == 2}
    for name in ("ForeArm", "Hand", "HandMiddle4", "Leg", "Foot", "Toe_End"):
        for side in ("Left", "Right"):
            assert ends[side + name].side == side.lower()
    assert ends["HeadTop_End"].radii[0] < 0  # a ball
    assert ends["Head"].side == "torso"
    assert sum(len(part.joints) > 2 for part in parts) == 2
    assert "LeftArm" not in ends  # collar bones lie inside the trunk


def test_a_dummy_root_is_not_drawn():
    body = humanoid()
    names = ("Dummy", *body.names)
    lifted = Skeleton(names, (-1, *(p + 1 for p in body.parents)), np.concatenate([[[0, 0, 0]], body.offsets]))
    assert anchor(body) == 0
    assert anchor(lifted) == 1
    assert not any(0 in part.joints for part in mannequin(lifted))
    assert len(mannequin(lifted)) == len(mannequin(body))


def test_tips_become_ends():
    motion = sample("idle")
    tips = np.full((motion.skeleton.joint_count, 3), np.nan)
    toe = motion.skeleton.index("mixamorig:LeftToe_End")
    tips[toe] = [0, 0, 0.03]
    tipped = replace(motion, skeleton=replace(motion.skeleton, tips=tips))
    assert with_tips(tipped.skeleton).names[-1] == "mixamorig:LeftToe_End_tip"
    positions = joint_positions(tipped)
    assert positions.shape[1] == motion.skeleton.joint_count + 1
    assert np.allclose(np.linalg.norm(positions[:, -1] - positions[:, toe], axis=-1), 0.03)


@pytest.mark.parametrize("turn", [0.0, 1.0, -2.5])
def test_the_camera_turns_with_the_body(turn):
    motion = turn_about_up(sample("walk"), turn)
    positions = joint_positions(motion)
    forward = facing(motion.skeleton, positions)
    assert np.allclose(forward, [np.sin(turn), 0, np.cos(turn)], atol=0.03)
    side = view_of(forward, "side").project(positions)
    travelled = side[-1, 0] - side[0, 0]
    assert travelled[0] == pytest.approx(4.2, abs=0.05)  # walks to the right
    left, right = (motion.skeleton.index(f"mixamorig:{s}UpLeg") for s in ("Left", "Right"))
    assert (side[:, right, 2] > side[:, left, 2]).all()  # the right leg is the nearer one
    front = view_of(forward, "front").project(positions)
    assert (front[:, left, 0] > front[:, right, 0]).all()  # and from the front it is on our left


def test_views_are_right_handed_and_orthonormal():
    for view in ("front", "side", "three-quarter", "back", 17.0, -200.0):
        camera = view_of(np.array([0.6, 0.0, 0.8]), view)
        axes = np.stack([camera.right, camera.up, camera.toward])
        assert np.allclose(axes @ axes.T, np.eye(3))
        assert np.linalg.det(axes) == pytest.approx(1.0)
        assert camera.up[1] > 0.9


def test_hull_of_a_square_with_points_inside_and_on_its_edge():
    points = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [1, 1], [1, 0], [0, 0]], dtype=float)
    assert {tuple(p) for p in hull(points)} == {(0, 0), (2, 0), (2, 2), (0, 2)}
    assert hull(np.zeros((5, 2))).shape == (1, 2)


def test_a_bare_skeleton_has_every_bone_and_joint_once():
    body = humanoid()
    parts = bones(body)
    rods = [part.joints for part in parts if len(part.joints) == 2]
    assert sorted(rods) == sorted((parent, joint) for joint, parent in enumerate(body.parents) if parent >= 0)
    assert sorted(part.joints for part in parts if len(part.joints) == 1) == [(j,) for j in range(body.joint_count)]
    sides = {body.names[part.joints[-1]]: part.side for part in parts}
    assert (sides["mixamorig:LeftFoot"], sides["mixamorig:RightHand"]) == ("left", "right")
    assert sides["mixamorig:Spine"] == "torso"


@pytest.mark.parametrize("figure", [mannequin, bones])
def test_a_foot_is_shown_by_what_begins_at_its_joint(figure):
    body = with_tips(humanoid())
    parts = figure(body)
    foot, toe = body.index("mixamorig:LeftFoot"), body.index("mixamorig:LeftToeBase")
    assert (foot, toe) in {parts[number].joints for number in soles(parts, foot)}
    assert all(parts[number].joints[0] == foot for number in soles(parts, foot))
    last = max(j for j in range(body.joint_count) if toe in body.chain(j))
    ends = {parts[number].joints for number in soles(parts, last)}
    assert (body.parents[last], last) in ends
