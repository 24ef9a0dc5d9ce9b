"""Travel taken out, given to a root, and given back: nothing else moves in the world."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig_builders import below_a_dummy

import kinestitch as ks
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_distance, quat_multiply, quat_rotate
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.rig.carrier import lift_travel, world_of
from kinestitch.rig.root_motion import bake_root, extract_root, in_place, traveller
from kinestitch.testing import assert_motion_close, check_motion, motions, random_motion

GROUND = (0, 2)


def assert_same_world(ours: Motion, theirs: Motion, names: tuple[str, ...]) -> None:
    """The joints of these names stand and look alike, to 1e-9."""
    a, b = [[motion.skeleton.index(name) for name in names] for motion in (ours, theirs)]
    here, there = world_pose(ours), world_pose(theirs)
    assert np.abs(here.positions[:, a] - there.positions[:, b]).max() < 1e-9
    assert quat_distance(here.rotations[:, a], there.rotations[:, b]).max() < 1e-7


def turning(seed: int = 3) -> Motion:
    """A walk along a curve."""
    walk = ks.sample("walk")
    yaw = np.linspace(0.3, 4.0, walk.frames)
    turn = quat_about_axis(1, yaw)
    rotations, translations = walk.rotations.copy(), walk.translations.copy()
    rotations[:, 0] = quat_multiply(turn, rotations[:, 0])
    translations[:, 0] = quat_rotate(turn, translations[:, 0] + [1.0, 0.0, 0.0])
    return replace(walk, rotations=rotations, translations=translations)


@pytest.mark.parametrize("smooth", [0.0, 0.4])
@pytest.mark.parametrize("turns", [True, False])
def test_a_new_root_takes_the_travel_and_nothing_else_moves(turns, smooth):
    motion = turning()
    rooted = extract_root(motion, turning=turns, smooth=smooth)
    check_motion(rooted)
    assert rooted.skeleton.names[:2] == ("root", "mixamorig:Hips")
    assert_same_world(rooted, motion, motion.skeleton.names)
    assert np.abs(rooted.translations[:, 0, 1]).max() == 0
    if smooth == 0:
        assert np.abs(rooted.translations[:, 1, GROUND]).max() < 1e-12
    upright = np.abs(rooted.rotations[:, 0][:, GROUND]).max()
    assert upright < 1e-12
    assert (quat_distance(rooted.rotations[0, 0], rooted.rotations[-1, 0]) > 1) == turns


def test_the_own_root_of_a_rig_takes_the_travel():
    motion = below_a_dummy(turning(), "root")
    rooted = extract_root(motion)
    assert rooted.skeleton is motion.skeleton
    assert_same_world(rooted, motion, motion.skeleton.names[1:])
    assert np.ptp(rooted.translations[:, 0, 0]) > 1
    assert np.abs(rooted.translations[:, 1, GROUND]).max() < 1e-12
    assert_same_world(bake_root(rooted), motion, motion.skeleton.names)


@given(motions(joints=5, frames=20, bend=2.0), st.booleans(), st.sampled_from([0.0, 0.3]))
def test_extract_and_bake_are_inverse(motion, turns, smooth):
    named = ("Hips", *motion.skeleton.names[1:])
    motion = replace(motion, skeleton=replace(motion.skeleton, names=named))
    rooted = extract_root(motion, turning=turns, smooth=smooth, name="ground")
    baked = bake_root(rooted, remove=True)
    assert_same_world(rooted, motion, named)
    assert baked.skeleton == motion.skeleton
    assert_motion_close(baked, motion, degrees=1e-5, metres=1e-9)


@given(motions(joints=5, frames=20, bend=2.0))
def test_hips_below_a_root_take_its_motion_and_give_it_back(motion):
    named = ("root", "Hips", *motion.skeleton.names[2:])
    motion = replace(motion, skeleton=replace(motion.skeleton, names=named))
    below = tuple(name for joint, name in enumerate(named) if 1 in motion.skeleton.chain(joint))
    baked = bake_root(motion)
    assert_same_world(baked, motion, below)
    assert np.ptp(baked.rotations[:, 0], axis=0).max() == 0
    assert_same_world(extract_root(baked), motion, below)


def test_steady_travel_stays_steady_when_it_is_averaged():
    walk = ks.sample("walk")
    steps = np.zeros((walk.frames, 3))
    steps[:, 2] = np.arange(walk.frames) * 0.02
    steady = replace(walk, translations=np.where(np.arange(33)[:, None] == 0, steps[:, None], walk.translations))
    path = extract_root(steady, smooth=0.5, turning=False).translations[:, 0]
    assert np.abs(path - steps).max() < 1e-9


def test_names_that_are_taken_are_numbered():
    twice = extract_root(ks.sample("idle"), name="mixamorig:Head")
    assert twice.skeleton.names[0] == "mixamorig:Head2"


def test_a_baked_rig_without_a_root_comes_back():
    walk = ks.sample("walk")
    assert bake_root(walk) is walk


def test_a_root_with_props_stays():
    motion = random_motion(1, joints=4)
    skeleton = replace(motion.skeleton, names=("root", "Hips", "Prop", "Strap"), parents=(-1, 0, 0, 1))
    props = replace(motion, skeleton=skeleton)
    with pytest.raises(SkeletonMismatchError, match="below the root 'root', got Hips, Prop"):
        bake_root(props, remove=True)
    baked = bake_root(props)
    assert_same_world(baked, props, ("Hips", "Prop", "Strap"))
    assert np.ptp(baked.translations[:, 0], axis=0).max() == 0


def test_in_place_holds_the_hips():
    motion = turning()
    held = in_place(motion)
    position, _ = world_of(held, 0)
    assert np.abs(position[:, GROUND] - motion.translations[0, 0, GROUND]).max() < 1e-12
    assert np.array_equal(position[:, 1], motion.translations[:, 0, 1])
    assert quat_distance(held.rotations, motion.rotations).max() < 1e-7  # turns stay
    still = in_place(motion, turning=False)
    away = quat_multiply(still.rotations[:, 0], quat_about_axis(1, 0.0))
    yaw = 2 * np.arctan2(away[:, 1], away[:, 3])
    assert np.abs(yaw - yaw[0]).max() < 1e-9
    lengths = [np.linalg.norm(np.diff(world_pose(m).positions, axis=1), axis=-1) for m in (motion, still)]
    assert np.abs(lengths[0] - lengths[1]).max() < 1e-9  # one body


def test_in_place_twice_is_in_place_once():
    held = in_place(turning(), turning=False)
    assert_motion_close(in_place(held, turning=False), held, degrees=1e-5, metres=1e-9)


def test_a_root_that_carries_the_travel_is_held_and_the_hips_sway_on():
    rooted = extract_root(ks.sample("walk"), smooth=1.0)
    assert traveller(rooted) == 0
    held = in_place(rooted)
    assert np.abs(np.ptp(held.translations[:, 0], axis=0)).max() < 1e-12
    sway = np.ptp(world_pose(held).positions[:, 1, 0])
    assert 0.001 < sway < 0.2


def test_a_static_root_is_no_traveller():
    assert traveller(below_a_dummy(ks.sample("walk"))) == 1
    assert traveller(ks.sample("walk")) == 0


def test_travel_lifted_to_a_dummy_moves_nothing():
    motion = below_a_dummy(turning())
    lifted = lift_travel(motion, 0, 1)
    assert_same_world(lifted, motion, motion.skeleton.names[1:])


@pytest.mark.parametrize("smooth", [-1.0, float("nan"), float("inf")])
def test_impossible_times_are_refused(smooth):
    with pytest.raises(ParameterError, match="Expected a smoothing time"):
        extract_root(ks.sample("idle"), smooth=smooth)
