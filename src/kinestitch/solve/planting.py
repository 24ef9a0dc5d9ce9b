"""One leg around seams: bent to its stances by IK, and what that takes carried over its swings joint by joint.

In a stance the foot's place is what counts, in a swing the movement: there the turns of the leg's joints go on as
smoothly as a gap closes in the solve, and the foot is lifted only where it would come too near the ground. How much
stronger than its sources a joint accelerates by all this decides how long a stance can last.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.kinematics import WorldPose
from kinestitch.core.rotation import Array, quat_conjugate, quat_continuous, quat_log, quat_multiply, rotvec_to_quat
from kinestitch.solve.contacts import Leg, Mask, runs
from kinestitch.solve.footing import Window, foot_path, placed_path
from kinestitch.solve.legs import knee_hinge, sound_leg
from kinestitch.solve.release import wanted_stances
from kinestitch.solve.stances import FootPath, Setting, Stances
from kinestitch.solve.swings import GROUND, carry_over, clearance, eased_lift, floor_under, step_arcs

MOST = 0.22
"""Of what the sources' strongest joint does in 95 % of the frames, what holding a foot may add to a joint."""

_FARTHEST = 0.03  # leg lengths that the hips may still be too high where a stance begins or ends
_STILL = 1e-7  # m and rad; less is left alone
_STEP = 0.6  # s that a foot may take for a step
_RUSH, _LOW = 3.5, 0.02  # leg lengths per s that no foot should go along the ground, leg lengths that are on it
_WHOLE, _SHARES = (1.0,), (1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.0)  # of a lift


@dataclass(frozen=True, eq=False, slots=True)
class Planted:
    """A leg with its foot planted.

    local : by joint, its local rotations (n, 4); stands : (n,) frames in which the foot stands
    offsets : (n, 9) there, m its pivot is moved by, rad it is turned by in the world, and its toe against it
    """

    local: Mapping[int, Array]
    stands: Mask
    offsets: Array


def planted(window: Window, leg: Leg, held: Mask, flat: Mask) -> Planted:
    """Plant a foot where it stands in the placed sources; held, flat : (n,) frames in which it does, and its heel."""
    now, toes, setting = foot_path(window.ours, leg), _toe_offsets(window, leg), window.setting

    def far(path: FootPath) -> Mask:
        return np.asarray(window.missing(leg, _offsets(path, now), held) < -_FARTHEST * setting.leg)

    def on(stances: Stances) -> _Bent:
        offsets = np.concatenate([_offsets(stances.path, now), stances.evened(toes)], axis=1)
        return _bent(window, leg, ground, stances.path, np.where(held[:, None], offsets, 0.0))

    placed = placed_path(window, leg)
    ground = _ground(placed, held, setting)
    stances, stands = wanted_stances(placed, on, (held, flat), far, setting)
    bent = on(stances)
    turns = bent.lifted(bent.carried(stands), stands, _SHARES)
    local = {joint: turns[:, k] for k, joint in enumerate(bent.joints)}
    return Planted(local, stands, np.where(stands[:, None], bent.offsets, 0.0))


@dataclass(frozen=True, eq=False, slots=True)
class _Ground:
    """What a foot's placed sources say of the ground under it.

    held : (n,) frames in which it can stand; way : (n, 2) m over the ground; floor : (n,) m, the lowest it may be
    own : by the frame after a seam, m that the sources go over its interval
    """

    held: Mask
    way: Array
    floor: Array
    own: Mapping[int, float]


def _ground(placed: FootPath, held: Mask, setting: Setting) -> _Ground:
    own = {m: float(np.linalg.norm(placed.own_step(m - 1, m, (m,)).shift[list(GROUND)])) for m in placed.beside}
    return _Ground(held, placed.pivot[:, GROUND], floor_under(placed.pivot[:, 1], setting.blend), own)


@dataclass(frozen=True, eq=False, slots=True)
class _Bent:
    """A leg bent to its foot's places.

    path : where its foot can stand
    joints : K of them; turns : (n, K, 3) rad by which each is turned in its own axes; offsets : (n, 9), see `Planted`
    longest, hinge : how far it may be stretched (n,) m, and the axis (3,) of its knee in the thigh's frame
    allowed : how much stronger than its source a joint may accelerate
    """

    window: Window
    leg: Leg
    ground: _Ground
    path: FootPath
    joints: tuple[int, ...]
    turns: Array
    offsets: Array
    longest: Array
    hinge: Array
    allowed: float

    def carried(self, stands: Mask) -> Array:
        """Local rotations (n, K, 4) if the foot stands in some frames (n,) and swings in the others (Eq. 25)."""
        setting, count = self.window.setting, len(stands)
        turns = np.where(stands[:, None, None], self.turns, 0.0).reshape(count, -1)
        turns = carry_over(turns, setting.known(stands), setting.blend, breaks=setting.hard)
        bent = quat_multiply(self.window.local[:, self.joints], rotvec_to_quat(turns.reshape(count, -1, 3)))
        swings = np.flatnonzero(~stands & (np.abs(turns) > _STILL).any(axis=1))
        return self._sound(bent, swings) if len(swings) else bent

    def _sound(self, turns: Array, frames: NDArray[np.intp]) -> Array:
        """The same local rotations, in some frames with no knee bent backwards and no leg overstretched."""
        turned, before = self.window.turned(self.joints, turns), self.window.ours.positions[frames, self.leg.foot]
        pose = WorldPose(turned.ours.positions[frames], turned.ours.rotations[frames])
        moved = np.linalg.norm(pose.positions[:, self.leg.foot] - before, axis=1)
        parents, out = self.window.motion.skeleton.parents, turns.copy()
        local = sound_leg(pose, turned.local[frames], self.leg, moved, self.longest[frames], self.hinge, parents)
        for joint, values in local.items():
            out[frames, self.joints.index(joint)] = values
        return out

    def excess(self, stands: Mask) -> Array:
        """How much too strongly the leg accelerates in each frame (n,): 1 is as much as may be. A step that takes the
        place of a contact is lifted as it should be, as long as it is short.
        """
        turns = self.carried(stands)
        excess = self.window.excess(turns, self.joints)
        released, longest = self.ground.held & ~stands, _STEP * self.window.setting.fps
        steps = [(a, b) for a, b in runs(~stands) if released[a:b].any() and b - a <= longest]
        if steps and excess.max() <= self.allowed:
            higher = self.window.excess(self.lifted(turns, stands, _WHOLE), self.joints)
            for a, b in steps:
                near = slice(max(0, a - 1), b + 1)
                excess[near] = higher[near]
        return excess / self.allowed

    def lifted(self, turns: Array, stands: Mask, shares: Sequence[float]) -> Array:
        """Local rotations (n, K, 4) with the foot lifted in its swings where it comes too near the ground: each by the
        first of some falling shares of what it lacks that makes no joint accelerate too strongly, or the last, and at
        least by what it would sink into the ground.
        """
        window, joints = self.window, list(self.joints)
        low, known = window.turned(joints, turns), window.setting.known(stands)
        least, whole = self._lifts(low, known, stands)
        if not (whole > _STILL).any():
            return turns
        allowed = self._allowed_lifting(low, turns, least)
        rung, offsets = np.zeros(len(whole), dtype=np.intp), np.zeros((len(whole), 9))
        while True:
            offsets[:, 1] = np.maximum(np.array(shares)[rung] * whole, least)
            bent = low.bent(self.leg, offsets)
            higher = np.stack([bent[joint] for joint in joints], axis=1)
            out = np.where((offsets[:, 1] > _STILL)[:, None, None], higher, turns)
            over = window.excess(out, joints) > allowed
            thrown = [
                (a, b) for a, b in runs(~known) if rung[a] + 1 < len(shares) and over[max(0, a - 1) : b + 1].any()
            ]
            if not thrown:
                return np.asarray(out)
            for a, b in thrown:
                rung[a:b] += 1

    def _lifts(self, low: Window, known: Mask, stands: Mask) -> tuple[Array, Array]:
        """By how much (n,) m the foot has to be lifted so as not to sink into the ground, and so as to clear it."""
        setting, ground, foot = low.setting, self.ground, foot_path(low.ours, self.leg).pivot
        clear = clearance(foot[:, GROUND], ground.way, own=ground.own, fps=setting.fps, leg=setting.leg)
        arcs = step_arcs(stands, ground.held & ~stands, self.path.pivot[:, GROUND], setting.leg)
        under = ground.floor - foot[:, 1]
        return eased_lift(under, known, setting.fps), eased_lift(under + arcs + clear, known, setting.fps)

    def _allowed_lifting(self, low: Window, turns: Array, lift: Array) -> Array:
        """How much stronger than its source a joint may accelerate in each frame (n,) for a foot to be lifted: more
        where it would rush along the ground.
        """
        setting, foot = low.setting, foot_path(low.ours, self.leg).pivot
        height = foot[:, 1] + lift - self.ground.floor
        speed = np.linalg.norm(np.gradient(foot[:, GROUND], axis=0), axis=1) * setting.fps / setting.leg
        speed[height > _LOW * setting.leg] = 0.0
        rushing = 1 + np.maximum(speed - _RUSH, 0.0)
        allowed = np.maximum(self.allowed, self.window.excess(turns, self.joints)) + 1e-9
        for start, stop in runs(speed > _RUSH):
            near = slice(max(0, start - round(_STEP / 2 * setting.fps)), stop + round(_STEP / 2 * setting.fps))
            allowed[near] = np.maximum(allowed[near], self.allowed * rushing[start:stop].max())
        return allowed


def _bent(window: Window, leg: Leg, ground: _Ground, path: FootPath, offsets: Array) -> _Bent:
    local = window.bent(leg, offsets)
    joints = tuple(local)
    own = window.local[:, joints]
    turns = quat_multiply(quat_conjugate(own), np.stack(list(local.values()), axis=1))
    vectors = quat_log(np.where(turns[..., 3:] < 0, -turns, turns))
    vectors[np.abs(vectors).max(axis=(1, 2)) < _STILL] = 0.0
    allowed = max(MOST, float(window.excess(own, joints).max()))
    longest, hinge = window.longest(leg), knee_hinge(window.ours, leg)
    return _Bent(window, leg, ground, path, joints, vectors, offsets, longest, hinge, allowed)


def _offsets(path: FootPath, now: FootPath) -> Array:
    """From where a foot is to a path: (n, 6), m of its pivot and rad of its turn in the world."""
    turns = quat_multiply(path.turn, quat_conjugate(now.turn))
    return np.concatenate([path.pivot - now.pivot, _rotvecs(turns)], axis=1)


def _rotvecs(turns: Array) -> Array:
    """Rotation vectors (n, 3) of turns (n, 4), continuous in time."""
    turns = quat_continuous(turns)
    return quat_log(-turns if turns[:, 3].sum() < 0 else turns)


def _toe_offsets(window: Window, leg: Leg) -> Array:
    """From the result's local rotation of the toe to the source's, as rotation vectors (n, 3)."""
    if leg.toe is None:
        return np.zeros((window.motion.frames, 3))
    there, here = window.cut.rotations[:, leg.toe], window.motion.rotations[:, leg.toe]
    return _rotvecs(quat_multiply(there, quat_conjugate(here)))
