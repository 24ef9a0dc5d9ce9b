"""What legs can reach: targets drawn nearer, hips lowered, and a leg bent to its target by two-bone IK."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d

from kinestitch.core.kinematics import WorldPose, two_bone_ik
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    rotvec_to_quat,
)
from kinestitch.solve.contacts import Leg, Mask
from kinestitch.solve.swings import GROUND, smoothed

LOWEST = 0.06
"""Leg lengths that the hips may come down."""

_SOFT, _STRAIGHTEST = 0.97, 0.998  # of a leg's length: up to where it may stretch freely, and at all
_EASE = 0.25  # s over which they do
_BENT, _SOFTLY = np.radians(8.0), np.radians(2.0)  # knees bent less have no plane that could be trusted
_NEAR = 0.01  # m by which an ankle is moved until its knee is bent by half of what is missing


@dataclass(frozen=True, eq=False, slots=True)
class LegPose:
    """A leg in the world, frame by frame: (n, 3) m.

    stretch : (n,) m from hip joint to ankle that its source has
    """

    hip: Array
    knee: Array
    ankle: Array
    stretch: Array

    @property
    def length(self) -> Array:
        """Thigh and shin, (n,) m."""
        return np.linalg.norm(self.knee - self.hip, axis=-1) + np.linalg.norm(self.ankle - self.knee, axis=-1)

    @property
    def longest(self) -> Array:
        """How far the leg may be stretched at most: (n,) m."""
        return np.maximum(_STRAIGHTEST * self.length, self.own)

    @property
    def own(self) -> Array:
        """How far the leg is stretched, here or in its source, whichever is more: (n,) m."""
        return np.maximum(
            np.linalg.norm(self.ankle - self.hip, axis=-1), np.minimum(self.stretch, 0.9999 * self.length)
        )


def leg_pose(pose: WorldPose, leg: Leg, stretch: Array) -> LegPose:
    """A leg of a posed body; stretch : (n,) m, its source's."""
    hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    return LegPose(hip, knee, ankle, stretch)


def stretched(pose: WorldPose, leg: Leg) -> Array:
    """From hip joint to ankle, (n,) m."""
    return np.asarray(np.linalg.norm(pose.positions[:, leg.foot] - pose.positions[:, leg.thigh], axis=-1))


def within_reach(pose: LegPose, target: Array) -> Array:
    """Targets (n, 3) m drawn towards the hip joint where the leg would have to be straighter than it is, than in the
    source and than a soft limit; nearer ones stay.
    """
    wanted = np.linalg.norm(target - pose.hip, axis=-1)
    soft, rest = _SOFT * pose.length, (_STRAIGHTEST - _SOFT) * pose.length
    eased = np.where(wanted > soft, soft + rest * -np.expm1(-np.maximum(wanted - soft, 0.0) / rest), wanted)
    reach = np.where(wanted <= pose.own, wanted, np.maximum(eased, pose.own))
    return np.asarray(pose.hip + (target - pose.hip) * (reach / np.maximum(wanted, 1e-12))[:, None])


def missing_height(pose: LegPose, target: Array, stands: Mask) -> Array:
    """By how much (n,) m ≤ 0 the hips are too high for a leg to reach where it stands without being drawn nearer."""
    limit = np.maximum(_SOFT * pose.length, pose.own)
    way = target - pose.hip
    over = np.sqrt(np.maximum(limit**2 - (way[:, GROUND] ** 2).sum(axis=1), 0.0))
    return np.where(stands, np.minimum(over + way[:, 1], 0.0), 0.0)


def lowered(missing: Array, fps: float, leg: float) -> Array:
    """The path (n,) m ≤ 0 by which the hips come down, nowhere by less than is `missing` (n,) m, smoothly, 6 % of
    the leg's length at most.
    """
    half = max(1, round(_EASE * fps))
    deepest = minimum_filter1d(np.maximum(missing, -LOWEST * leg), 2 * half + 1, mode="nearest")
    return smoothed(deepest, half)


def bent_leg(
    pose: WorldPose, local: Array, leg: Leg, offsets: Array, stretch: Array, parents: tuple[int, ...]
) -> dict[int, Array]:
    """Local rotations (n, 4) of a leg's joints whose foot is moved and turned, as far as its place is in reach, the
    knee staying in its plane.

    local : (n, J, 4), as the pose has them
    offsets : (n, 9) m of the foot's pivot, rad of the foot in the world, rad of the toe
    stretch : (n,) m from hip joint to ankle in the source
    """
    shape = leg_pose(pose, leg, stretch)
    target = within_reach(shape, ankle_moved(pose, leg, offsets))
    moved = np.linalg.norm(target - shape.ankle, axis=1)
    out = _reaching(pose, leg, target, moved, rotvec_to_quat(offsets[:, 3:6]), knee_hinge(pose, leg), parents)
    if leg.toe is not None:
        out[leg.toe] = quat_multiply(rotvec_to_quat(offsets[:, 6:9]), local[:, leg.toe])
    return {joint: quat_normalize(_same_sign(values, local[:, joint])) for joint, values in out.items()}


def sound_leg(
    pose: WorldPose, local: Array, leg: Leg, moved: Array, limit: Array, hinge: Array, parents: tuple[int, ...]
) -> dict[int, Array]:
    """Local rotations (n, 4) of thigh, shin and foot of a leg whose joints have been turned: its ankle and its foot
    stay, but no knee is bent backwards, nor is it stretched more than `limit` (n,) m.

    moved : (n,) m by which the turns have moved the ankle; hinge : (3,) of the leg before, see :func:`knee_hinge`
    """
    hip, ankle = pose.positions[:, leg.thigh], pose.positions[:, leg.foot]
    far = np.linalg.norm(ankle - hip, axis=1)
    target = hip + (ankle - hip) * np.minimum(1.0, limit / np.maximum(far, 1e-12))[:, None]
    still = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(far), 4))
    out = _reaching(pose, leg, target, moved, still, hinge, parents)
    return {joint: quat_normalize(_same_sign(values, local[:, joint])) for joint, values in out.items()}


def _reaching(
    pose: WorldPose, leg: Leg, target: Array, moved: Array, turned: Array, hinge: Array, parents: tuple[int, ...]
) -> dict[int, Array]:
    """Local rotations (n, 4) of a leg whose ankle is at its target (n, 3) m, its foot turned in the world (n, 4).

    moved : (n,) m, the more the surer the knee gets a bend; hinge : (3,), see :func:`knee_hinge`
    """
    hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    first, second = _unlocked(pose, leg, moved / (moved + _NEAR), hinge)
    bent = hip + quat_rotate(first, knee - hip)
    by_thigh, by_shin = two_bone_ik(hip, bent, bent + quat_rotate(second, ankle - knee), target)
    by_thigh, by_shin = quat_multiply(by_thigh, first), quat_multiply(by_shin, second)
    thigh, shin, foot = (pose.rotations[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    return {
        leg.thigh: quat_multiply(quat_conjugate(above(pose, parents[leg.thigh])), quat_multiply(by_thigh, thigh)),
        leg.shin: _local(pose.rotations[:, parents[leg.shin]], by_thigh, quat_multiply(by_shin, shin)),
        leg.foot: _local(pose.rotations[:, parents[leg.foot]], by_shin, quat_multiply(turned, foot)),
    }


def pivot_of(leg: Leg) -> int:
    """The joint about which a foot rolls: its toe, or the ankle on a rig without."""
    return leg.foot if leg.toe is None else leg.toe


def ankle_moved(pose: WorldPose, leg: Leg, offsets: Array) -> Array:
    """Where the ankle comes (n, 3) m if its foot is moved and turned by `offsets` (n, ≥ 6), m of the pivot and rad."""
    pivot = pose.positions[:, pivot_of(leg)]
    sole = pose.positions[:, leg.foot] - pivot
    return np.asarray(pivot + offsets[:, :3] + quat_rotate(rotvec_to_quat(offsets[:, 3:6]), sole))


def above(pose: WorldPose, parent: int) -> Array:
    """World rotation (n, 4) of the frame that a joint hangs in."""
    return np.broadcast_to([0.0, 0.0, 0.0, 1.0], (len(pose.rotations), 4)) if parent < 0 else pose.rotations[:, parent]


def _local(parent: Array, turned: Array, world: Array) -> Array:
    """Local rotations of a joint that shall stand as `world`, its parent having been turned from the left."""
    return quat_multiply(quat_conjugate(quat_multiply(turned, parent)), world)


def _same_sign(values: Array, like: Array) -> Array:
    return np.where(np.einsum("fi,fi->f", values, like)[:, None] < 0, -values, values)


def knee_hinge(pose: WorldPose, leg: Leg) -> Array:
    """The axis (3,), of length 1 and in the frame of the thigh, about which a knee bends; 0 where it never does."""
    hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    axis = quat_rotate(quat_conjugate(pose.rotations[:, leg.thigh]), np.cross(knee - hip, ankle - knee)).sum(axis=0)
    size = float(np.linalg.norm(axis))
    return np.asarray(axis / size if size >= 1e-9 else np.zeros(3))


def _unlocked(pose: WorldPose, leg: Leg, share: Array, hinge: Array) -> tuple[Array, Array]:
    """World turns (n, 4) of thigh and shin that give a straight or overstretched knee a slight bend, `share` (n,) of
    it, about its hinge (3,) in the thigh's frame.
    """
    hip, knee, ankle = (pose.positions[:, joint] for joint in (leg.thigh, leg.shin, leg.foot))
    axis = quat_rotate(pose.rotations[:, leg.thigh], np.broadcast_to(hinge, hip.shape))
    return slightly_bent(knee - hip, ankle - knee, axis, share if hinge.any() else np.zeros_like(share))


def slightly_bent(upper: Array, lower: Array, hinge: Array, share: Array) -> tuple[Array, Array]:
    """World turns (n, 4) of an upper and a lower bone (n, 3) that are straight or overstretched, by which they are bent
    a little about their hinge (n, 3) of length 1, `share` (n,) of it.
    """
    sine = np.einsum("fi,fi->f", np.cross(upper, lower), hinge)
    bent = np.arctan2(sine, np.einsum("fi,fi->f", upper, lower))
    missing = _SOFTLY * np.logaddexp(0.0, (_BENT - bent) / _SOFTLY) * np.clip(share, 0.0, 1.0)
    back = -missing / 2
    return rotvec_to_quat(hinge * back[:, None]), rotvec_to_quat(hinge * (back + missing)[:, None])
