"""Feet that stand still through a seam: legs bent so that the sources' stances stay where they were placed.

The solve works on rotations and on the path of the hips; feet follow, and slide. Here ankle, foot and toe of a leg that
stands in a source are brought back to where the placed source has them, by analytic two-bone IK: the knee stays in its
own plane and no bone changes its length. The hips come down a little where a leg would be too short.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.kinematics import WorldPose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_continuous, quat_log, quat_multiply, quat_rotate
from kinestitch.errors import ParameterError
from kinestitch.rig.hips import hip_height, hips_joint
from kinestitch.solve.contacts import Contacts, Leg, Mask, find_contacts, legs_of
from kinestitch.solve.legs import (
    above,
    ankle_moved,
    bent_leg,
    leg_pose,
    lowered,
    missing_height,
    pivot_of,
    stretched,
)
from kinestitch.solve.placed import Placed
from kinestitch.solve.seam import clusters
from kinestitch.solve.solved import Solved
from kinestitch.solve.stances import FootPath, Setting, wanted_stances
from kinestitch.solve.swings import GROUND, carry_heights, carry_over, clearance, floor_under, step_arcs

Frames = NDArray[np.intp]

BLEND = 0.42
"""s in which a foot comes back from a stance to its solved way, as long as a default seam shows."""

_UP = np.array([0.0, 1.0, 0.0])
_FARTHEST = 0.03  # leg lengths that the hips come down for a stance's ends
_STILL = 1e-7  # m and rad; less is left alone


@dataclass(frozen=True, eq=False, slots=True)
class Locked:
    """A result whose feet are locked, and the contacts it keeps: those of its sources without the ones that a step over
    a seam takes the place of.
    """

    motion: Motion
    contacts: Contacts


def placed_contacts(placed: Placed) -> Contacts:
    """The contacts of a timeline's sources, on the frames of its result.

    Raises SkeletonMismatchError for a rig without feet.
    """
    found = {key: find_contacts(motion) for key, motion in placed.sources.items()}
    segments = placed.timeline.segments
    held = [found[segment.clip].held[segment.range.start : segment.range.stop] for segment in segments]
    return Contacts(found[segments[0].clip].joints, np.concatenate(held))


def lock_feet(solved: Solved, contacts: Contacts | None = None, *, blend: float = BLEND) -> Motion:
    """The result of a solve with its feet held where they stand in the placed sources; see :func:`locked`."""
    return locked(solved, contacts, blend=blend).motion


def locked(solved: Solved, contacts: Contacts | None = None, *, blend: float = BLEND) -> Locked:
    """Hold the feet of a result where they stand in the placed sources.

    contacts : on the frames of the result, :func:`placed_contacts` when left out; blend : s

    Only legs and the height of the hips change, and only within the windows of seams. Before and after a stance a foot
    leaves its solved way as a gap is closed by the solve. A stance near a seam is given up where holding it would throw
    the foot. A target out of a leg's reach is approached, never with the leg straighter than the solve or the source
    has it, or than a soft limit. Hard cuts, and feet that stand in no source, are left alone.

    Raises SkeletonMismatchError for a rig without feet, ParameterError for a wrong number of frames or blend ≤ 0.
    """
    if not (np.isfinite(blend) and blend > 0):
        raise ParameterError(f"Expected a blend in s > 0, got {blend}.")
    motion = solved.motion
    legs = legs_of(motion.skeleton)
    contacts = placed_contacts(solved.placed) if contacts is None else contacts
    if len(contacts.held) != motion.frames:
        raise ParameterError(f"Expected contacts for {motion.frames} frames, got {len(contacts.held)}.")
    if solved.motion is solved.cut or not contacts.held.any():
        return Locked(motion, contacts)
    rotations, translations, held = motion.rotations.copy(), motion.translations.copy(), contacts.held.copy()
    for cluster in clusters(solved.seams, motion.frames, solved.placed.firm):
        here = slice(cluster.start, cluster.stop)
        bounded = (cluster.start > 0, cluster.stop < motion.frames)
        setting = Setting(cluster, bounded, motion.fps, hip_height(motion.skeleton), blend * motion.fps)
        window = _window(_part(motion, here), _part(solved.cut, here), setting)
        goals = [_goal(window, leg, contacts.of(leg.foot, leg.toe)[here], contacts.of(leg.foot)[here]) for leg in legs]
        down = _hips_down(window, legs, goals)
        hips = hips_joint(motion.skeleton)
        lifted = above(window.ours, motion.skeleton.parents[hips])
        translations[here, hips] += quat_rotate(quat_conjugate(lifted), down)
        for leg, goal in zip(legs, goals, strict=True):
            columns = [contacts.joints.index(joint) for joint in (leg.foot, leg.toe) if joint in contacts.joints]
            held[here, columns] &= goal.stands[:, None]
            frames, local = _bent(window, leg, goal, down)
            for joint, values in local.items():
                rotations[cluster.start + frames, joint] = values
    return Locked(replace(motion, rotations=rotations, translations=translations), Contacts(contacts.joints, held))


def _part(motion: Motion, frames: slice) -> Motion:
    return replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])


@dataclass(frozen=True, eq=False, slots=True)
class _Window:
    """One cluster's frames of the result and of the hard cut, local and in the world."""

    motion: Motion
    cut: Motion
    ours: WorldPose
    theirs: WorldPose
    setting: Setting


def _window(motion: Motion, cut: Motion, setting: Setting) -> _Window:
    return _Window(motion, cut, world_pose(motion), world_pose(cut), setting)


@dataclass(frozen=True, eq=False, slots=True)
class _Goal:
    """What a foot shall do in a window.

    offsets : (n, 9) m by which its pivot is moved, rad by which it is turned in the world, and its toe against it
    stands : (n,) frames in which it stands
    """

    offsets: Array
    stands: Mask


def _goal(window: _Window, leg: Leg, held: Mask, flat: Mask) -> _Goal:
    """held, flat : (n,) frames in which the foot stands in the sources, and in which its heel does"""
    now, placed, setting = foot_path(window.ours, leg), foot_path(window.theirs, leg), window.setting

    def far(path: FootPath) -> Mask:
        return np.asarray(_missing(window, leg, _offsets(path, now), held) < -_FARTHEST * setting.leg)

    stances, stands = wanted_stances(placed, now, (held, flat), far, setting)
    there = stances.path
    offsets = np.concatenate([_offsets(there, now), stances.evened(_toe_offsets(window, leg))], axis=1)
    if not held.any():
        return _Goal(np.zeros(offsets.shape), stands)
    offsets[~stands] = 0.0
    known = setting.known(stands)
    carried = carry_over(offsets, known, setting.blend, breaks=setting.hard)
    arcs = step_arcs(stands, held & ~stands, there.pivot[:, GROUND], setting.leg)
    path = now.pivot[:, GROUND] + carried[:, GROUND]
    least = floor_under(placed.pivot[:, 1], setting.blend) + arcs + _clearance(path, placed, setting)
    carried[:, 1] = carry_heights(offsets[:, 1], known, least - now.pivot[:, 1], setting.blend, setting.hard)
    return _Goal(carried, stands)


def _offsets(path: FootPath, now: FootPath) -> Array:
    """From where a foot is to a path: (n, 6), m of its pivot and rad of its turn in the world."""
    turns = quat_multiply(path.turn, quat_conjugate(now.turn))
    return np.concatenate([path.pivot - now.pivot, _rotvecs(turns)], axis=1)


def foot_path(pose: WorldPose, leg: Leg) -> FootPath:
    """Where a foot is, by the joint about which it rolls."""
    return FootPath(pose.positions[:, pivot_of(leg)], pose.rotations[:, leg.foot])


def _clearance(path: Array, placed: FootPath, setting: Setting) -> Array:
    seams = setting.cluster.local_frames
    return clearance(path, placed.pivot[:, GROUND], seams=seams, fps=setting.fps, leg=setting.leg)


def _rotvecs(turns: Array) -> Array:
    """Rotation vectors (n, 3) of turns (n, 4), continuous in time."""
    turns = quat_continuous(turns)
    return quat_log(-turns if turns[:, 3].sum() < 0 else turns)


def _toe_offsets(window: _Window, leg: Leg) -> Array:
    """From the result's local rotation of the toe to the source's, as rotation vectors (n, 3)."""
    if leg.toe is None:
        return np.zeros((window.motion.frames, 3))
    there, here = window.cut.rotations[:, leg.toe], window.motion.rotations[:, leg.toe]
    return _rotvecs(quat_multiply(there, quat_conjugate(here)))


def _missing(window: _Window, leg: Leg, offsets: Array, stands: Mask) -> Array:
    """By how much (n,) m ≤ 0 the hips are too high for a foot that is moved by `offsets`, where it stands."""
    pose = leg_pose(window.ours, leg, stretched(window.theirs, leg))
    return missing_height(pose, ankle_moved(window.ours, leg, offsets), stands)


def _hips_down(window: _Window, legs: Sequence[Leg], goals: Sequence[_Goal]) -> Array:
    """By how much the hips are moved down, (n, 3) m in the world."""
    missing = np.min(
        [_missing(window, leg, goal.offsets, goal.stands) for leg, goal in zip(legs, goals, strict=True)], axis=0
    )
    if missing.min() > -_STILL:
        return np.zeros((len(missing), 3))
    return lowered(missing, window.setting.fps, window.setting.leg)[:, None] * _UP


def _bent(window: _Window, leg: Leg, goal: _Goal, down: Array) -> tuple[Frames, Mapping[int, Array]]:
    """The frames in which a leg changes, and its joints' local rotations there."""
    frames = np.flatnonzero(np.abs(np.concatenate([goal.offsets, down], axis=1)).max(axis=1) > _STILL)
    pose = WorldPose(window.ours.positions[frames] + down[frames, None], window.ours.rotations[frames])
    offsets, stretch = goal.offsets[frames].copy(), stretched(window.theirs, leg)[frames]
    offsets[:, :3] -= down[frames]
    motion = window.motion
    return frames, bent_leg(pose, motion.rotations[frames], leg, offsets, stretch, motion.skeleton.parents)
