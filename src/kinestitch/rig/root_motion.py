"""Travel taken out of a clip, given to a root joint, and given back: what game engines ask of a clip.

The ground is the plane y = 0. A body's heading is the way its hips face: the yaw nearest to their turn away from rest.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.kinematics import local_from_world, rest_pose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_about_axis,
    quat_conjugate,
    quat_multiply,
    quat_normalize,
    quat_rotate,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.rig.carrier import world_of
from kinestitch.rig.hips import hips_joint

GROUND = (0, 2)


def in_place(motion: Motion, *, turning: bool = True) -> Motion:
    """The motion with its travel over the ground taken out: what carries it is held over the place where it starts.

    turning : keep the body's turns; without them it faces the way it starts in every frame

    In each frame all joints are shifted (and turned about the upright) alike; height stays. The first joint from the
    root down that goes most of the way is held: the hips, or a root joint that carries the travel, below which the hips
    go on swaying.
    """
    joint = traveller(motion)
    position, rotation = world_of(motion, joint)
    place = position[:, GROUND]
    yaw = np.zeros(motion.frames) if turning else _heading(motion, joint, rotation)
    return _moved(motion, place, place[:1], yaw[0] - yaw)


def traveller(motion: Motion) -> int:
    """The first joint from the root down to the hips that goes most of the hips' way over the ground."""
    chain = motion.skeleton.chain(hips_joint(motion.skeleton))
    paths = [world_of(motion, joint)[0][:, GROUND] for joint in chain]
    ways = [path - path[0] for path in paths]
    whole = np.abs(ways[-1]).max()
    return next(joint for joint, way in zip(chain, ways, strict=True) if np.abs(way - ways[-1]).max() <= whole / 2)


def _heading(motion: Motion, joint: int, rotation: Array) -> Array:
    """Yaw (F,) rad, without jumps, of a joint turned by world rotations (F, 4), against its rest."""
    rest = rest_pose(motion.skeleton)[1][joint]
    away = quat_multiply(rotation, quat_conjugate(rest))
    return np.asarray(np.unwrap(2 * np.arctan2(away[:, 1], away[:, 3])))


def _moved(motion: Motion, centre: Array, place: Array, yaw: Array) -> Motion:
    """In each frame the whole body turned by `yaw` (F,) about the upright through `centre` (F, 2), which comes to
    stand at `place` (F, 2).
    """
    turn = quat_about_axis(1, yaw)
    translations, rotations = motion.translations.copy(), motion.rotations.copy()
    root = motion.translations[:, 0] - _upright(centre)
    translations[:, 0] = quat_rotate(turn, root) + _upright(np.broadcast_to(place, centre.shape))
    rotations[:, 0] = quat_normalize(quat_multiply(turn, motion.rotations[:, 0]))
    return replace(motion, translations=translations, rotations=rotations)


def _upright(ground: Array) -> Array:
    """Places (F, 2) on the ground as points (F, 3)."""
    return np.stack([ground[:, 0], np.zeros(len(ground)), ground[:, 1]], axis=-1)


def extract_root(motion: Motion, *, turning: bool = True, smooth: float = 0.0, name: str = "root") -> Motion:
    """The motion with its travel in a root joint that stands on the ground below the hips.

    turning : the root turns with the body's heading too
    smooth : s; heading and path of the root are averaged over this time, so that steps do not shake it
    name : of the root joint that a rig gets whose root is the hips; another rig's own root takes the travel

    All other joints stay where they are in the world (to rounding). At rest a new root stands at the origin.
    """
    if not (np.isfinite(smooth) and smooth >= 0):
        raise ParameterError(f"Expected a smoothing time ≥ 0 s, got {smooth}.")
    hips = hips_joint(motion.skeleton)
    position, rotation = world_of(motion, hips)
    path = _averaged(position[:, GROUND], smooth * motion.fps)
    heading = _heading(motion, hips, rotation)
    yaw = _averaged(heading, smooth * motion.fps) if turning else np.zeros(motion.frames)
    return _with_root_at(motion if hips else _with_root(motion, name), _upright(path), quat_about_axis(1, yaw))


def _with_root_at(motion: Motion, place: Array, turn: Array) -> Motion:
    """The root brought to `place` (F, 3) on the ground and turned by `turn` (F, 4) from rest; nothing else moves."""
    skeleton = motion.skeleton
    children = list(skeleton.children(0))
    rotations, translations = motion.rotations.copy(), motion.translations.copy()
    rotations[:, 0] = quat_multiply(turn, skeleton.rest[0])
    translations[:, 0] = place + skeleton.offsets[0] * np.array([0.0, 1.0, 0.0])
    undo = quat_conjugate(rotations[:, 0])
    for child in children:
        position, rotation = world_of(motion, child)
        rotations[:, child] = quat_multiply(undo, rotation)
        translations[:, child] = quat_rotate(undo, position - translations[:, 0])
    return replace(motion, rotations=quat_normalize(rotations), translations=translations)


def _averaged(values: Array, window: float) -> Array:
    """Values over time (F, …), each the mean of those up to half a window of frames away; beyond the ends a clip is
    taken to go on as it came, turned round (so that steady travel stays as it is).
    """
    half = min(round(window / 2), len(values) - 1)
    if half == 0:
        return values
    before, after = 2 * values[0] - values[half:0:-1], 2 * values[-1] - values[-2 : -half - 2 : -1]
    padded = np.concatenate([np.zeros_like(values[:1]), before, values, after])
    sums = np.cumsum(padded, axis=0)
    return np.asarray((sums[2 * half + 1 :] - sums[: -2 * half - 1]) / (2 * half + 1))


def _with_root(motion: Motion, name: str) -> Motion:
    """The motion below a new root joint at the origin; a number is added to a name that the rig has already."""
    skeleton, frames = motion.skeleton, motion.frames
    number, free = 1, name
    while free in skeleton.names:
        number += 1
        free = f"{name}{number}"
    identity = np.array([[0.0, 0.0, 0.0, 1.0]])
    rooted = Skeleton(
        (free, *skeleton.names),
        (-1, *(parent + 1 for parent in skeleton.parents)),
        np.concatenate([np.zeros((1, 3)), skeleton.offsets]),
        np.concatenate([identity, skeleton.rest]),
        np.concatenate([np.full((1, 3), np.nan), skeleton.tips]),
    )
    translations = np.concatenate([np.zeros((frames, 1, 3)), motion.translations], axis=1)
    rotations = np.concatenate([np.broadcast_to(identity, (frames, 1, 4)), motion.rotations], axis=1)
    return replace(motion, skeleton=rooted, translations=translations, rotations=rotations)


def bake_root(motion: Motion, *, remove: bool = False) -> Motion:
    """The motion of all joints above the hips given to the hips: the inverse of :func:`extract_root`.

    remove : take the root joint away, where nothing but one joint hangs on it; else it stays, at rest

    The hips and all below them stay where they are in the world. Other joints that hang above the hips (props, IK
    targets) stay too; those above the hips stand at rest. A rig whose root is the hips comes back as it is.

    Raises SkeletonMismatchError if the root cannot be removed.
    """
    skeleton = motion.skeleton
    above = skeleton.chain(hips_joint(skeleton))[:-1]
    if not above:
        return motion
    world = world_pose(motion)
    positions, rotations = world.positions.copy(), world.rotations.copy()
    resting = rest_pose(skeleton)
    for joint in above:
        positions[:, joint], rotations[:, joint] = resting[0][joint], resting[1][joint]
    translations, local = local_from_world(skeleton, positions, rotations)
    moving = [j for j in range(skeleton.joint_count) if j in above or skeleton.parents[j] in above]
    kept = [motion.translations.copy(), motion.rotations.copy()]
    kept[0][:, moving], kept[1][:, moving] = translations[:, moving], local[:, moving]
    baked = replace(motion, translations=kept[0], rotations=kept[1])
    return _without_root(baked) if remove else baked


def _without_root(motion: Motion) -> Motion:
    """The motion without its resting root, whose place its only child takes."""
    skeleton = motion.skeleton
    if len(skeleton.children(0)) != 1:
        names = ", ".join(skeleton.names[joint] for joint in skeleton.children(0)[:4])
        raise SkeletonMismatchError(
            f"Expected one joint below the root {skeleton.names[0]!r}, got {names}. Keep the root instead."
        )
    positions, rotations = rest_pose(skeleton)
    offsets, rest = skeleton.offsets[1:].copy(), skeleton.rest[1:].copy()
    offsets[0], rest[0] = positions[1], rotations[1]
    shorter = Skeleton(
        skeleton.names[1:], tuple(parent - 1 for parent in skeleton.parents[1:]), offsets, rest, skeleton.tips[1:]
    )
    translations, turns = motion.translations[:, 1:].copy(), motion.rotations[:, 1:].copy()
    translations[:, 0], turns[:, 0] = world_of(motion, 1)
    return replace(motion, skeleton=shorter, translations=translations, rotations=quat_normalize(turns))
