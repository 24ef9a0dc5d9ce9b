"""A clip that repeats: its ends made to meet, its travel kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_distance,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.errors import RangeError
from kinestitch.rig.carrier import world_of
from kinestitch.rig.hips import hip_height
from kinestitch.rig.root_motion import GROUND, traveller

_SHORTEST = 0.5
_MOVES = 0.1  # s, by which a gap in speed counts as one in place


def loop(motion: Motion, *, trim: bool = True) -> Motion:
    """The motion as one cycle: its last frame repeats the pose of its first, so that copies can follow each other.

    trim : end at the frame of the second half that fits the first best, in pose and speed; else the whole clip counts

    What is left of the difference between both ends is spread evenly over the cycle, half of it before and half of it
    after its middle: for every joint's rotation and translation, and for the lean and height of the joint that carries
    the travel. Its way over the ground stays, and so does the turn of its heading: where a cycle turns, the next one
    starts turned. Joints above it stand as in the first frame.

    Raises RangeError for a clip of fewer than three frames.
    """
    if motion.frames < 3:
        raise RangeError(f"Expected a clip of at least 3 frames, got {motion.frames}.")
    carrier = traveller(motion)
    translations, rotations = _told_in_world(motion, carrier)
    frames = best_end(motion) + 1 if trim else motion.frames
    share = (np.arange(frames) / (frames - 1) - 0.5)[:, None, None]
    rotations, translations = rotations[:frames], translations[:frames]
    turns = quat_multiply(quat_conjugate(rotations[-1]), rotations[0])
    start = rotations[0, carrier]
    lean = _without_yaw(quat_multiply(rotations[-1, carrier], quat_conjugate(start)))
    turns[carrier] = quat_multiply(quat_conjugate(start), quat_multiply(quat_conjugate(lean), start))
    gaps = translations[0] - translations[-1]
    gaps[carrier, GROUND] = 0.0
    rotations = quat_multiply(rotations, rotvec_to_quat(share * quat_to_rotvec(turns)))
    return _told_locally(motion, carrier, translations + share * gaps, rotations)


def _told_in_world(motion: Motion, carrier: int) -> tuple[Array, Array]:
    """Translations (F, J, 3) and rotations (F, J, 4) with the carrier's in the world, and all above it at frame 0's."""
    translations, rotations = motion.translations.copy(), motion.rotations.copy()
    translations[:, carrier], rotations[:, carrier] = world_of(motion, carrier)
    for joint in motion.skeleton.chain(carrier)[:-1]:
        translations[:, joint], rotations[:, joint] = motion.translations[0, joint], motion.rotations[0, joint]
    return translations, rotations


def _told_locally(motion: Motion, carrier: int, translations: Array, rotations: Array) -> Motion:
    """The inverse of :func:`_told_in_world`, for any number of frames."""
    parent = motion.skeleton.parents[carrier]
    if parent >= 0:
        place, turn = (values[0] for values in world_of(motion, parent))
        undo = quat_conjugate(turn)
        translations[:, carrier] = quat_rotate(undo, translations[:, carrier] - place)
        rotations[:, carrier] = quat_multiply(undo, rotations[:, carrier])
    return replace(motion, translations=translations, rotations=quat_normalize(rotations))


def best_end(motion: Motion) -> int:
    """The frame of the second half whose pose and speed are nearest to the first frame's.

    Where the body is on the ground, and in which direction it looks, does not count.
    """
    carrier = traveller(motion)
    translations, rotations = _told_in_world(motion, carrier)
    ends = np.arange(max(2, int(motion.frames * _SHORTEST)), motion.frames)
    away = quat_distance(rotations[ends], rotations[0])
    between = quat_multiply(rotations[ends, carrier], quat_conjugate(rotations[0, carrier]))
    away[:, carrier] = quat_distance(_without_yaw(between), [0.0, 0.0, 0.0, 1.0])
    steps = quat_to_rotvec(quat_multiply(quat_conjugate(rotations[:-1]), rotations[1:])) * motion.fps * _MOVES
    faster = np.linalg.norm(steps[ends - 1] - steps[0], axis=-1)
    height = translations[:, carrier, 1] / hip_height(motion.skeleton)
    costs = (away**2 + faster**2).mean(axis=-1) + (height[ends] - height[0]) ** 2
    return int(ends[np.argmin(costs)])


def _without_yaw(turn: Array) -> Array:
    """What is left of rotations (..., 4) when the nearest turn about the upright is taken out from the left."""
    yaw = turn * np.array([0.0, 1.0, 0.0, 1.0])
    return quat_multiply(quat_conjugate(quat_normalize(yaw)), turn)
