"""Which way joints have to turn so that another one gets to a place: limbs by two bones, all else by small steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import WorldPose, two_bone_ik, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_normalize, quat_rotate, rotvec_to_quat
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.pins import Pin
from kinestitch.errors import ParameterError
from kinestitch.rig.families import LIMBS, SIDES
from kinestitch.rig.hips import hips_joint
from kinestitch.rig.roles import roles_of
from kinestitch.solve.contacts import Leg
from kinestitch.solve.footlock import unlocked
from kinestitch.solve.joint_pins import Turn

MET = 1e-6
"""m within which an exact pin has to be met."""

_STEPS, _DAMPING = 200, 1e-3  # of Gauss–Newton, and its damping in squared body lengths
_LONGEST = 0.3  # rad that a joint turns in one step


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
    pose, at, parents = world_pose(motion), pin.frame, motion.skeleton.parents
    place, turn = pose.positions[at], pose.rotations[at]
    target = np.array(pin.target)
    tip = joint
    if limb.level:
        target, tip = target - (place[joint] - place[limb.end]), limb.end
    first, second = (q[at] for q in unlocked(pose, _as_leg(limb), np.ones(motion.frames)))
    root = place[limb.upper]
    elbow = root + quat_rotate(first, place[limb.lower] - root)
    end = elbow + quat_rotate(second, place[tip] - place[limb.lower])
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


def _as_leg(limb: Limb) -> Leg:
    return Leg(limb.upper, limb.lower, limb.end, None)


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
    here = slice(pin.frame, pin.frame + 1)
    local, translations = motion.rotations[here].copy(), motion.translations[here]
    size = float(np.linalg.norm(skeleton.offsets[list(below)], axis=-1).sum()) + 1e-9
    best = np.inf
    for _ in range(_STEPS):
        pose = world_pose(Motion(skeleton, translations, local, motion.fps))
        gap = np.array(pin.target) - pose.positions[0, joint]
        missing = float(np.linalg.norm(gap))
        if missing < MET * 1e-4 or (not np.isinf(best) and best - missing < MET * 1e-6 and missing > MET):
            break
        best = min(best, missing)
        local[0, free] = _stepped(pose, local[0], free, joint, gap, size, skeleton)
    if pin.exact and missing > MET:
        raise ParameterError(
            f"Expected a place that {name!r} can reach from the hips for {pin}, got one that it misses by "
            f"{missing:.3g} m. Move it or the body, or give the pin a weight."
        )
    return [Turn(index, local[0, index], pin) for index in free]


def _stepped(
    pose: WorldPose, local: Array, free: Sequence[int], joint: int, gap: Array, size: float, skeleton: Skeleton
) -> Array:
    """Local rotations (k, 4) of the free joints after one damped Gauss–Newton step on their turns in the world."""
    arms = pose.positions[0, joint] - pose.positions[0, list(free)]
    across = np.zeros((3, 3 * len(free)))  # a turn d of a joint moves the tip by d × arm
    for k, (x, y, z) in enumerate(arms):
        across[:, 3 * k : 3 * k + 3] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    damping = _DAMPING * min(size, float(np.linalg.norm(gap))) ** 2
    step = across.T @ np.linalg.solve(across @ across.T + damping * np.eye(3), gap)
    turns = step.reshape(-1, 3)
    turns = turns * min(1.0, _LONGEST / max(float(np.linalg.norm(turns, axis=-1).max()), 1e-12))
    above = pose.rotations[0, [skeleton.parents[index] for index in free]]
    turned = quat_multiply(quat_multiply(quat_conjugate(above), rotvec_to_quat(turns)), above)
    return quat_normalize(quat_multiply(turned, local[list(free)]))
