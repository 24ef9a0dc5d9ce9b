"""One pose that every rig can stand in: upright, facing +Z, arms out to the sides, legs straight down, feet flat.

Rest poses differ from rig to rig, by file and by format: T-poses, A-poses, arms hanging, or all angles zero with
every bone along one axis. Two rigs in this pose look alike in the world, so that a turn away from it, told in the
world's axes, means the same on both.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kinestitch.core.kinematics import WorldPose, rest_pose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    matrix_to_quat,
    quat_between,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    rotvec_to_quat,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import LIMBS, SIDES

LEFT, UP, FORWARD = np.eye(3)
_LEANING = np.radians(40.0)  # a rest pose that leans further does not stand
_OFF = np.radians(60.0)  # a limb that rests further from where it should be is drawn along an axis
_FLAT_FOOT = np.radians(30.0)  # by which the toes lie below the ankle where neither rest nor motion tells
_PITCHES = (0.2, 0.75)  # sines of that angle that feet have
_GROUNDED = 0.15  # leg lengths: toes that rest nearer to height 0 rest on the ground
_STILLEST = 10  # a foot stands in one frame of so many
_STRAIGHT = 0.05  # mean sine of a hinge's angle below which its direction is not known


@dataclass(frozen=True, eq=False, slots=True)
class Reference:
    """A rig in the common pose.

    rotations : (J, 4) world_from_joint; positions : (J, 3) m, the root at its rest offset
    posed : whether the rig's own rest pose shows a standing body; grounded : whether that stands at height 0
    """

    rotations: Array
    positions: Array
    posed: bool
    grounded: bool


class _Pose:
    """A rest pose being turned into the common one: a world turn for each joint, carried on to what hangs on it."""

    def __init__(self, skeleton: Skeleton, joints: Mapping[str, int]) -> None:
        self.skeleton = skeleton
        self.joints = joints
        self.rest, self.axes = rest_pose(skeleton)
        self.turns = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (skeleton.joint_count, 4)).copy()

    def turn(self, joint: int, by: Array) -> None:
        """Turn a joint and everything below it in the world."""
        below = {joint}
        self.turns[joint] = quat_multiply(by, self.turns[joint])
        for other in range(joint + 1, self.skeleton.joint_count):
            if self.skeleton.parents[other] in below:
                below.add(other)
                self.turns[other] = quat_multiply(by, self.turns[other])

    def direction(self, joint: int, to: int | None) -> Array | None:
        """Where a joint's bone points now: to another joint, or to its own tip; (3,), None where it has no length."""
        if to is None:
            tip = self.skeleton.tips[joint]
            bone = quat_rotate(self.axes[joint], tip) if np.isfinite(tip).all() else np.zeros(3)
        else:
            bone = self.rest[to] - self.rest[joint]
        size = np.linalg.norm(bone)
        return quat_rotate(self.turns[joint], bone / size) if size > 1e-9 else None

    def swing(self, joint: int, to: int | None, wanted: Array) -> None:
        """Turn a joint the short way until its bone points as wanted."""
        now = self.direction(joint, to)
        if now is None:
            return
        opposite = now @ wanted < -0.9999 and abs(now @ LEFT) < 0.1
        self.turn(joint, rotvec_to_quat(np.pi * LEFT) if opposite else quat_between(now, wanted))

    def lateral(self, pair: str) -> Array | None:
        """From right to left between two counterparts, as the joint that both hang on stands now."""
        left, right = (self.joints.get(f"{side}_{pair}") for side in SIDES)
        if left is None or right is None:
            return None
        common = [a for a, b in zip(self.skeleton.chain(left), self.skeleton.chain(right), strict=False) if a == b][-1]
        apart = quat_rotate(self.turns[common], self.rest[left] - self.rest[right])
        return apart if np.linalg.norm(apart) > 1e-9 else None

    def rotations(self) -> Array:
        return quat_multiply(self.turns, self.axes)


def reference(skeleton: Skeleton, joints: Mapping[str, int], example: Motion | None = None) -> Reference:
    """The rig in the common pose.

    joints : role → joint, see :func:`kinestitch.rig.roles.roles_of`
    example : a motion of this rig; where the rest pose is no pose, it tells in which direction elbows and knees bend

    Bones of arms and legs are aligned exactly, by the shortest turn from a rest pose that stands. Trunk, head and hands
    stay as at rest, for their bones' directions say more about where a rig puts its joints than about where the body
    leans. Feet stand flat: as at rest where the rest pose stands on the ground, else as the example's feet do when
    they stand still.
    """
    pose = _Pose(skeleton, joints)
    _stand(pose)
    posed = _is_posed(pose)
    if not posed:
        _straighten(pose)
    grounded = posed and _is_grounded(pose)
    moving = world_pose(example) if example is not None else None
    flat = pose.turns.copy() if grounded or (posed and moving is None) else None
    pitch = _foot_pitch(joints, moving)
    for side in SIDES:
        for limb, bends in ((LIMBS["arm"], FORWARD), (LIMBS["leg"], -FORWARD)):
            out = -UP if bends is not FORWARD else LEFT if side == SIDES[0] else -LEFT
            chain = [pose.joints[f"{side}_{part}"] for part in limb if f"{side}_{part}" in pose.joints]
            far = _align(pose, chain, out)
            if (far or not posed) and moving is not None and len(chain) == 3:
                _twist(pose, chain, bends, moving)
        _straighten_hand(pose, side)
        _flatten_foot(pose, side, flat, pitch)
    rotations = pose.rotations()
    positions = _place(skeleton, rotations)
    return Reference(rotations, positions, posed, grounded)


def _place(skeleton: Skeleton, rotations: Array) -> Array:
    positions = skeleton.offsets.copy()
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            positions[joint] = positions[parent] + quat_rotate(rotations[parent], skeleton.offsets[joint])
    return positions


def _upright(up: Array, lateral: Array) -> Array:
    """The turn (4,) after which `up` points up and `lateral`, as far as it is square to it, to the left."""
    up = up / np.linalg.norm(up)
    side = lateral - up * (lateral @ up)
    if np.linalg.norm(side) < 1e-6:
        return quat_between(up, UP)
    side /= np.linalg.norm(side)
    return quat_conjugate(matrix_to_quat(np.stack([side, up, np.cross(side, up)], axis=1)))


def _stand(pose: _Pose) -> None:
    """Turn the whole rest pose to face +Z, and upright if it leans far (Z-up files, bones along one axis)."""
    joints = pose.joints
    top = joints.get("head", joints.get("neck_1", joints.get("spine_1")))
    up = pose.rest[top] - pose.rest[joints["hips"]] if top is not None else UP
    sides = [side for pair in ("upper_leg", "upper_arm") if (side := pose.lateral(pair)) is not None]
    lateral = np.sum(sides, axis=0) if sides else LEFT
    if np.linalg.norm(up) < 1e-9 or up @ UP > np.cos(_LEANING) * np.linalg.norm(up):
        up = UP
    pose.turn(0, _upright(up, lateral))


def _is_posed(pose: _Pose) -> bool:
    """Whether the rest pose, facing +Z, shows a body that stands: legs down, both hips and shoulders to the left."""
    for side in SIDES:
        upper, lower = (pose.joints.get(f"{side}_{part}") for part in ("upper_leg", "lower_leg"))
        bone = pose.direction(upper, lower) if upper is not None and lower is not None else None
        if bone is not None and bone @ -UP < np.cos(_OFF):
            return False
    sides = [pose.lateral(pair) for pair in ("upper_leg", "upper_arm")]
    return all(side is None or side @ LEFT > np.cos(_LEANING) * np.linalg.norm(side) for side in sides)


def _is_grounded(pose: _Pose) -> bool:
    """Whether the toes rest near height 0."""
    for side in SIDES:
        chain = [pose.joints.get(f"{side}_{part}") for part in ("upper_leg", "lower_leg", "foot", "toe")]
        if any(joint is None for joint in chain):
            return False
        places = pose.rest[[joint for joint in chain if joint is not None]]
        if abs(places[3, 1]) > _GROUNDED * np.linalg.norm(np.diff(places[:3], axis=0), axis=-1).sum():
            return False
    return True


def _straighten(pose: _Pose) -> None:
    """A rest pose of zero angles: hips by their first spine bone and hip joints, then the trunk bone by bone."""
    names = [role for role in pose.joints if role.startswith(("spine_", "neck_"))]
    column = [pose.joints["hips"], *(pose.joints[role] for role in names)]
    column += [pose.joints["head"]] if "head" in pose.joints else []
    lateral = pose.lateral("upper_leg")
    bone = next((b for b in (pose.direction(column[0], j) for j in column[1:]) if b is not None), None)
    if bone is not None and lateral is not None:
        pose.turn(column[0], _upright(bone, lateral))
    chest = pose.joints[[role for role in names if role.startswith("spine_")][-1]] if names else column[0]
    for joint, above in zip(column[1:], [*column[2:], None], strict=True):
        if above is not None:
            pose.swing(joint, above, UP)
        across = pose.lateral("upper_arm") if joint == chest else None
        if across is not None:
            pose.turn(joint, _upright(UP, across))
    for side, out in zip(SIDES, (LEFT, -LEFT), strict=True):
        shoulder, arm = (pose.joints.get(f"{side}_{part}") for part in ("shoulder", "upper_arm"))
        bone = pose.direction(shoulder, arm) if shoulder is not None else None
        if shoulder is not None and bone is not None and bone @ out < np.cos(_OFF):
            pose.swing(shoulder, arm, out)


def _align(pose: _Pose, chain: list[int], wanted: Array) -> bool:
    """Point every bone of a limb as wanted; returns whether the first one had to turn far."""
    far = False
    for joint, end in pairwise(chain):
        bone = pose.direction(joint, end)
        far |= joint == chain[0] and bone is not None and bone @ wanted < np.cos(_OFF)
        pose.swing(joint, end, wanted)
    return far


def _twist(pose: _Pose, chain: list[int], bends: Array, moving: WorldPose) -> None:
    """Turn a limb about itself by quarters, until it bends (in the mean of a motion) to where elbows or knees do."""
    upper, middle, end = chain
    bone = pose.direction(upper, middle)
    if bone is None:
        return
    lower = moving.positions[:, end] - moving.positions[:, middle]
    lower /= np.maximum(np.linalg.norm(lower, axis=-1, keepdims=True), 1e-9)
    bend = quat_rotate(quat_conjugate(moving.rotations[:, upper]), lower).mean(axis=0)
    bend = quat_rotate(quat_multiply(pose.turns[upper], pose.axes[upper]), bend)
    bend -= bone * (bend @ bone)
    if np.linalg.norm(bend) > _STRAIGHT:
        angle = np.arctan2(np.cross(bend, bends) @ bone, bend @ bends)
        pose.turn(upper, rotvec_to_quat(bone * np.round(angle / (np.pi / 2)) * (np.pi / 2)))


def _straighten_hand(pose: _Pose, side: str) -> None:
    out = LEFT if side == SIDES[0] else -LEFT
    hand, finger = (pose.joints.get(f"{side}_{part}") for part in ("hand", "middle_1"))
    bone = pose.direction(hand, finger) if hand is not None else None
    if hand is not None and bone is not None and bone @ out < np.cos(_OFF):
        pose.swing(hand, finger, out)


def _flatten_foot(pose: _Pose, side: str, flat: Array | None, pitch: float) -> None:
    """Toes ahead, and the foot tilted as at rest, or by `pitch` where the rest pose's feet do not stand.

    flat : (J, 4) the turns of a rest pose that stands
    """
    foot, toe = pose.joints.get(f"{side}_foot"), pose.joints.get(f"{side}_toe")
    if foot is None:
        return
    before = pose.turns.copy()
    if flat is not None:
        pose.turn(foot, quat_multiply(flat[foot], quat_conjugate(pose.turns[foot])))
        bone = pose.direction(foot, toe)
        if bone is None:
            return
        if np.hypot(bone[0], bone[2]) > np.cos(_OFF) and bone[2] > 0:
            pose.turn(foot, quat_between([bone[0], 0.0, bone[2]], FORWARD))
            return
    pose.turns = before
    pose.swing(foot, toe, FORWARD * np.cos(pitch) - UP * np.sin(pitch))
    if toe is not None:
        pose.swing(toe, None, FORWARD)


def _foot_pitch(joints: Mapping[str, int], moving: WorldPose | None) -> float:
    """The angle in rad by which the toes of a standing foot lie below the ankle: where it moves least, and the smaller
    of both feet's, since heels are lifted and toes are not."""
    pitches = []
    for side in SIDES:
        foot, toe = joints.get(f"{side}_foot"), joints.get(f"{side}_toe")
        if foot is None or toe is None or moving is None or len(moving.positions) < 2:
            continue
        ends = moving.positions[:, [foot, toe]]
        speed = np.linalg.norm(np.diff(ends, axis=0), axis=-1).sum(axis=-1)
        still = ends[np.argsort(speed, kind="stable")[: max(3, len(speed) // _STILLEST)]]
        bone = still[:, 0] - still[:, 1]
        sines = bone[:, 1] / np.maximum(np.linalg.norm(bone, axis=-1), 1e-12)
        pitches.append(np.arcsin(np.clip(np.median(sines), *_PITCHES)))
    return float(min(pitches)) if pitches else _FLAT_FOOT
