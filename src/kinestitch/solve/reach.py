"""Which way joints have to turn so that another one gets to a place: limbs by two bones, all else by small steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import two_bone_ik, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_normalize, quat_rotate, rotvec_to_quat
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.pins import Pin
from kinestitch.errors import ParameterError
from kinestitch.rig.families import LIMBS, SIDES
from kinestitch.rig.hips import hips_joint
from kinestitch.rig.roles import roles_of
from kinestitch.solve.joint_pins import Turn
from kinestitch.solve.legs import slightly_bent

MET = 1e-6
"""m within which an exact pin has to be met."""

_STEPS, _DAMPING = 100, 1e-3  # of Gauss–Newton, and its damping in squared body lengths
_LONGEST = 0.3  # rad that a joint turns in one step
_SLOW = 1e-4  # of what is missing; a step that gains less is the last


@dataclass(frozen=True, slots=True)
class Limb:
    """An arm or a leg: the joints that turn, the one at its end, and whether that one keeps its turn in the world."""

    upper: int
    lower: int
    end: int
    level: bool


def limb_of(skeleton: Skeleton, joint: int) -> Limb | None:
    """The limb at whose end a joint is or hangs: hand and fingers, foot and toes; None for all others."""
    roles, above = roles_of(skeleton).joints, skeleton.chain(joint)
    for side in SIDES:
        for parts in LIMBS.values():
            joints = [roles.get(f"{side}_{part}") for part in parts]
            upper, lower, end = (*joints, None, None, None)[:3]
            if upper is not None and lower is not None and end is not None and end in above:
                return Limb(upper, lower, end, "foot" in parts)
    return None


def turns_to(motion: Motion, pin: Pin, joint: int, taken: Sequence[int]) -> list[Turn]:
    """The turns of other joints in the pin's frame that bring `joint` to its place in the world.

    Hands and feet get there by the two bones of their limb, in the plane in which it bends; a foot keeps its turn in
    the world. Any other joint is brought there by all joints between the hips and itself, each as little as possible.

    taken : joints that this frame turns already, and which are left alone where that is possible

    Raises ParameterError for a place out of reach of an exact pin; a weighted one goes as near as it can.
    """
    limb = limb_of(motion.skeleton, joint)
    if limb is None:
        return _by_chain(motion, pin, joint, taken)
    found = _by_limb(motion, pin, joint, replaced_level(limb, taken))
    return [Turn(index, rotation, pin) for index, rotation in found.items()]


def replaced_level(limb: Limb, taken: Sequence[int]) -> Limb:
    """A foot whose own rotation is pinned hangs on its shin like a hand."""
    return Limb(limb.upper, limb.lower, limb.end, limb.level and limb.end not in taken)


def _by_limb(motion: Motion, pin: Pin, joint: int, limb: Limb) -> dict[int, Array]:
    pose = world_pose(_frame(motion, pin.frame), (joint, limb.upper, limb.lower, limb.end))
    parents = motion.skeleton.parents
    place, turn = pose.positions[0], pose.rotations[0]
    target, tip = np.array(pin.target), joint
    if limb.level:
        target, tip = target - (place[joint] - place[limb.end]), limb.end
    root = place[limb.upper]
    bones = place[limb.lower] - root, place[tip] - place[limb.lower]
    hinge = quat_rotate(turn[limb.upper], _hinge(motion, limb, tip))
    share = np.array([float(hinge.any())])
    first, second = (q[0] for q in slightly_bent(bones[0][None], bones[1][None], hinge[None], share))
    elbow = root + quat_rotate(first, bones[0])
    end = elbow + quat_rotate(second, bones[1])
    _check_reach(motion, pin, limb, root, (elbow, end), target)
    upper, lower = two_bone_ik(root, elbow, end, target)
    upper, lower = quat_multiply(upper, first), quat_multiply(lower, second)
    out = {
        limb.upper: _local(turn, parents[limb.upper], None, quat_multiply(upper, turn[limb.upper])),
        limb.lower: _local(turn, parents[limb.lower], upper, quat_multiply(lower, turn[limb.lower])),
    }
    if limb.level:
        out[limb.end] = _local(turn, parents[limb.end], lower, turn[limb.end])
    return out


def _frame(motion: Motion, frame: int) -> Motion:
    here = slice(frame, frame + 1)
    return Motion(motion.skeleton, motion.translations[here], motion.rotations[here], motion.fps)


def _hinge(motion: Motion, limb: Limb, tip: int) -> Array:
    """The axis (3,) about which a limb bends over the whole clip, in its upper joint's frame; zeros where it never
    does.
    """
    chain, places = motion.skeleton.chain(tip), {}
    place, turn = np.zeros((motion.frames, 3)), np.broadcast_to([0.0, 0.0, 0.0, 1.0], (motion.frames, 4))
    for joint in chain[chain.index(limb.upper) + 1 :]:
        place = place + quat_rotate(turn, motion.translations[:, joint])
        turn = quat_multiply(turn, motion.rotations[:, joint])
        places[joint] = place
    axis = np.cross(places[limb.lower], places[tip] - places[limb.lower]).sum(axis=0)
    size = float(np.linalg.norm(axis))
    return np.asarray(axis / size if size > 1e-9 else axis * 0.0)


def _local(turns: Array, parent: int, turned: Array | None, world: Array) -> Array:
    """Local rotation (4,) of a joint that shall stand as `world`, its parent having been turned from the left."""
    if parent < 0:
        return quat_normalize(world)
    above = turns[parent] if turned is None else quat_multiply(turned, turns[parent])
    return quat_normalize(quat_multiply(quat_conjugate(above), world))


def _check_reach(motion: Motion, pin: Pin, limb: Limb, root: Array, joints: tuple[Array, Array], target: Array) -> None:
    upper, lower = np.linalg.norm(joints[0] - root), np.linalg.norm(joints[1] - joints[0])
    away = float(np.linalg.norm(target - root))
    nearest, furthest = abs(upper - lower) * 1.0001 + 1e-9, (upper + lower) * 0.9999
    if pin.exact and not nearest <= away <= furthest:
        raise ParameterError(
            f"Expected a place {nearest:.3f} to {furthest:.3f} m from {motion.skeleton.names[limb.upper]!r} for {pin}, "
            f"got one {away:.3f} m away. Move it or the body, or give the pin a weight."
        )


def _by_chain(motion: Motion, pin: Pin, joint: int, taken: Sequence[int]) -> list[Turn]:
    skeleton, name = motion.skeleton, motion.skeleton.names[joint]
    chain, hips = skeleton.chain(joint), hips_joint(skeleton)
    below = chain[chain.index(hips) + 1 : -1] if hips in chain else ()
    free = [index for index in below if index not in taken]
    if not free:
        raise ParameterError(
            f"Expected a joint that others between the hips and itself can bring to a place, got {name!r} for {pin}. "
            "Use a root pin for the body as a whole."
        )
    local = motion.rotations[pin.frame].copy()
    size = float(np.linalg.norm(skeleton.offsets[list(below)], axis=-1).sum()) + 1e-9
    missing, before = np.inf, np.inf
    for _ in range(_STEPS):
        places, turns = _along(chain, motion.translations[pin.frame], local)
        gap = np.array(pin.target) - places[joint]
        missing, before = float(np.linalg.norm(gap)), missing
        if missing < MET * 1e-4 or before - missing < _SLOW * missing:
            break
        step = _stepped(np.stack([places[joint] - places[index] for index in free]), gap, size)
        for index, turn in zip(free, step, strict=True):
            above = turns[skeleton.parents[index]]
            turned = quat_multiply(quat_multiply(quat_conjugate(above), turn), above)
            local[index] = quat_normalize(quat_multiply(turned, local[index]))
    if pin.exact and missing > MET:
        raise ParameterError(
            f"Expected a place that {name!r} can reach from the hips for {pin}, got one that it misses by "
            f"{missing:.3g} m. Move it or the body, or give the pin a weight."
        )
    return [Turn(index, local[index], pin) for index in free]


def _along(chain: Sequence[int], translations: Array, rotations: Array) -> tuple[dict[int, Array], dict[int, Array]]:
    """World positions (3,) and rotations (4,) of the joints from the root down a chain, in one frame."""
    places, turns = {}, {}
    place, turn = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    for joint in chain:
        place = place + quat_rotate(turn, translations[joint])
        turn = quat_multiply(turn, rotations[joint])
        places[joint], turns[joint] = place, turn
    return places, turns


def _stepped(arms: Array, gap: Array, size: float) -> Array:
    """World turns (k, 4) of a damped Gauss–Newton step over a gap (3,) m, of joints with these arms (k, 3) m to the
    tip.
    """
    across = np.zeros((3, 3 * len(arms)))  # a turn d of a joint moves the tip by d × arm
    for k, (x, y, z) in enumerate(arms):
        across[:, 3 * k : 3 * k + 3] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    damping = _DAMPING * min(size, float(np.linalg.norm(gap))) ** 2
    turns = (across.T @ np.linalg.solve(across @ across.T + damping * np.eye(3), gap)).reshape(-1, 3)
    return rotvec_to_quat(turns * min(1.0, _LONGEST / max(float(np.linalg.norm(turns, axis=-1).max()), 1e-12)))
