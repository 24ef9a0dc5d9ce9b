"""Bodies for the tests of loops: hips at the root, and a walk along a bend."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_multiply, quat_rotate
from kinestitch.samples import sample


def hips_first(motion: Motion) -> Motion:
    """The motion with its root called the hips."""
    names = ("Hips", *motion.skeleton.names[1:])
    return replace(motion, skeleton=replace(motion.skeleton, names=names))


def turning_walk(per_second: float = 0.5) -> Motion:
    """The sample walk bent into a curve: rad/s about the upright."""
    walk = sample("walk")
    yaw = np.arange(walk.frames) / walk.fps * per_second
    turn = quat_about_axis(1, yaw)
    rotations, translations = walk.rotations.copy(), walk.translations.copy()
    steps = np.diff(walk.translations[:, 0], axis=0)
    middle = quat_about_axis(1, (yaw[1:] + yaw[:-1]) / 2)
    translations[1:, 0, [0, 2]] = np.cumsum(quat_rotate(middle, steps), axis=0)[:, [0, 2]] + translations[0, 0, [0, 2]]
    rotations[:, 0] = quat_multiply(turn, rotations[:, 0])
    return replace(walk, rotations=rotations, translations=translations)
