"""Feet that stand still through a seam: legs bent so that the sources' stances stay where they were placed.

The solve works on rotations and on the path of the hips; feet follow, and slide. Here ankle, foot and toe of a leg that
stands in a source are brought back to where the placed source has them, by analytic two-bone IK: the knee stays in its
own plane and no bone changes its length. The hips come down a little where a leg would be too short.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_rotate
from kinestitch.errors import ParameterError
from kinestitch.rig.hips import hip_height, hips_joint
from kinestitch.solve.contacts import Contacts, Leg, Mask, find_contacts, legs_of
from kinestitch.solve.footing import Window, window_of
from kinestitch.solve.legs import LOWEST, above, lowered
from kinestitch.solve.placed import Placed
from kinestitch.solve.planting import Planted, planted
from kinestitch.solve.seam import clusters
from kinestitch.solve.solved import Solved
from kinestitch.solve.stances import Setting
from kinestitch.solve.swings import ease

BLEND = 0.42
"""s in which a foot comes back from a stance to its solved way, as long as a default seam shows."""

_UP = np.array([0.0, 1.0, 0.0])
_ROUNDS, _NEAR = 2, 1e-4  # in which the hips are lowered, and m that may be missing
_FADE = 0.2  # s beside a window's ends in which they are lowered less


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
        window = window_of(solved.placed, motion, solved.cut, legs, setting)
        masks = [(contacts.of(leg.foot, leg.toe)[here], contacts.of(leg.foot)[here]) for leg in legs]
        down, feet = _planted(window, legs, masks)
        hips = hips_joint(motion.skeleton)
        carrier = above(window.ours, motion.skeleton.parents[hips])
        translations[here, hips] += quat_rotate(quat_conjugate(carrier), down)
        for leg, found in zip(legs, feet, strict=True):
            columns = [contacts.joints.index(joint) for joint in (leg.foot, leg.toe) if joint in contacts.joints]
            held[here, columns] &= found.stands[:, None]
            for joint, values in found.local.items():
                rotations[here, joint] = values
    return Locked(replace(motion, rotations=rotations, translations=translations), Contacts(contacts.joints, held))


def _planted(
    window: Window, legs: Sequence[Leg], masks: Sequence[tuple[Mask, Mask]]
) -> tuple[Array, Sequence[Planted]]:
    """By how much the hips are moved down, (n, 3) m in the world, so that the legs reach where their feet stand, and
    the legs there.
    """
    down, lowest = np.zeros((window.motion.frames, 3)), -LOWEST * window.setting.leg
    for _ in range(_ROUNDS):
        lower = window.moved(down)
        feet = [planted(lower, leg, *mask) for leg, mask in zip(legs, masks, strict=True)]
        missing = np.min(
            [lower.missing(leg, foot.offsets, foot.stands) for leg, foot in zip(legs, feet, strict=True)], 0
        )
        if missing.min() > -_NEAR:
            return down, feet
        more = lowered(missing, window.setting.fps, window.setting.leg) * _inside(window.setting, len(missing))
        down = np.maximum(down + more[:, None] * _UP, lowest)
    lower = window.moved(down)
    return down, [planted(lower, leg, *mask) for leg, mask in zip(legs, masks, strict=True)]


def _inside(setting: Setting, count: int) -> Array:
    """0 in the frames (n,) beside which a window ends, 1 away from them, without a step in value or slope."""
    ends = np.flatnonzero(setting.known(np.zeros(count, dtype=bool)))
    if not len(ends):
        return np.ones(count)
    away = np.abs(np.arange(count)[:, None] - ends).min(axis=1) / (_FADE * setting.fps)
    return ease(away)
