"""Names of every family tell the roles; what hangs in the wrong place plays none."""

from __future__ import annotations

import numpy as np
import pytest
from rig_builders import below_a_dummy, renamed

import kinestitch as ks
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import FAMILIES, MAIN_ROLES
from kinestitch.rig.roles import roles_of

TRUNK = ("hips", "spine_1", "spine_2", "spine_3", "neck_1", "head")
LIMBS = ("shoulder", "upper_arm", "lower_arm", "hand", "upper_leg", "lower_leg", "foot", "toe")


def names(trunk: str, left: str, right: str) -> dict[str, str]:
    told = dict(zip(TRUNK, trunk.split(), strict=True))
    for side, limbs in (("left", left), ("right", right)):
        told |= {f"{side}_{part}": name for part, name in zip(LIMBS, limbs.split(), strict=True)}
    return told


def sided(form: str, parts: str, left: str, right: str) -> tuple[str, str]:
    return tuple(" ".join(form.format(side=side, part=part) for part in parts.split()) for side in (left, right))  # type: ignore[return-value]


WAYS = {
    "Mixamo": names(
        "Hips Spine Spine1 Spine2 Neck Head",
        *sided("mixamorig8:{side}{part}", "Shoulder Arm ForeArm Hand UpLeg Leg Foot ToeBase", "Left", "Right"),
    ),
    "CMU": names(
        "root lowerback upperback thorax lowerneck head",
        *sided("{side}{part}", "clavicle humerus radius wrist femur tibia foot toes", "l", "r"),
    ),
    "Bandai-Namco": names(
        "Hips Spine Middle Chest Neck Head",
        *sided("{part}_{side}", "Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot Toes", "L", "R"),
    ),
    "Biovision": names(
        "Hips Chest Chest2 Chest3 Neck Head",
        *sided("{side}{part}", "Collar Shoulder Elbow Wrist Hip Knee Ankle Toe", "Left", "Right"),
    ),
    "SMPL": names(
        "Pelvis Spine1 Spine2 Spine3 Neck Head",
        *sided("{side}_{part}", "Collar Shoulder Elbow Wrist Hip Knee Ankle Foot", "L", "R"),
    ),
    "Unreal": names(
        "pelvis spine_01 spine_02 spine_03 neck_01 head",
        *sided("{part}_{side}", "clavicle upperarm lowerarm hand thigh calf foot ball", "l", "r"),
    ),
    "Unity": names(
        "Hips Spine Chest UpperChest Neck Head",
        *sided(
            "{side} {part}".replace(" ", "."),
            "Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot Toes",
            "Left",
            "Right",
        ),
    ),
    "VRM": names(
        "J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_Chest J_Bip_C_UpperChest J_Bip_C_Neck J_Bip_C_Head",
        *sided("J_Bip_{side}_{part}", "Shoulder UpperArm LowerArm Hand UpperLeg LowerLeg Foot ToeBase", "L", "R"),
    ),
    "Rokoko": names(
        "Hips Spine1 Spine2 Spine3 Neck Head",
        *sided("{side}{part}", "Shoulder Arm ForeArm Hand Thigh Shin Foot Toe", "Left", "Right"),
    ),
    "Xsens": names(
        "Pelvis L5 L3 T8 Neck Head",
        *sided("{side}{part}", "Shoulder UpperArm Forearm Hand UpperLeg LowerLeg Foot Toe", "Right", "Left")[::-1],
    ),
    "Biped": names(
        "Bip01_Pelvis Bip01_Spine Bip01_Spine1 Bip01_Spine2 Bip01_Neck Bip01_Head",
        *sided("Bip01_{side}_{part}", "Clavicle UpperArm Forearm Hand Thigh Calf Foot Toe0", "L", "R"),
    ),
    "generic": names(
        "hips abdomen torso chest neck head",
        *sided("{side}{part}", "Collar UpperArm ForeArm Palm Thigh Shin Foot Toes", "l", "r"),
    ),
}


@pytest.mark.parametrize("family", WAYS)
def test_every_family_is_understood(family):
    skeleton = renamed(ks.sample("idle"), WAYS[family], keep=False).skeleton
    roles = roles_of(skeleton)
    assert roles.missing == ()
    assert roles.family == family
    assert {role: skeleton.names[joint] for role, joint in roles.joints.items()} == WAYS[family]
    assert roles.chain("spine") == (1, 2, 3)


def test_every_family_has_an_example():
    assert set(WAYS) == {family.name for family in FAMILIES}
    assert set(MAIN_ROLES) <= set(WAYS["CMU"])


def test_fingers_are_counted_from_the_palm():
    roles = roles_of(ks.sample("idle").skeleton).joints
    assert [f"left_middle_{n}" in roles for n in range(6)] == [False, True, True, True, True, False]


def test_a_dummy_above_the_hips_plays_no_role():
    motion = below_a_dummy(ks.sample("idle"), "root")
    assert roles_of(motion.skeleton).joints["hips"] == 1
    assert 0 not in roles_of(motion.skeleton).joints.values()


def test_joints_in_the_wrong_place_are_left_out():
    """A foot that hangs on the root is an IK target; the leg above it is understood as far as the knee."""
    skeleton = ks.sample("idle").skeleton
    parents = list(skeleton.parents)
    foot = skeleton.index("mixamorig:LeftFoot")
    parents[foot] = 0
    roles = roles_of(Skeleton(skeleton.names, tuple(parents), skeleton.offsets))
    assert roles.missing == ("left_foot",)
    assert "left_lower_leg" in roles.joints
    assert "left_toe" not in roles.joints


def test_other_bodies_are_not_understood():
    worm = Skeleton(("Hips", "A", "B"), (-1, 0, 1), np.ones((3, 3)))
    assert set(roles_of(worm).missing) == set(MAIN_ROLES) - {"hips"}
