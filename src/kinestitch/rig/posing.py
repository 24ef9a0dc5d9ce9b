"""A rest pose being turned into another pose, bone by bone, in the world's axes."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from kinestitch.core.kinematics import rest_pose
from kinestitch.core.rotation import (
    Array,
    matrix_to_quat,
    quat_between,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    rotvec_to_quat,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import SIDES

LEFT, UP, FORWARD = np.eye(3)
OFF = np.radians(60.0)
"""A limb that rests further from where it should be is drawn along an axis, or hangs."""


class Posing:
    """A rest pose with a world turn for each joint, which is carried on to what hangs on it.

    joints : role → joint; rest, axes : positions (J, 3) m and world_from_joint (J, 4) at rest; turns : (J, 4)
    """

    def __init__(self, skeleton: Skeleton, joints: Mapping[str, int]) -> None:
        self.skeleton = skeleton
        self.joints = joints
        self.rest, self.axes = rest_pose(skeleton)
        self.turns = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (skeleton.joint_count, 4)).copy()

    def turn(self, joint: int, by: Array) -> None:
        """Turn a joint and everything below it in the world."""
        below = {joint}
        self.turns[joint] = quat_multiply(by, self.turns[joint])
        for other in range(joint + 1, self.skeleton.joint_count):
            if self.skeleton.parents[other] in below:
                below.add(other)
                self.turns[other] = quat_multiply(by, self.turns[other])

    def direction(self, joint: int, to: int | None) -> Array | None:
        """Where a joint's bone points now: to another joint, or to its own tip; (3,), None where it has no length."""
        if to is None:
            tip = self.skeleton.tips[joint]
            bone = quat_rotate(self.axes[joint], tip) if np.isfinite(tip).all() else np.zeros(3)
        else:
            bone = self.rest[to] - self.rest[joint]
        size = np.linalg.norm(bone)
        return quat_rotate(self.turns[joint], bone / size) if size > 1e-9 else None

    def swing(self, joint: int, to: int | None, wanted: Array) -> None:
        """Turn a joint the short way until its bone points as wanted."""
        now = self.direction(joint, to)
        if now is None:
            return
        opposite = now @ wanted < -0.9999 and abs(now @ LEFT) < 0.1
        self.turn(joint, rotvec_to_quat(np.pi * LEFT) if opposite else quat_between(now, wanted))

    def lateral(self, pair: str) -> Array | None:
        """From right to left between two counterparts, as the joint that both hang on stands now."""
        left, right = (self.joints.get(f"{side}_{pair}") for side in SIDES)
        if left is None or right is None:
            return None
        common = [a for a, b in zip(self.skeleton.chain(left), self.skeleton.chain(right), strict=False) if a == b][-1]
        apart = quat_rotate(self.turns[common], self.rest[left] - self.rest[right])
        return apart if np.linalg.norm(apart) > 1e-9 else None

    def rotation(self, joint: int) -> Array:
        """World rotation (4,) of a joint now."""
        return quat_multiply(self.turns[joint], self.axes[joint])

    def rotations(self) -> Array:
        """World rotations (J, 4) of all joints now."""
        return quat_multiply(self.turns, self.axes)


def upright(up: Array, lateral: Array) -> Array:
    """The turn (4,) after which `up` points up and `lateral`, as far as it is square to it, to the left."""
    up = up / np.linalg.norm(up)
    side = lateral - up * (lateral @ up)
    if np.linalg.norm(side) < 1e-6:
        return quat_between(up, UP)
    side /= np.linalg.norm(side)
    return quat_conjugate(matrix_to_quat(np.stack([side, up, np.cross(side, up)], axis=1)))


def align(pose: Posing, chain: list[int], wanted: Array) -> bool:
    """Point every bone of a limb as wanted; returns whether the first one had to turn far."""
    far = False
    for joint, end in pairwise(chain):
        bone = pose.direction(joint, end)
        far |= joint == chain[0] and bone is not None and bone @ wanted < np.cos(OFF)
        pose.swing(joint, end, wanted)
    return far
