"""One pose that every rig can stand in: upright, facing +Z, arms out to the sides, legs straight down, feet flat.

Rest poses differ from rig to rig, by file and by format: T-poses, A-poses, arms hanging, or all angles zero with
every bone along one axis. Two rigs in this pose look alike in the world, so that a turn away from it, told in the
world's axes, means the same on both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import LIMBS, SIDES
from kinestitch.rig.posing import FORWARD, LEFT, OFF, UP, Posing, align, upright
from kinestitch.rig.standing import flatten_foot, is_grounded, standing_feet
from kinestitch.rig.straighten import bend_right, straighten

_LEANING = np.radians(40.0)  # a rest pose that leans further does not stand


@dataclass(frozen=True, eq=False, slots=True)
class Reference:
    """A rig in the common pose.

    rotations : (J, 4) world_from_joint; positions : (J, 3) m, the root at its rest offset
    posed : whether the rig's own rest pose shows a standing body; grounded : whether that stands at height 0
    """

    rotations: Array
    positions: Array
    posed: bool
    grounded: bool


def reference(skeleton: Skeleton, joints: Mapping[str, int], example: Motion | None = None) -> Reference:
    """The rig in the common pose.

    joints : role → joint, see :func:`kinestitch.rig.roles.roles_of`
    example : a motion of this rig; where the rest pose is no pose, it tells in which direction elbows and knees bend

    Bones of arms and legs are aligned exactly, by the shortest turn from a rest pose that stands. Trunk, head and hands
    stay as at rest, for their bones' directions say more about where a rig puts its joints than about where the body
    leans. Feet stand flat: as at rest where the rest pose stands on the ground, else as the example's feet do when
    they stand still.
    """
    pose = Posing(skeleton, joints)
    moving = world_pose(example) if example is not None else None
    _stand(pose)
    posed = _is_posed(pose)
    if not posed:
        straighten(pose, moving)
    grounded = posed and is_grounded(pose)
    flat = pose.turns.copy() if grounded or (posed and moving is None) else None
    standing = standing_feet(joints, moving)
    for side in SIDES:
        for limb, bends in ((LIMBS["arm"], FORWARD), (LIMBS["leg"], -FORWARD)):
            out = -UP if bends is not FORWARD else LEFT if side == SIDES[0] else -LEFT
            chain = [pose.joints[f"{side}_{part}"] for part in limb if f"{side}_{part}" in pose.joints]
            far = align(pose, chain, out)
            if (far or not posed) and moving is not None and len(chain) == 3:
                bend_right(pose, chain, bends, moving)
        _straighten_hand(pose, side)
        flatten_foot(pose, side, flat, standing)
    rotations = pose.rotations()
    positions = _place(skeleton, rotations)
    return Reference(rotations, positions, posed, grounded)


def _place(skeleton: Skeleton, rotations: Array) -> Array:
    positions = skeleton.offsets.copy()
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            positions[joint] = positions[parent] + quat_rotate(rotations[parent], skeleton.offsets[joint])
    return positions


def _stand(pose: Posing) -> None:
    """Turn the whole rest pose to face +Z, and upright if it leans far (Z-up files, bones along one axis)."""
    joints = pose.joints
    top = joints.get("head", joints.get("neck_1", joints.get("spine_1")))
    up = pose.rest[top] - pose.rest[joints["hips"]] if top is not None else UP
    sides = [side for pair in ("upper_leg", "upper_arm") if (side := pose.lateral(pair)) is not None]
    lateral = np.sum(sides, axis=0) if sides else LEFT
    if np.linalg.norm(up) < 1e-9 or up @ UP > np.cos(_LEANING) * np.linalg.norm(up):
        up = UP
    pose.turn(0, upright(up, lateral))


def _is_posed(pose: Posing) -> bool:
    """Whether the rest pose, facing +Z, shows a body that stands: legs down, both hips and shoulders to the left."""
    for side in SIDES:
        upper, lower = (pose.joints.get(f"{side}_{part}") for part in ("upper_leg", "lower_leg"))
        bone = pose.direction(upper, lower) if upper is not None and lower is not None else None
        if bone is not None and bone @ -UP < np.cos(OFF):
            return False
    sides = [pose.lateral(pair) for pair in ("upper_leg", "upper_arm")]
    return all(side is None or side @ LEFT > np.cos(_LEANING) * np.linalg.norm(side) for side in sides)


def _straighten_hand(pose: Posing, side: str) -> None:
    out = LEFT if side == SIDES[0] else -LEFT
    hand, finger = (pose.joints.get(f"{side}_{part}") for part in ("hand", "middle_1"))
    bone = pose.direction(hand, finger) if hand is not None else None
    if hand is not None and bone is not None and bone @ out < np.cos(OFF):
        pose.swing(hand, finger, out)
