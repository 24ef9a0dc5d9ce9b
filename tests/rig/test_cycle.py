"""A clip as one cycle: its ends meet, its travel and its turn stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from rig_builders import below_a_dummy

import kinestitch as ks
from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.core.rotation import quat_distance, quat_multiply, quat_slerp
from kinestitch.errors import RangeError
from kinestitch.rig.cycle import best_end, loop
from kinestitch.rig.root_motion import extract_root
from kinestitch.testing import assert_motion_close, check_motion, motions


def assert_closed(cycle, carrier: int) -> None:
    """The last frame repeats the first but for the carrier's place on the ground and its heading."""
    turns = quat_distance(cycle.rotations[0], cycle.rotations[-1])
    moves = np.abs(cycle.translations[0] - cycle.translations[-1])
    moves[carrier, [0, 2]] = turns[carrier] = 0.0
    assert turns.max() < 1e-6
    assert moves.max() < 1e-9


@given(motions(joints=5, frames=30, bend=1.0))
def test_ends_meet(motion):
    for trim in (True, False):
        cycle = loop(motion, trim=trim)
        check_motion(cycle)
        assert motion.frames // 2 < cycle.frames <= motion.frames
        assert_closed(cycle, 0)
        between = quat_multiply(cycle.rotations[-1, 0], cycle.rotations[0, 0] * [-1, -1, -1, 1])
        assert np.hypot(between[0], between[2]) < 1e-9  # what is left is a turn about the upright


def test_a_cycle_that_closes_is_left_alone():
    walk = ks.sample("walk")
    cycle = loop(walk)
    again = loop(cycle, trim=False)
    assert_motion_close(again, cycle, degrees=1e-6, metres=1e-9)


def test_the_way_over_the_ground_stays():
    walk = ks.sample("walk")
    cycle = loop(walk)
    ways = [motion.translations[: cycle.frames, 0, [0, 2]] for motion in (walk, cycle)]
    assert np.abs(ways[0] - ways[1]).max() < 1e-12
    assert loop(below_a_dummy(walk)).frames == cycle.frames


def test_the_best_end_shows_the_same_pose():
    """A clip that is cut in the middle of a step is trimmed to where its first pose comes back."""
    walk = ks.sample("walk")
    base = loop(walk, trim=False)
    steps = base.frames - 1
    half = steps // 2
    rotations = np.concatenate([base.rotations[:-1], base.rotations[: half + 1]])
    translations = np.concatenate([base.translations[:-1], base.translations[: half + 1]])
    longer = replace(base, rotations=rotations, translations=translations)
    end = best_end(longer)
    assert end < longer.frames - 1
    gaps = quat_distance(longer.rotations[[end, -1]], longer.rotations[0]).max(axis=-1)
    assert gaps[0] < 0.05 < 0.3 < gaps[1]


def test_turning_does_not_count():
    walk = ks.sample("walk")
    assert loop(turn_about_up(walk, 1.0)).frames == loop(walk).frames


def test_a_root_that_travels_keeps_travelling():
    rooted = extract_root(ks.sample("walk"), smooth=0.5)
    cycle = loop(rooted)
    assert_closed(cycle, 0)
    assert np.abs(cycle.translations[:, 0, [0, 2]] - rooted.translations[: cycle.frames, 0, [0, 2]]).max() < 1e-12


def test_frames_move_by_no_more_than_half_the_gap():
    kick = ks.sample("kick")
    short = replace(kick, rotations=kick.rotations[:90], translations=kick.translations[:90])
    cycle = loop(short, trim=False)
    gap = quat_distance(short.rotations[0], short.rotations[-1])
    moved = quat_distance(short.rotations, cycle.rotations).max(axis=0)
    assert (moved[1:] <= gap[1:] / 2 + 1e-6).all()
    middle = quat_slerp(cycle.rotations[0], cycle.rotations[-1], np.full(33, 0.5))
    assert quat_distance(middle, cycle.rotations[0])[1:].max() < 1e-6
    assert np.isfinite(world_pose(cycle).positions).all()


def test_too_short_a_clip_is_refused():
    walk = ks.sample("walk")
    with pytest.raises(RangeError, match="at least 3 frames, got 2"):
        loop(replace(walk, rotations=walk.rotations[:2], translations=walk.translations[:2]))
