"""Pins on real clips: rigs whose root carries the travel or does not, and feet that slide a little by themselves."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from kinestitch.analysis.skating import slide_in_contact
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.edit.operations import insert
from kinestitch.edit.pinning import come_back
from kinestitch.edit.pins import Pin
from kinestitch.edit.timeline import timeline
from kinestitch.errors import KinestitchWarning
from kinestitch.rig.hips import hips_joint
from kinestitch.rig.roles import roles_of
from kinestitch.solve.footlock import placed_contacts
from kinestitch.solve.stitch import solve_timeline, stitch

Reader = Callable[[str], Motion]
WALKS = [
    "mixamo_xbot_60fps/Walking.fbx",
    "bandai/dataset-1_walk-back_normal_001.bvh",
    "bandai/dataset-1_walk_active_001.bvh",
    "bandai/dataset-1_walk_normal_001.bvh",
]


@pytest.mark.parametrize("name", WALKS)
def test_a_bent_walk_with_a_pinned_hand(real_clip: Reader, name: str):
    clips = {"walk": real_clip(name)}
    line, walk = timeline(clips, "walk"), clips["walk"]
    hips, hand = hips_joint(walk.skeleton), roles_of(walk.skeleton).joints["left_hand"]
    path = world_pose(walk).positions[:, hips]
    last, middle = walk.frames - 1, walk.frames // 2
    ahead = path[last] - path[0]
    goal = path[middle] + np.array([-ahead[2], 0.0, ahead[0]]) * 0.15
    bend = (Pin("waypoint", middle, (goal[0], goal[2])), Pin("heading", last, (1.0,)))
    bent, planted = (solve_timeline(replace(line, pins=bend), clips, foot_lock=lock) for lock in (False, True))
    contacts = placed_contacts(planted.placed)
    own, slid, stood = (slide_in_contact(motion, contacts) for motion in (walk, bent.motion, planted.motion))
    assert np.abs((world_pose(planted.motion).positions[middle, hips] - goal)[[0, 2]]).max() < 1e-9
    assert slid > own + 0.01
    assert stood < own + 0.005
    place = world_pose(planted.motion).positions[last // 3, hand] + [0.0, 0.1, 0.03]
    pin = Pin("position", last // 3, tuple(place), walk.skeleton.names[hand])
    pinned = stitch(replace(line, pins=(*bend, pin)), clips)
    assert np.abs(world_pose(pinned).positions[last // 3, hand] - place).max() < 1e-6


@pytest.mark.parametrize(
    ("walk", "kick"),
    [
        ("mixamo_xbot_60fps/Walking.fbx", "mixamo_xbot_60fps/Kicking.fbx"),
        ("bandai/dataset-1_walk_active_001.bvh", "bandai/dataset-1_kick_normal_001.bvh"),
        ("bandai/dataset-1_walk_active_001.bvh", "bandai/dataset-1_walk-back_normal_001.bvh"),
    ],
)
def test_the_body_meets_its_original_path_again(real_clip: Reader, walk: str, kick: str):
    clips = {"walk": real_clip(walk), "kick": real_clip(kick)}
    at = clips["walk"].frames // 3
    line = come_back(insert(timeline(clips, "walk"), at, "kick"), 0.9)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        motion = stitch(line, clips)
    frame = line.pins[0].frame
    own = line.segments[-1].range.start + frame - line.starts[-2]
    ours, theirs = (world_pose(m).positions for m in (motion, clips["walk"]))
    assert np.abs(ours[frame:] - theirs[own:]).max() < 1e-9
