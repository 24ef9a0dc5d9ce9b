"""What is known of the feet around the seams of one cluster: the body in the result and in its placed sources."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinestitch.core.kinematics import WorldPose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_multiply, quat_rotate
from kinestitch.solve.contacts import Leg, Mask
from kinestitch.solve.legs import ankle_moved, bent_leg, leg_pose, missing_height, pivot_of, stretched
from kinestitch.solve.placed import Placed, beside
from kinestitch.solve.seam import Cluster
from kinestitch.solve.solved import as_motion
from kinestitch.solve.sources import own_strength, own_velocities, velocity_between
from kinestitch.solve.stances import FootPath, Setting

_LIVELY = 30.0  # rad/s² that sources are taken to do at least


@dataclass(frozen=True, eq=False, slots=True)
class Window:
    """One cluster's frames of the result and of the hard cut, local and in the world.

    beside : by a seam's frame in the window, its left and its right source on their own around it
    joints : those of the legs, and what they hang on; poses of others are not told
    own : (n, J) rad/s² of the sources' angular acceleration; strongest : rad/s², what counts as strong in them
    local : (n, J, 4) of the result, as `ours` has it
    """

    motion: Motion
    cut: Motion
    ours: WorldPose
    theirs: WorldPose
    beside: Mapping[int, tuple[WorldPose, WorldPose]]
    setting: Setting
    joints: tuple[int, ...]
    own: Array
    strongest: float
    local: Array

    def moved(self, shift: Array) -> Window:
        """The same with the body moved by (n, 3) m."""
        return replace(self, ours=WorldPose(self.ours.positions + shift[:, None], self.ours.rotations))

    def turned(self, joints: Sequence[int], turns: Array) -> Window:
        """The same with other local rotations (n, K, 4) of some joints, of which the first is above the others."""
        local, positions, rotations = self.local.copy(), self.ours.positions.copy(), self.ours.rotations.copy()
        local[:, list(joints)] = turns
        parents, below = self.motion.skeleton.parents, {joints[0]}
        for joint in sorted(self.joints):
            parent = parents[joint]
            if joint != joints[0] and parent not in below:
                continue
            below.add(joint)
            if joint != joints[0]:
                way = quat_rotate(rotations[:, parent], self.motion.translations[:, joint])
                positions[:, joint] = positions[:, parent] + way
            above = rotations[:, parent] if parent >= 0 else np.array([0.0, 0.0, 0.0, 1.0])
            rotations[:, joint] = quat_multiply(above, local[:, joint])
        return replace(self, local=local, ours=WorldPose(positions, rotations))

    def longest(self, leg: Leg) -> Array:
        """How far a leg may be stretched at most: (n,) m."""
        return leg_pose(self.ours, leg, stretched(self.theirs, leg)).longest

    def bent(self, leg: Leg, offsets: Array) -> Mapping[int, Array]:
        """Local rotations (n, 4) of a leg's joints whose foot is moved by `offsets` (n, 9)."""
        reach = stretched(self.theirs, leg)
        return bent_leg(self.ours, self.local, leg, offsets, reach, self.motion.skeleton.parents)

    def missing(self, leg: Leg, offsets: Array, stands: Mask) -> Array:
        """By how much (n,) m ≤ 0 the hips are too high for a foot that is moved by `offsets`, where it stands."""
        pose = leg_pose(self.ours, leg, stretched(self.theirs, leg))
        return missing_height(pose, ankle_moved(self.ours, leg, offsets), stands)

    def excess(self, turns: Array, joints: Sequence[int]) -> Array:
        """How much stronger than its source the strongest of some joints accelerates, (n,) over what counts as strong;
        a hard cut does not count.

        turns : (n, K, 4) local rotations of the joints
        """
        sizes = np.zeros(turns.shape[:2])
        steps = velocity_between(turns[:-1], turns[1:], self.setting.fps)
        sizes[1:-1] = np.linalg.norm(np.diff(steps, axis=0), axis=-1) * self.setting.fps
        for frame in self.setting.hard:
            sizes[max(0, frame - 1) : frame + 1] = 0.0
        return np.asarray(np.maximum(sizes - self.own[:, joints], 0.0).max(axis=1) / self.strongest)


def window_of(placed: Placed, motion: Motion, cut: Motion, legs: Sequence[Leg], setting: Setting) -> Window:
    """A cluster's window; motion, cut : the whole result and the whole hard cut"""
    cluster, frames = setting.cluster, min(motion.frames, placed.frames)
    joints = tuple(sorted({above for leg in legs for joint in leg.joints for above in motion.skeleton.chain(joint)}))
    sides = {}
    for seam, frame in zip(cluster.seams, cluster.local_frames, strict=True):
        both = world_pose(as_motion(placed, *beside(placed, seam, setting.pause)), joints)
        halves = slice(0, 2 * setting.pause), slice(2 * setting.pause, None)
        left, right = (WorldPose(both.positions[half], both.rotations[half]) for half in halves)
        sides[frame] = left, right
    start, stop = max(1, cluster.start), min(frames - 1, cluster.stop)
    own = np.zeros((cluster.stop - cluster.start, motion.skeleton.joint_count))
    into, out, _ = own_velocities(placed, start, stop)
    own[start - cluster.start : stop - cluster.start] = np.linalg.norm(out - into, axis=-1) * motion.fps
    strongest = max(_LIVELY, min(own_strength(placed, seam).acceleration for seam in cluster.seams))
    ours, theirs = _part(motion, cluster), _part(cut, cluster)
    poses = world_pose(ours, joints), world_pose(theirs, joints)
    return Window(ours, theirs, *poses, sides, setting, joints, own, strongest, ours.rotations)


def _part(motion: Motion, cluster: Cluster) -> Motion:
    here = slice(cluster.start, cluster.stop)
    return replace(motion, rotations=motion.rotations[here], translations=motion.translations[here])


def foot_path(pose: WorldPose, leg: Leg) -> FootPath:
    """Where a foot is, by the joint about which it rolls."""
    return FootPath(pose.positions[:, pivot_of(leg)], pose.rotations[:, leg.foot])


def placed_path(window: Window, leg: Leg) -> FootPath:
    """Where a foot is in the placed sources."""
    sides = {m: (foot_path(left, leg), foot_path(right, leg)) for m, (left, right) in window.beside.items()}
    return replace(foot_path(window.theirs, leg), beside=sides)
