"""From local to world and back: forward kinematics, joint axes, and two-bone inverse kinematics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_about_axis,
    quat_between,
    quat_conjugate,
    quat_multiply,
    quat_normalize,
    quat_rotate,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError


@dataclass(frozen=True, eq=False, slots=True)
class WorldPose:
    """Where joints are in the world; made by :func:`world_pose` only.

    positions : (F, J, 3) m
    rotations : (F, J, 4) world_from_joint, xyzw

    J are always all joints of the skeleton, by their own indices; those that were left out are NaN.
    """

    positions: Array
    rotations: Array


def _accumulate(parents: tuple[int, ...], translations: Array, rotations: Array) -> tuple[Array, Array]:
    positions = np.empty(translations.shape)
    world = np.empty(rotations.shape)
    for joint, parent in enumerate(parents):
        if parent < 0:
            positions[..., joint, :] = translations[..., joint, :]
            world[..., joint, :] = rotations[..., joint, :]
        else:
            world[..., joint, :] = quat_multiply(world[..., parent, :], rotations[..., joint, :])
            positions[..., joint, :] = positions[..., parent, :] + quat_rotate(
                world[..., parent, :], translations[..., joint, :]
            )
    return positions, world


def world_pose(motion: Motion, joints: Sequence[int] | None = None) -> WorldPose:
    """Forward kinematics: positions (F, J, 3) m and world_from_joint rotations (F, J, 4) of every frame.

    joints : indices of those that are wanted, all when left out. A few are found quicker than all; they and those that
        they hang on are the same as among all, the others are NaN.

    Raises ParameterError for an index outside [0, J).
    """
    skeleton = motion.skeleton
    if joints is None:
        positions, rotations = _accumulate(skeleton.parents, motion.translations, motion.rotations)
        rotations = quat_normalize(rotations)
    else:
        kept = _with_those_above(skeleton, joints)
        parents = tuple(kept.index(skeleton.parents[joint]) if joint else -1 for joint in kept)
        found = _accumulate(parents, motion.translations[:, kept], motion.rotations[:, kept])
        positions, rotations = np.full(motion.translations.shape, np.nan), np.full(motion.rotations.shape, np.nan)
        positions[:, kept], rotations[:, kept] = found[0], quat_normalize(found[1])
    positions.setflags(write=False)
    rotations.setflags(write=False)
    return WorldPose(positions, rotations)


def _with_those_above(skeleton: Skeleton, joints: Sequence[int]) -> list[int]:
    """These joints and all that they hang on, each once, parents before children."""
    outside = [joint for joint in joints if not 0 <= joint < skeleton.joint_count]
    if outside:
        raise ParameterError(f"Expected indices of joints in [0, {skeleton.joint_count}), got {outside[0]}.")
    return sorted({above for joint in joints for above in skeleton.chain(joint)})


def rest_pose(skeleton: Skeleton) -> tuple[Array, Array]:
    """World positions (J, 3) m and world_from_joint rotations (J, 4) of the rest pose."""
    return _accumulate(skeleton.parents, skeleton.offsets, skeleton.rest)


def local_from_world(skeleton: Skeleton, positions: ArrayLike, rotations: ArrayLike) -> tuple[Array, Array]:
    """Inverse of forward kinematics: local translations (..., J, 3) m and rotations (..., J, 4) from world ones."""
    positions = np.asarray(positions, dtype=np.float64)
    rotations = np.asarray(rotations, dtype=np.float64)
    translations = positions.copy()
    local = rotations.copy()
    if skeleton.joint_count > 1:
        parents = skeleton.parent_array[1:]
        inverse = quat_conjugate(rotations[..., parents, :])
        local[..., 1:, :] = quat_normalize(quat_multiply(inverse, rotations[..., 1:, :]))
        translations[..., 1:, :] = quat_rotate(inverse, positions[..., 1:, :] - positions[..., parents, :])
    return translations, local


def with_joint_axes(motion: Motion, axes: ArrayLike) -> Motion:
    """The same motion of the same body, told in other joint axes.

    axes : (J, 4) world_from_joint rotations that the rest pose shall have (identity: axes parallel to the world's)

    World positions stay; every joint's frame turns by a constant. BVH files need it, whose rest rotations are the
    identity.
    """
    skeleton = motion.skeleton
    axes = np.broadcast_to(np.asarray(axes, dtype=np.float64), (skeleton.joint_count, 4))
    rest_positions, rest_rotations = rest_pose(skeleton)
    turn = quat_multiply(quat_conjugate(rest_rotations), axes)  # old joint frame from new joint frame
    undo = quat_conjugate(turn)
    parents = skeleton.parent_array[1:]
    rotations = quat_multiply(motion.rotations, turn)
    rotations[:, 1:] = quat_multiply(undo[parents], rotations[:, 1:])
    translations = motion.translations.copy()
    translations[:, 1:] = quat_rotate(undo[parents], motion.translations[:, 1:])
    offsets, rest = local_from_world(skeleton, rest_positions, axes)
    turned = replace(skeleton, offsets=offsets, rest=rest, tips=quat_rotate(undo, skeleton.tips))
    return replace(motion, skeleton=turned, translations=translations, rotations=quat_normalize(rotations))


def two_bone_ik(hip: ArrayLike, knee: ArrayLike, ankle: ArrayLike, target: ArrayLike) -> tuple[Array, Array]:
    """World-space turns of thigh and shin that bring the ankle to `target`, the knee staying in its own plane.

    hip, knee, ankle, target : (..., 3) m, world

    Returns (..., 4) and (..., 4), to be multiplied from the left onto the world rotations of the upper and the lower
    bone. A target out of reach is approached with a straight limb (99.99 % of full length), one too near with the
    tightest bend.
    """
    hip, knee, ankle, target = (np.asarray(p, dtype=np.float64) for p in (hip, knee, ankle, target))
    upper = np.linalg.norm(knee - hip, axis=-1)
    lower = np.linalg.norm(ankle - knee, axis=-1)
    reach = np.clip(
        np.linalg.norm(target - hip, axis=-1), np.abs(upper - lower) * 1.0001 + 1e-9, (upper + lower) * 0.9999
    )
    length = np.linalg.norm(ankle - hip, axis=-1)

    def angle(opposite: Array, a: Array, b: Array) -> Array:
        cosine = (a * a + b * b - opposite * opposite) / np.maximum(2 * a * b, 1e-12)
        return np.asarray(np.arccos(np.clip(cosine, -1, 1)))

    axis = _hinge(hip, knee, ankle)
    at_hip = angle(lower, upper, reach) - angle(lower, upper, length)
    at_knee = angle(reach, upper, lower) - angle(length, upper, lower)

    def about(turn: Array) -> Array:
        return np.concatenate([axis * np.sin(turn / 2)[..., None], np.cos(turn / 2)[..., None]], axis=-1)

    thigh = about(at_hip)
    shin = quat_multiply(thigh, about(at_knee))
    bent = hip + quat_rotate(thigh, knee - hip)
    bent = bent + quat_rotate(shin, ankle - knee)
    aim = quat_between(bent - hip, target - hip)
    return quat_multiply(aim, thigh), quat_multiply(aim, shin)


def _hinge(hip: Array, knee: Array, ankle: Array) -> Array:
    """Unit axis (..., 3) about which the knee bends; a straight limb, which has no plane, bends about the world's X (or
    Z, where it points along X).
    """
    axis = np.cross(ankle - hip, knee - hip)
    size = np.linalg.norm(axis, axis=-1, keepdims=True)
    limb = ankle - hip
    length = np.linalg.norm(limb, axis=-1, keepdims=True)
    along = limb / np.maximum(length, 1e-12)
    sideways = np.where(np.abs(along[..., :1]) < 0.99, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    sideways = sideways - along * np.einsum("...i,...i->...", sideways, along)[..., None]
    sideways /= np.linalg.norm(sideways, axis=-1, keepdims=True)
    bent = size > 1e-9 * length * np.linalg.norm(knee - hip, axis=-1, keepdims=True)
    return np.where(bent, axis / np.where(bent, size, 1.0), sideways)


def heading(skeleton: Skeleton) -> float:
    """Yaw in rad about +Y by which the rest pose's facing direction differs from +Z; 0 where left and right are
    unnamed.
    """
    from kinestitch.core.mirror import lateral_axis

    lateral = lateral_axis(skeleton)
    return float(np.arctan2(-lateral[2], lateral[0]))


def turn_about_up(motion: Motion, yaw: float, shift: ArrayLike = (0.0, 0.0, 0.0)) -> Motion:
    """The whole motion turned by `yaw` rad about the world's Y axis through the origin, then moved by `shift` (3,)
    m.
    """
    q = quat_about_axis(1, yaw)
    translations = motion.translations.copy()
    rotations = motion.rotations.copy()
    translations[:, 0] = quat_rotate(q, translations[:, 0]) + np.asarray(shift, dtype=np.float64)
    rotations[:, 0] = quat_multiply(q, rotations[:, 0])
    return replace(motion, translations=translations, rotations=rotations)
