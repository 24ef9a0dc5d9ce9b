"""The joint that carries the travel, and how to give its travel to another one on the way to the hips."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_about_axis, quat_conjugate, quat_multiply, quat_normalize, quat_rotate
from kinestitch.rig.hips import hips_joint

_STILL = 1e-4  # m and rad; what moves less is a static dummy above the hips


def carrier_joint(motion: Motion) -> int:
    """The joint that carries the travel: the first one from the root down to the hips that moves against its parent."""
    chain = motion.skeleton.chain(hips_joint(motion.skeleton))
    few = [0, motion.frames // 2, motion.frames - 1]  # nearly always enough, and quick
    for frames in (few, slice(None)):
        for joint in chain:
            if _moves(motion.translations[frames, joint], motion.rotations[frames, joint]):
                return joint
            if frames is few:
                break
    return chain[-1]


def _moves(translations: Array, rotations: Array) -> bool:
    turned = 1.0 - np.abs(rotations @ rotations[0]).min()
    return bool(np.abs(translations - translations[0]).max() > _STILL or turned > _STILL**2)


def with_world_carrier(motion: Motion, carrier: int) -> Motion:
    """The motion with its carrier told in the world, and the joints above it at rest in their first pose.

    The carrier's local numbers become world position and rotation: what stands above it (a dummy, an armature) is
    folded in, together with any travel of its own. A motion whose carrier is the root comes back as it is.
    """
    if carrier == 0:
        return motion
    position, rotation = world_of(motion, carrier)
    translations = motion.translations.copy()
    rotations = motion.rotations.copy()
    above = motion.skeleton.chain(carrier)[:-1]
    for joint in above:
        translations[:, joint] = motion.translations[0, joint]
        rotations[:, joint] = motion.rotations[0, joint]
    translations[:, carrier] = position
    rotations[:, carrier] = rotation
    return replace(motion, translations=translations, rotations=rotations)


def with_local_carrier(motion: Motion, carrier: int) -> Motion:
    """The inverse of :func:`with_world_carrier`: the carrier told in its parent's frame, which stands still."""
    if carrier == 0:
        return motion
    first = replace(motion, translations=motion.translations[:1], rotations=motion.rotations[:1])
    place, turn = (values[0] for values in world_of(first, motion.skeleton.parents[carrier]))
    undo = quat_conjugate(turn)
    translations, rotations = motion.translations.copy(), motion.rotations.copy()
    translations[:, carrier] = quat_rotate(undo, translations[:, carrier] - place)
    rotations[:, carrier] = quat_multiply(undo, rotations[:, carrier])
    return replace(motion, translations=translations, rotations=quat_normalize(rotations))


def world_of(motion: Motion, joint: int) -> tuple[Array, Array]:
    """World positions (F, 3) m and rotations (F, 4) of one joint."""
    position = np.zeros((motion.frames, 3))
    rotation = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (motion.frames, 4))
    for above in motion.skeleton.chain(joint):
        position = position + quat_rotate(rotation, motion.translations[:, above])
        rotation = quat_multiply(rotation, motion.rotations[:, above])
    return position, rotation


def lift_travel(motion: Motion, carrier: int, own: int) -> Motion:
    """Give the ground travel of the joint `own` to the joint `carrier` above it; nothing moves in the world."""
    path, _ = world_of(motion, own)
    travel = path - path[0]
    travel[:, 1] = 0.0
    _, frame = world_of(motion, carrier)
    parent = motion.skeleton.parents[carrier]
    parent_frame = world_of(motion, parent)[1] if parent >= 0 else quat_about_axis(1, np.zeros(motion.frames))
    translations = motion.translations.copy()
    translations[:, carrier] += quat_rotate(quat_conjugate(parent_frame), travel)
    below = motion.skeleton.chain(own)[len(motion.skeleton.chain(carrier))]
    translations[:, below] -= quat_rotate(quat_conjugate(frame), travel)
    return replace(motion, translations=translations)
