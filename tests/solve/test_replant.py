"""Feet stand on a bent path as they stood on the straight one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.analysis.skating import slide_in_contact
from kinestitch.core.kinematics import world_pose
from kinestitch.core.rotation import quat_distance
from kinestitch.edit.operations import replace as paste
from kinestitch.edit.pins import Pin
from kinestitch.edit.timeline import timeline
from kinestitch.rig.hips import hips_joint
from kinestitch.samples import sample
from kinestitch.solve.contacts import legs_of, runs
from kinestitch.solve.footlock import placed_contacts
from kinestitch.solve.stitch import solve_timeline
from kinestitch.solve.ways import LONGER, SHORTER

WALK = {"walk": sample("walk")}
LINE = timeline(WALK, "walk")
LAST = LINE.frames - 1
BENDS = {
    "a quarter turn": [Pin("heading", LAST, (np.pi / 2,))],
    "a quarter turn the other way": [Pin("heading", LAST, (-np.pi / 2,))],
    "waypoints": [Pin("waypoint", 100, (0.6, 1.8)), Pin("waypoint", LAST, (0.0, 3.6))],
    "sideways": [Pin("root", LAST, (0.6, 0.0, 4.2))],
}


def solved(pins, **options):
    return solve_timeline(replace(LINE, pins=tuple(pins)), WALK, **options)


@pytest.mark.parametrize("pins", BENDS.values(), ids=BENDS)
def test_feet_slide_hardly_more_than_in_the_clip(pins):
    bent, planted = solved(pins), solved(pins, foot_lock=True)
    contacts = placed_contacts(planted.placed)
    own, without, now = (slide_in_contact(m, contacts) for m in (WALK["walk"], bent.motion, planted.motion))
    assert without > 0.05
    assert now < 0.01
    assert now < own + 0.002
    assert np.array_equal(planted.contacts.held, contacts.held)


@pytest.mark.parametrize("pins", BENDS.values(), ids=BENDS)
def test_each_stance_is_the_clips_own_turned_and_moved_as_a_whole(pins):
    planted = solved(pins, foot_lock=True)
    ours, theirs = world_pose(planted.motion), world_pose(WALK["walk"])
    checked = 0
    for leg in legs_of(planted.motion.skeleton):
        for start, stop in runs(planted.contacts.of(leg.foot, leg.toe)):
            after, before = (pose.positions[start:stop, [leg.foot, leg.toe]] for pose in (ours, theirs))
            assert np.abs(after[..., 1] - before[..., 1]).max() < 3e-3
            apart = [
                np.linalg.norm(side.reshape(-1, 1, 3) - side.reshape(1, -1, 3), axis=-1) for side in (after, before)
            ]
            assert np.abs(apart[0] - apart[1]).max() < 3e-3
            checked += 1
    assert checked > 5


def test_only_legs_are_changed_and_no_bone_is_stretched():
    pins = BENDS["a quarter turn"]
    bent, planted = solved(pins).motion, solved(pins, foot_lock=True).motion
    legs = {joint for leg in legs_of(bent.skeleton) for joint in (leg.thigh, leg.shin, leg.foot, leg.toe)}
    others = [joint for joint in range(bent.skeleton.joint_count) if joint not in legs]
    assert np.array_equal(bent.rotations[:, others], planted.rotations[:, others])
    assert np.array_equal(bent.translations, planted.translations)
    steps = quat_distance(planted.rotations[1:], planted.rotations[:-1]).max(axis=1)
    assert steps.max() < 1.5 * quat_distance(bent.rotations[1:], bent.rotations[:-1]).max()


def test_feet_of_a_stance_that_is_turned_too_far_are_let_go():
    clips = {"idle": sample("idle")}
    line = timeline(clips, "idle")
    pinned = solve_timeline(replace(line, pins=(Pin("heading", line.frames - 1, (np.pi,)),)), clips, foot_lock=True)
    assert not pinned.contacts.held.any()
    free = solve_timeline(replace(line, pins=(Pin("heading", line.frames - 1, (np.pi,)),)), clips)
    assert np.array_equal(pinned.motion.rotations, free.motion.rotations)


def test_locked_feet_of_a_seam_stand_on_the_bent_path_too():
    clips = {"walk": sample("walk"), "kick": sample("kick")}
    line = paste(timeline(clips, "walk"), 84, 130, "kick", 30, 112)
    line = replace(line, pins=(Pin("heading", line.frames - 1, (np.radians(60),)),))
    locked = solve_timeline(line, clips, foot_lock=True)
    plain = solve_timeline(replace(line, pins=()), clips, foot_lock=True)
    assert slide_in_contact(locked.motion, locked.contacts) < slide_in_contact(plain.motion, plain.contacts) + 0.005
    assert np.abs(locked.unpinned.rotations - plain.motion.rotations).max() == 0.0


def test_a_rig_without_feet_is_bent_all_the_same():
    from solve_oracles import cast, line

    clips = cast(1, frames=60)
    base = line([("a", 0, 60)], clips)
    pinned = replace(base, pins=(Pin("root", 50, (0.2, 0.0, 0.1)),))
    found = solve_timeline(pinned, clips, foot_lock=True)
    assert np.allclose(world_pose(found.motion).positions[50, 0, [0, 2]], [0.2, 0.1])
    assert found.contacts is None


def stances_kept(name: str, share: float) -> float:
    """How many of a clip's contacts are left where its way becomes `share` times as long."""
    clip = sample(name)
    hips = world_pose(clip).positions[:, hips_joint(clip.skeleton)]
    x, _, z = hips[0] + share * (hips[-1] - hips[0])
    line = replace(timeline({name: clip}, name), pins=(Pin("root", clip.frames - 1, (x, 0.0, z)),))
    planted = solve_timeline(line, {name: clip}, foot_lock=True)
    return float(planted.contacts.held.sum() / placed_contacts(planted.placed).held.sum())


@pytest.mark.filterwarnings("ignore:The way to")
@pytest.mark.parametrize("name", ["walk", "run"])
def test_stances_hold_as_far_as_ways_may_change_without_a_warning(name: str):
    assert stances_kept(name, SHORTER) == stances_kept(name, 1.0) == stances_kept(name, LONGER) == 1.0


@pytest.mark.filterwarnings("ignore:The way to")
def test_stances_are_lost_where_ways_change_by_more():
    for share in (SHORTER / 2, LONGER + 0.25):
        assert min(stances_kept(name, share) for name in ("walk", "run")) < 1.0
