"""Feet over the seam of a loop: they stand, the cycle stays closed, and nothing but legs moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.analysis.cycle import loop_quality
from kinestitch.core.rotation import quat_distance
from kinestitch.errors import SkeletonMismatchError
from kinestitch.solve.contacts import find_contacts, legs_of
from kinestitch.solve.loop import loop, repeated, solve_loop
from kinestitch.solve.loop_feet import lock_loop, loop_contacts
from kinestitch.testing import check_motion, random_motion


@pytest.mark.parametrize("span", [(20, 160), (5, 130)])
def test_feet_that_slide_over_a_bad_seam_stand(span):
    """These frames of the walk are no whole number of strides."""
    walk = ks.sample("walk")
    looped = solve_loop(walk, *span)
    locked = lock_loop(walk, looped)
    check_motion(locked.motion)
    before, after = (loop_quality(each, loop_contacts(walk, each)).foot_slide_m_s for each in (looped, locked))
    assert before > 0.3
    assert loop_contacts(walk, locked).held.sum() > 0.7 * loop_contacts(walk, looped).held.sum()
    assert after < 0.5 * before
    legs = [j for leg in legs_of(walk.skeleton) for j in (leg.thigh, leg.shin, leg.foot, leg.toe)]
    others = np.delete(np.arange(walk.skeleton.joint_count), legs)
    assert quat_distance(locked.motion.rotations, looped.motion.rotations).max() > 0.01
    assert np.array_equal(locked.motion.rotations[:, others], looped.motion.rotations[:, others])
    ends = quat_distance(locked.motion.rotations[0], locked.motion.rotations[-1])
    assert ends[1:].max() < 1e-7
    sunk = looped.motion.translations - locked.motion.translations
    assert np.array_equal(sunk[:, 1:], np.zeros_like(sunk[:, 1:]))
    assert np.abs(sunk[:, 0, [0, 2]]).max() < 1e-12
    assert -1e-12 < sunk[:, 0, 1].min() <= sunk[:, 0, 1].max() < 0.06


def test_copies_of_a_locked_cycle_are_as_smooth_as_the_middle_of_three():
    walk = ks.sample("walk")
    looped = lock_loop(walk, solve_loop(walk, 20, 160))
    twice = repeated(looped.motion, 2)
    steps = quat_distance(twice.rotations[1:], twice.rotations[:-1])
    seam = steps[138:142].max(axis=0)
    around = np.concatenate([steps[125:138], steps[142:155]]).max(axis=0)
    assert (seam < 1.2 * around + 0.01).all()


def test_a_foot_that_stands_all_the_time_is_left_alone():
    idle = ks.sample("idle")
    drifting = idle.translations.copy()
    drifting[:, 0, 0] += np.linspace(0, 0.05, idle.frames)  # too slow to be no stance
    clip = replace(idle, translations=drifting)
    looped = solve_loop(clip)
    assert loop_contacts(clip, looped).held.all(axis=0).any()
    locked = lock_loop(clip, looped)
    ends = quat_distance(locked.motion.rotations[0], locked.motion.rotations[-1])
    assert ends[1:].max() < 1e-7
    assert quat_distance(locked.motion.rotations, looped.motion.rotations).max() < 1e-5


def test_only_frames_that_are_there_are_looked_at():
    """The same whatever memory held before: nothing is read that has not been written."""
    walk = ks.sample("walk")
    looped, found = solve_loop(walk, 20, 160), []
    for junk in (0.0, 1e300):
        blocks = [np.full(10**5, junk) for _ in range(20)]
        del blocks
        found.append(lock_loop(walk, looped).motion.rotations)
    assert np.array_equal(*found)


def test_contacts_are_those_of_the_clip():
    walk = ks.sample("walk")
    looped = solve_loop(walk, 30, 100)
    assert np.array_equal(loop_contacts(walk, looped).held, find_contacts(walk).held[30:100])


def test_a_rig_without_feet_is_refused():
    motion = random_motion(0)
    with pytest.raises(SkeletonMismatchError):
        lock_loop(motion, solve_loop(motion))
    assert loop(motion).frames == motion.frames + 1
