"""Feet that stand still through a seam: legs bent so that the sources' stances stay where they were placed.

The solve works on rotations and on the path of the hips; feet follow, and slide. Here ankle, foot and toe of a leg that
stands in a source are brought back to where the placed source has them, by analytic two-bone IK: the knee stays in its
own plane, no bone changes its length, and the hips are not touched.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.kinematics import WorldPose, two_bone_ik, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.errors import ParameterError
from kinestitch.rig.hips import hip_height
from kinestitch.solve.contacts import SHORTEST, Contacts, Leg, Mask, find_contacts, legs_of
from kinestitch.solve.placed import Placed
from kinestitch.solve.seam import Cluster, clusters
from kinestitch.solve.solved import Solved
from kinestitch.solve.stances import FootPath, carry_over, raised, wanted_path

Frames = NDArray[np.intp]

BLEND = 0.15
"""s in which a foot leaves its solved way to a stance, or comes back to it."""

_SOFT = 0.97  # of a leg's length, from which a target is approached ever more slowly
_STRAIGHT = np.radians(4.0)  # knees bent less have no plane that could be trusted
_RISE = 0.6  # of the blend in which a foot leaves the ground, so that it does not pass low over it
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

    Only legs change, only within the windows of seams, and only where a stance is, or within `blend` of one. A target
    out of a leg's reach is approached, never with the leg straighter than the solve had it or than a soft limit. Feet
    that do not stand in any source, and hard cuts, are left alone.

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
    rotations, held = motion.rotations.copy(), contacts.held.copy()
    for cluster in clusters(solved.seams, motion.frames):
        here = slice(cluster.start, cluster.stop)
        bounded = (cluster.start > 0, cluster.stop < motion.frames)
        frames = max(2, round(blend * motion.fps))
        window = _Window(cluster, bounded, _part(motion, here), _part(solved.cut, here), frames)
        for leg in legs:
            stands, changed = window.bent(leg, contacts.of(leg.foot, leg.toe)[here])
            columns = [contacts.joints.index(joint) for joint in (leg.foot, leg.toe) if joint in contacts.joints]
            held[here, columns] &= stands[:, None]
            for joint, (rows, values) in changed.items():
                rotations[rows + cluster.start, joint] = values
    return Locked(replace(motion, rotations=rotations), Contacts(contacts.joints, held))


def _part(motion: Motion, frames: slice) -> Motion:
    return replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])


@dataclass(frozen=True, eq=False, slots=True)
class _Window:
    """One cluster's frames of the result and of the hard cut."""

    cluster: Cluster
    bounded: tuple[bool, bool]
    motion: Motion
    cut: Motion
    blend: int

    def bent(self, leg: Leg, held: Mask) -> tuple[Mask, dict[int, tuple[Frames, Array]]]:
        """The frames (n,) in which a foot stands, and for each changed joint of its leg the frames (from the window's
        start) and its local rotations there.
        """
        if not held.any():
            return held, {}
        ours, theirs = world_pose(self.motion), world_pose(self.cut)
        now, placed = foot_path(ours, leg), foot_path(theirs, leg)
        size, shortest = hip_height(self.motion.skeleton), round(SHORTEST * self.motion.fps)
        goal = wanted_path(
            placed, held, self.cluster, bounded=self.bounded, leg=size, blend=self.blend, shortest=shortest
        )
        away = quat_to_rotvec(quat_multiply(goal.path.turn, quat_conjugate(now.turn)))
        there = np.ones((len(held), 1))
        offsets = np.concatenate([goal.path.pivot - now.pivot, away, self._toe_offsets(leg), there], axis=1)
        level = carry_over(offsets, goal.stands, self.blend)
        level[:, 1:2] = carry_over(offsets[:, 1:2], goal.stands, max(2, round(_RISE * self.blend)))
        offsets = level
        swings = ~goal.stands
        offsets[swings, 1] += raised(now.pivot[:, 1] + offsets[:, 1], goal.low)[swings]
        frames = np.flatnonzero(np.abs(offsets[:, :9]).max(axis=1) > _STILL)
        if not len(frames):
            return goal.stands, {}
        pose = WorldPose(ours.positions[frames], ours.rotations[frames])
        stretch = np.linalg.norm(theirs.positions[frames, leg.foot] - theirs.positions[frames, leg.thigh], axis=-1)
        local = bent_leg(
            pose, self.motion.rotations[frames], leg, offsets[frames], stretch, self.motion.skeleton.parents
        )
        return goal.stands, {joint: (frames, values) for joint, values in local.items()}

    def _toe_offsets(self, leg: Leg) -> Array:
        """From the result's local rotation of the toe to the source's, as rotation vectors (n, 3)."""
        if leg.toe is None:
            return np.zeros((self.motion.frames, 3))
        there, here = self.cut.rotations[:, leg.toe], self.motion.rotations[:, leg.toe]
        return quat_to_rotvec(quat_multiply(there, quat_conjugate(here)))


def foot_path(pose: WorldPose, leg: Leg) -> FootPath:
    pivot = leg.foot if leg.toe is None else leg.toe
    return FootPath(pose.positions[:, pivot], pose.rotations[:, leg.foot])


def bent_leg(
    pose: WorldPose, local: Array, leg: Leg, offsets: Array, stretch: Array, parents: tuple[int, ...]
) -> dict[int, Array]:
    """Local rotations of a leg's joints whose foot is moved and turned by `offsets`: (n, 10) m of the pivot, rad of the
    foot in the world, rad of the toe, and how much of the way to its stance the foot is.

    stretch : (n,) m from hip joint to ankle in the source
    """
    pivot = leg.foot if leg.toe is None else leg.toe
    hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    turned = rotvec_to_quat(offsets[:, 3:6])
    target = pose.positions[:, pivot] + offsets[:, :3] + quat_rotate(turned, ankle - pose.positions[:, pivot])
    target = within_reach(hip, knee, ankle, target, stretch)
    first, second = unlocked(pose, leg, offsets[:, 9])
    bent_knee = hip + quat_rotate(first, knee - hip)
    by_thigh, by_shin = two_bone_ik(hip, bent_knee, bent_knee + quat_rotate(second, ankle - knee), target)
    by_thigh, by_shin = quat_multiply(by_thigh, first), quat_multiply(by_shin, second)
    thigh, shin, foot = (pose.rotations[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    above = _above(pose, parents[leg.thigh])
    out = {
        leg.thigh: quat_multiply(quat_conjugate(above), quat_multiply(by_thigh, thigh)),
        leg.shin: _local(pose.rotations[:, parents[leg.shin]], by_thigh, quat_multiply(by_shin, shin)),
        leg.foot: _local(pose.rotations[:, parents[leg.foot]], by_shin, quat_multiply(turned, foot)),
    }
    if leg.toe is not None:
        out[leg.toe] = quat_multiply(rotvec_to_quat(offsets[:, 6:9]), local[:, leg.toe])
    return {joint: quat_normalize(_same_sign(values, local[:, joint])) for joint, values in out.items()}


def _above(pose: WorldPose, parent: int) -> Array:
    if parent < 0:
        return np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(pose.rotations), 4))
    return pose.rotations[:, parent]


def _local(parent: Array, turned: Array, world: Array) -> Array:
    """Local rotations of a joint that shall stand as `world`, its parent having been turned from the left."""
    return quat_multiply(quat_conjugate(quat_multiply(turned, parent)), world)


def _same_sign(values: Array, like: Array) -> Array:
    return np.where(np.einsum("fi,fi->f", values, like)[:, None] < 0, -values, values)


def within_reach(hip: Array, knee: Array, ankle: Array, target: Array, stretch: Array) -> Array:
    """Targets (n, 3) drawn towards the hip joint where the leg would have to be straighter than it is, than in the
    source (`stretch`, (n,) m from hip joint to ankle) and than a soft limit; nearer ones stay.
    """
    length = np.linalg.norm(knee - hip, axis=-1) + np.linalg.norm(ankle - knee, axis=-1)
    own = np.maximum(np.linalg.norm(ankle - hip, axis=-1), np.minimum(stretch, 0.9999 * length))
    wanted = np.linalg.norm(target - hip, axis=-1)
    soft, rest = _SOFT * length, (0.998 - _SOFT) * length
    eased = np.where(wanted > soft, soft + rest * (1 - np.exp(-np.maximum(wanted - soft, 0.0) / rest)), wanted)
    reach = np.where(wanted <= own, wanted, np.maximum(eased, own))
    return np.asarray(hip + (target - hip) * (reach / np.maximum(wanted, 1e-12))[:, None])


def unlocked(pose: WorldPose, leg: Leg, share: Array) -> tuple[Array, Array]:
    """World turns (n, 4) of thigh and shin that give a straight or overstretched knee a slight bend, `share` (n,) of
    it, in the plane in which this knee bends elsewhere.
    """
    hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    thigh = pose.rotations[:, leg.thigh]
    axis = quat_rotate(quat_conjugate(thigh), np.cross(knee - hip, ankle - knee)).sum(axis=0)
    size = float(np.linalg.norm(axis))
    hinge = quat_rotate(thigh, np.broadcast_to(axis / max(size, 1e-12), hip.shape))
    return slightly_bent(knee - hip, ankle - knee, hinge, share if size >= 1e-9 else np.zeros_like(share))


def slightly_bent(upper: Array, lower: Array, hinge: Array, share: Array) -> tuple[Array, Array]:
    """World turns (n, 4) of an upper and a lower bone (n, 3) that are straight or overstretched, by which they are bent
    a little about their hinge (n, 3) of length 1, `share` (n,) of it.
    """
    sine = np.einsum("fi,fi->f", np.cross(upper, lower), hinge)
    bend = np.arctan2(sine, np.einsum("fi,fi->f", upper, lower))
    missing = np.maximum(_STRAIGHT - bend, 0.0) * np.clip(share, 0.0, 1.0)
    back = -missing / 2
    return rotvec_to_quat(hinge * back[:, None]), rotvec_to_quat(hinge * (back + missing)[:, None])
