"""Real clips: as their source retargeted them, and between families; the figures stand in docs/retargeting.md."""

from __future__ import annotations

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.core.kinematics import world_pose
from kinestitch.errors import KinestitchWarning, SkeletonMismatchError
from kinestitch.experiments.retargeting import METHODS, aligned, direction_errors
from kinestitch.rig.retarget import retargeted
from kinestitch.rig.roles import roles_of
from kinestitch.testing import assert_motion_close, check_motion

XBOT = "mixamo_xbot_60fps/Idle.fbx"
UNREAL = "ue_mannequin/MCU_am_OrcHammer_Loco_Walk_Fwd.FBX"
UNDERSTOOD = [
    (XBOT, "Mixamo"),
    ("mixamo_prefix8/walking.fbx", "Mixamo"),
    ("mixamo_other_rigs/readyplayerme_Punching.fbx", "Mixamo"),
    ("mixamo_other_rigs/zombie_walk.fbx", "Mixamo"),
    ("mixamo_skinned/Soldier.glb", "Mixamo"),
    (UNREAL, "Unreal"),
    ("cmu/02_01.bvh", "CMU"),
    ("cmu/16_15.bvh", "CMU"),
    ("cmu/131_01.bvh", "Biovision"),
    ("bandai/dataset-1_walk_normal_001.bvh", "Bandai-Namco"),
    ("gltf/Knight.glb", "Bandai-Namco"),
]
PAIRS = [
    ("bandai/dataset-1_walk_normal_001.bvh", XBOT),
    ("bandai/dataset-1_kick_normal_001.bvh", XBOT),
    ("cmu/02_01.bvh", XBOT),
    ("cmu/131_01.bvh", XBOT),
    ("cmu/16_15.bvh", XBOT),
    ("mixamo_xbot_60fps/Kicking.fbx", UNREAL),
    ("mixamo_xbot_60fps/Walking.fbx", "bandai/dataset-1_walk_normal_001.bvh"),
    (UNREAL, XBOT),
]
LIMBS = ("upper arm", "forearm", "thigh", "shin")


@pytest.mark.parametrize(("clip", "family"), UNDERSTOOD)
def test_rigs_are_understood(real_clip, clip, family):
    roles = roles_of(real_clip(clip).skeleton)
    assert roles.missing == ()
    assert roles.family == family


@pytest.mark.parametrize("clip", ["gltf/Fox.glb", "mixamo_skinned/RobotExpressive.glb", "cmu/arm.bvh"])
def test_other_bodies_are_refused(real_clip, clip):
    with pytest.raises(SkeletonMismatchError, match="do not tell"):
        retargeted(real_clip(clip), real_clip(XBOT).skeleton)


@pytest.mark.parametrize(
    ("source", "truth", "speed", "legs"),
    [
        ("mixamo_xbot_30fps/Jumping Jacks.fbx", "mixamo_other_rigs/mario_Jumping Jacks.fbx", 1.0, 15.0),
        ("mixamo_other_rigs/mario_Jumping Jacks.fbx", "mixamo_xbot_30fps/Jumping Jacks.fbx", 1.0, 15.0),
        ("mixamo_other_rigs/readyplayerme_Punching.fbx", "mixamo_other_rigs/fbx7400_Punching.fbx", 1.0, 6.0),
        ("mixamo_ybot_60fps/Hook Punch.fbx", "mixamo_xbot_60fps/Hook Punch.fbx", 0.5, 2.5),
        ("mixamo_xbot_60fps/Hook Punch.fbx", "mixamo_ybot_60fps/Hook Punch.fbx", 2.0, 2.5),
    ],
)
def test_as_the_source_retargeted_it(real_clip, source, truth, speed, legs):
    ours, theirs, shift = aligned(real_clip(source), real_clip(truth), speed)
    assert shift == 0
    errors = direction_errors(METHODS["kinestitch"](ours, theirs), theirs)
    assert max(errors[limb] for limb in ("trunk", "upper arm", "forearm")) < 0.5
    assert max(errors[limb] for limb in ("thigh", "shin", "foot")) < legs


@pytest.mark.parametrize(("clip", "rig"), PAIRS)
def test_limbs_point_where_the_source_s_do(real_clip, clip, rig):
    source, target = real_clip(clip), real_clip(rig)
    kept = direction_errors(METHODS["kinestitch, no foot IK"](source, target), source)
    planted_motion = METHODS["kinestitch"](source, target)
    planted = direction_errors(planted_motion, source)
    copied = direction_errors(METHODS["local rotations copied"](source, target), source)
    turned = direction_errors(METHODS["local turns copied"](source, target), source)
    check_motion(planted_motion)
    assert max(kept[limb] for limb in LIMBS) < 0.01
    assert max(planted[limb] for limb in LIMBS) < 5
    for limb in LIMBS:
        assert planted[limb] < min(copied[limb], turned[limb]) / 4


@pytest.mark.parametrize(("clip", "rig"), PAIRS)
def test_feet_neither_sink_nor_float(real_clip, clip, rig):
    source, target = real_clip(clip), real_clip(rig)
    result = METHODS["kinestitch"](source, target)
    toes = [roles_of(result.skeleton).joints[f"{side}_toe"] for side in ("left", "right")]
    lowest = np.percentile(world_pose(result).positions[:, toes, 1].min(axis=1), 5)
    assert -0.03 < lowest < 0.07


def test_one_clip_of_another_actor_keeps_its_numbers(real_clip):
    clip = real_clip("mixamo_prefix8/walking.fbx")
    assert_motion_close(retargeted(clip, clip.skeleton).motion, clip, degrees=0.01, metres=1e-4)


def test_a_kick_of_another_family_is_stitched_into_a_walk(real_clip):
    clips = {"walk": real_clip("mixamo_xbot_60fps/Walking.fbx"), "kick": real_clip(PAIRS[1][0])}
    line = ks.replace(ks.timeline(clips, "walk"), 40, 60, "kick", 100, 200)
    with pytest.warns(KinestitchWarning, match="Clip 'kick' is retargeted from Bandai-Namco to Mixamo joints"):
        result = ks.stitch(line, clips)
    assert result.skeleton is clips["walk"].skeleton
    head = result.skeleton.index("mixamorig:Head")
    assert (world_pose(result).positions[:, head, 1] > 1.0).all()
