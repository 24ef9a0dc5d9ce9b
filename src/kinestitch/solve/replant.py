"""Feet of a body whose path was bent or moved: each stance goes along as a whole, as the middle of it is moved.

The body is moved differently in every frame, so that a foot that stood would slide and turn. Here it stands again, in
the place and direction to which its middle frame is taken, and the leg is bent to it as for a locked foot.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.kinematics import WorldPose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.rig.hips import hip_height
from kinestitch.solve.contacts import Contacts, Leg, Mask, legs_of, runs
from kinestitch.solve.footing import foot_path
from kinestitch.solve.footlock import BLEND
from kinestitch.solve.ground import GroundMove
from kinestitch.solve.legs import bent_leg
from kinestitch.solve.swings import carry_over

_APART, _TURNED = 0.35, np.radians(50.0)
"""Leg lengths and rad by which a stance's ends may be moved differently; feet of others are left as they were moved."""

_STILL = 1e-7  # m and rad


def replanted(before: Motion, after: Motion, move: GroundMove, contacts: Contacts) -> tuple[Motion, Contacts]:
    """The moved motion with its feet standing, and the contacts it keeps.

    before : the motion whose feet stand; after : the same as it was moved; contacts : of `before`

    Only legs change, only where a foot stands or within a blend of it, and only where the body was moved.
    """
    joints = [joint for leg in legs_of(before.skeleton) for joint in leg.joints]
    poses = world_pose(before, joints), world_pose(after, joints)
    rotations, held = after.rotations.copy(), contacts.held.copy()
    for leg in legs_of(before.skeleton):
        columns = [contacts.joints.index(joint) for joint in (leg.foot, leg.toe) if joint in contacts.joints]
        offsets, stands = _offsets(poses, move, leg, contacts.of(leg.foot, leg.toe), before)
        held[:, columns] &= stands[:, None]
        frames = np.flatnonzero(np.abs(offsets[:, :6]).max(axis=1) > _STILL)
        if not len(frames):
            continue
        pose = WorldPose(poses[1].positions[frames], poses[1].rotations[frames])
        hip, ankle = poses[0].positions[frames, leg.thigh], poses[0].positions[frames, leg.foot]
        stretch = np.linalg.norm(ankle - hip, axis=-1)
        local = bent_leg(pose, after.rotations[frames], leg, offsets[frames], stretch, after.skeleton.parents)
        for joint, values in local.items():
            rotations[frames, joint] = values
    return replace(after, rotations=rotations), Contacts(contacts.joints, held)


def _offsets(
    poses: tuple[WorldPose, WorldPose], move: GroundMove, leg: Leg, held: Mask, motion: Motion
) -> tuple[Array, Mask]:
    """How a foot has to be moved from where the body took it (F, 9): m, rad in the world, nothing of the toe; and the
    frames (F,) in which it stands.
    """
    old, new = foot_path(poses[0], leg).pivot, foot_path(poses[1], leg).pivot
    size, stands = hip_height(motion.skeleton), np.zeros(len(held), dtype=bool)
    offsets = np.zeros((len(held), 9))
    for start, stop in runs(held):
        here, middle = np.arange(start, stop), (start + stop - 1) // 2
        away = move.points(old[here], np.full(stop - start, middle)) - new[here]
        turn = move.yaw[middle] - move.yaw[here]
        if np.linalg.norm(away, axis=-1).max() < _APART * size and np.abs(turn).max() < _TURNED:
            stands[here] = True
            offsets[here, :3], offsets[here, 4] = away, turn
    return carry_over(offsets, stands, BLEND * motion.fps), stands
