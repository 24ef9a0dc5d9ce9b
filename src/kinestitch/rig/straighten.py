"""Rest poses that show no body: all angles zero, every bone along one axis, so that turns about bones say nothing.

Directions of bones are told by the offsets; how far a joint is turned about its own bone is told by the shoulders' and
hip joints' offsets, and by a motion: elbows bend forward, knees backward, and a trunk faces one way in the mean. Axes
of joints stand square to each other in such files, so that quarter turns are enough.
"""

from __future__ import annotations

import numpy as np

from kinestitch.core.kinematics import WorldPose
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_mean,
    quat_multiply,
    quat_rotate,
    rotvec_to_quat,
)
from kinestitch.rig.families import SIDES
from kinestitch.rig.posing import LEFT, OFF, UP, Posing, upright

_STRAIGHT = 0.05  # mean sine of a hinge's angle below which its direction is not known


def straighten(pose: Posing, moving: WorldPose | None) -> None:
    """Put hips, trunk, head and shoulders upright. moving : a motion of the rig"""
    hips = pose.joints["hips"]
    spine = [joint for role, joint in pose.joints.items() if role.startswith("spine_")]
    neck = [joint for role, joint in pose.joints.items() if role.startswith(("neck_", "head"))]
    column = [hips, *spine, *neck]
    lateral = pose.lateral("upper_leg")
    bone = next((b for b in (pose.direction(hips, joint) for joint in column[1:]) if b is not None), None)
    if bone is not None and lateral is not None:
        pose.turn(hips, upright(bone, lateral))
    chest = spine[-1] if spine else hips
    for below, joint, above in zip(column, column[1:], [*column[2:], None], strict=False):
        pose.swing(joint, above, UP)
        across = pose.lateral("upper_arm") if joint == chest else None
        if across is not None:
            pose.turn(joint, upright(UP, across))
        elif moving is not None:
            _face(pose, joint, below, UP, moving)
    for side, out in zip(SIDES, (LEFT, -LEFT), strict=True):
        shoulder, arm = (pose.joints.get(f"{side}_{part}") for part in ("shoulder", "upper_arm"))
        bone = pose.direction(shoulder, arm) if shoulder is not None else None
        if shoulder is not None and bone is not None and bone @ out < np.cos(OFF):
            pose.swing(shoulder, arm, out)
            if moving is not None:
                _face(pose, shoulder, chest, out, moving)


def _face(pose: Posing, joint: int, other: int, bone: Array, moving: WorldPose) -> None:
    """Turn a joint about its bone by quarters, until in the mean of a motion it is turned as another one is."""
    away = [quat_multiply(moving.rotations[:, j], quat_conjugate(pose.rotation(j))) for j in (other, joint)]
    mean = quat_mean(quat_multiply(quat_conjugate(away[0]), away[1]))
    _turn_by_quarters(pose, joint, bone, float(2 * np.arctan2(mean[:3] @ bone, mean[3])))


def _turn_by_quarters(pose: Posing, joint: int, bone: Array, angle: float) -> None:
    quarter = np.pi / 2
    pose.turn(joint, rotvec_to_quat(bone * np.round(angle / quarter) * quarter))


def bend_right(pose: Posing, chain: list[int], bends: Array, moving: WorldPose) -> None:
    """Turn a limb about itself by quarters, until it bends (in the mean of a motion) to where elbows or knees do."""
    upper, middle, end = chain
    bone = pose.direction(upper, middle)
    if bone is None:
        return
    lower = moving.positions[:, end] - moving.positions[:, middle]
    lower /= np.maximum(np.linalg.norm(lower, axis=-1, keepdims=True), 1e-9)
    bend = quat_rotate(quat_conjugate(moving.rotations[:, upper]), lower).mean(axis=0)
    bend = quat_rotate(pose.rotation(upper), bend)
    bend -= bone * (bend @ bone)
    if np.linalg.norm(bend) > _STRAIGHT:
        _turn_by_quarters(pose, upper, bone, float(np.arctan2(np.cross(bend, bends) @ bone, bend @ bends)))
