"""Pins of the body as a whole: every frame moved on the ground, all joints alike.

Waypoints and headings bend the path, root pins move it, and behind the last of them the rest rides along rigidly. A
return bends the way so that behind it nothing has to be moved at all.
"""

from __future__ import annotations

import math
import warnings
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.kinematics import heading, rest_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_about_axis, quat_conjugate, quat_multiply, quat_normalize, quat_rotate
from kinestitch.edit.pins import Pin, away_again
from kinestitch.errors import KinestitchWarning, ParameterError
from kinestitch.rig.carrier import world_of
from kinestitch.rig.hips import hip_height, hips_joint
from kinestitch.solve.bend import Complex
from kinestitch.solve.joint_pins import correction_of
from kinestitch.solve.placed import Placed
from kinestitch.solve.ways import Home, Way, pinned_way, stretches

GROUND_KINDS = ("root", "heading", "waypoint", "return")
RISING = 0.2
"""s over which the body rises to a root pin's height, where the pin says nothing else."""

_FLAT = 0.1


@dataclass(frozen=True, eq=False, slots=True)
class GroundMove:
    """For every frame a rigid move of the body: turned by `yaw` (F,) rad about the upright through `origin` (F,) m,
    which comes to stand at `place` (F,) m, both z + ix, and raised by `lift` (F,) m.
    """

    yaw: Array
    origin: Complex
    place: Complex
    lift: Array

    @property
    def frames(self) -> NDArray[np.intp]:
        """The frames that are moved at all."""
        return np.flatnonzero((self.yaw != 0) | (self.origin != self.place) | (self.lift != 0))

    def points(self, points: Array, frames: NDArray[np.intp]) -> Array:
        """Points (n, 3) m of the unmoved world as the moves of `frames` (n,) take them along."""
        flat = (points[:, 2] + 1j * points[:, 0] - self.origin[frames]) * np.exp(1j * self.yaw[frames])
        flat += self.place[frames]
        return np.stack([flat.imag, points[:, 1] + self.lift[frames], flat.real], axis=1)


def ground_move(motion: Motion, placed: Placed, pins: Sequence[Pin]) -> GroundMove:
    """Where the pins of the body as a whole take each frame of a solved motion (Eq. 31 to 33).

    pins : of kinds root, heading, waypoint and return, in the order of their frames

    Raises ParameterError for pins that cannot be met.
    """
    if away := away_again(pins):
        warnings.warn(KinestitchWarning(away), stacklevel=2)
    hips = hips_joint(motion.skeleton)
    position, rotation = world_of(motion, hips)
    origin = position[:, 2] + 1j * position[:, 0]
    homes = [_home(placed, pin, origin) for pin in pins if pin.kind == "return"]
    headings = {pin.frame: _heading(motion, hips, rotation[pin.frame], pin) for pin in pins if pin.kind == "heading"}
    way = Way(origin, np.zeros(motion.frames))
    for stretch in stretches([pin for pin in pins if pin.kind != "return"], homes, motion.fps):
        way = pinned_way(way, stretch, headings, motion.fps)
    roots = [pin for pin in pins if pin.kind == "root"]
    heights = np.array([[pin.target[1]] for pin in roots])
    lift = np.zeros((motion.frames, 1))
    if heights.any():
        lift = correction_of(roots, heights, motion.frames, motion.fps, RISING)
        _tell_lift(roots, lift[:, 0], hip_height(motion.skeleton))
    return GroundMove(way.yaw, origin, way.place, lift[:, 0])


def _tell_lift(roots: Sequence[Pin], lift: Array, most: float) -> None:
    for pin in roots:
        up = float(lift[pin.frame])
        word = "lifts" if up > 0 else "sinks"
        if abs(up) > most:
            warnings.warn(
                KinestitchWarning(
                    f"{pin} {word} the body by {abs(up):.3g} m, more than the {most:.2g} m from "
                    "ankles to hips. The middle number is how much higher than solved it stands; 0 leaves its height."
                ),
                stacklevel=2,
            )


def _home(placed: Placed, pin: Pin, origin: Complex) -> Home:
    """The inverse of the placement that the segment of a return was given."""
    placement = placed.placements[bisect_right(placed.starts, pin.frame) - 1]
    there = (origin[pin.frame] - complex(placement.z, placement.x)) * np.exp(-1j * placement.yaw)
    return Home(pin.frame, complex(there), math.remainder(-placement.yaw, 2 * math.pi), pin.smoothing or 0.0)


def _heading(motion: Motion, hips: int, rotation: Array, pin: Pin) -> float:
    """Which way the hips face (rad, 0 is +Z), turned by a world rotation (4,)."""
    _, y, _, w = quat_multiply(rotation, quat_conjugate(rest_pose(motion.skeleton)[1][hips]))
    if np.hypot(y, w) < _FLAT:
        raise ParameterError(f"Expected a body that faces somewhere for {pin}, got one upside down.")
    return float(heading(motion.skeleton) + 2 * np.arctan2(y, w))


def moved(motion: Motion, move: GroundMove, joint: int) -> Motion:
    """The motion with everything from `joint` down moved; frames that are not moved stay bit by bit."""
    frames = move.frames
    if not len(frames):
        return motion
    part = replace(motion, translations=motion.translations[frames], rotations=motion.rotations[frames])
    position, rotation = world_of(part, joint)
    position = move.points(position, frames)
    rotation = quat_multiply(quat_about_axis(1, move.yaw[frames]), rotation)
    parent = motion.skeleton.parents[joint]
    if parent >= 0:
        above, frame = world_of(part, parent)
        position = quat_rotate(quat_conjugate(frame), position - above)
        rotation = quat_multiply(quat_conjugate(frame), rotation)
    translations, rotations = motion.translations.copy(), motion.rotations.copy()
    translations[frames, joint], rotations[frames, joint] = position, quat_normalize(rotation)
    return replace(motion, translations=translations, rotations=rotations)
