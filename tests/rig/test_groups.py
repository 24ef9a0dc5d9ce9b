"""Trunk, arms and legs: every joint once, and a body alone where nobody can tell."""

from __future__ import annotations

import pytest

import kinestitch as ks
from kinestitch.rig.groups import BODY, joint_groups
from kinestitch.samples import SAMPLE_NAMES
from kinestitch.testing import random_motion

PARTS = [BODY, "left_arm", "left_leg", "right_arm", "right_leg"]


@pytest.mark.parametrize("skeleton", [ks.sample(SAMPLE_NAMES[0]).skeleton, random_motion(0, joints=7).skeleton])
def test_every_joint_is_in_one_group_with_what_hangs_on_it(skeleton: ks.Skeleton):
    groups = joint_groups(skeleton)
    assert sorted(joint for joints in groups.values() for joint in joints) == list(range(skeleton.joint_count))
    owner = {joint: name for name, joints in groups.items() for joint in joints}
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0 and owner[parent] != BODY:
            assert owner[joint] == owner[parent]


def test_a_body_has_two_arms_and_two_legs():
    skeleton = ks.sample("walk").skeleton
    groups = joint_groups(skeleton)
    assert list(groups) == PARTS
    named = {name: {skeleton.names[j].removeprefix("mixamorig:") for j in joints} for name, joints in groups.items()}
    assert {"Hips", "Spine", "Head"} <= named[BODY]
    assert {"LeftShoulder", "LeftHand"} <= named["left_arm"]
    assert {"RightUpLeg", "RightToeBase"} <= named["right_leg"]
    assert all("Left" in name for part in ("left_arm", "left_leg") for name in named[part])


def test_a_rig_without_known_limbs_is_body_alone():
    assert list(joint_groups(random_motion(0, joints=6).skeleton)) == [BODY]
