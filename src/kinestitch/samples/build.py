"""From choreography to motion: the pelvis travels, the feet stay where they stand, the rest follows."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinestitch.core.kinematics import two_bone_ik, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    matrix_to_quat,
    quat_about_axis,
    quat_conjugate,
    quat_identity,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    quat_slerp,
)
from kinestitch.samples.body import FOREARM, SHANK, THIGH, UPPER_ARM, humanoid, joint
from kinestitch.samples.curves import Curve, still
from kinestitch.samples.feet import Footwork, foot_turn

_REACH = 0.985 * (UPPER_ARM + FOREARM)


@dataclass(frozen=True, slots=True)
class Swing:
    """An arm told in joint angles.

    angles : columns raise forward, raise sideways, turn inwards, elbow, in degrees, from the arm hanging straight down
    """

    angles: Curve


@dataclass(frozen=True, slots=True)
class Reach:
    """An arm told by where the wrist is.

    wrist : columns out (away from the middle line), up, forward, in m from the base of the neck in world axes, then the
        elbow's swivel in degrees: 0 points it down, 90 outwards
    """

    wrist: Curve


@dataclass(frozen=True, slots=True)
class Choreography:
    """All that a clip is made of; every curve is a function of time in s.

    hips : (F, 3) m, the Hips joint in the world
    pelvis : (F, 3) degrees in the world: turn to the left, lean forward, tip to the right
    spine : (F, 3) degrees, the chest against the pelvis, the same three
    head : (F, 3) degrees in the world, the same three
    knees : (F, 2) degrees, how far each knee (left, right) points outwards from its foot
    fists : degrees at every finger joint
    """

    seconds: float
    hips: Curve
    pelvis: Curve
    spine: Curve
    left_arm: Swing | Reach
    right_arm: Swing | Reach
    left_foot: Footwork
    right_foot: Footwork
    head: Curve = field(default_factory=lambda: still(0.0, 0.0, 0.0))
    knees: Curve = field(default_factory=lambda: still(0.0, 0.0))
    fists: float = 18.0


def frame_times(seconds: float, fps: float) -> Array:
    """Times (F,) in s of the frames of a clip that lasts `seconds` from its first frame to its last."""
    return np.arange(int(np.floor(seconds * fps + 1e-6)) + 1) / fps


def torso_turn(degrees: Array) -> Array:
    """Rotations (F, 4) from (F, 3) degrees: turn left about Y, lean forward about X, tip to the right about Z."""
    turn, lean, tip = np.radians(degrees).T
    return quat_multiply(quat_multiply(quat_about_axis(1, turn), quat_about_axis(0, lean)), quat_about_axis(2, tip))


def perform(plan: Choreography, fps: float, name: str) -> Motion:
    """The motion of a choreography at a frame rate: torso first, then arms, then legs onto the feet's places."""
    t = frame_times(plan.seconds, fps)
    skeleton = humanoid()
    rotations = quat_identity((len(t), skeleton.joint_count))
    translations = np.repeat(skeleton.offsets[None], len(t), axis=0)
    translations[:, 0] = plan.hips(t)
    rotations[:, 0] = torso_turn(plan.pelvis(t))
    third = torso_turn(plan.spine(t) / 3)
    for part in ("Spine", "Spine1", "Spine2"):
        rotations[:, joint(part)] = third
    chest = _chain(rotations, ("Hips", "Spine", "Spine1", "Spine2"))
    nod = quat_multiply(quat_conjugate(chest), torso_turn(plan.head(t)))
    half = quat_slerp(quat_identity((len(t),)), nod, np.full(len(t), 0.5))
    rotations[:, joint("Neck")] = half
    rotations[:, joint("Head")] = quat_multiply(quat_conjugate(half), nod)
    for side, arm in (("Left", plan.left_arm), ("Right", plan.right_arm)):
        _pose_arm(Motion(skeleton, translations, quat_normalize(rotations), fps), side, arm, t, rotations)
        _curl_fingers(side, plan.fists, rotations)
    outwards = plan.knees(t) * [1.0, -1.0]
    for side, foot, knee in (("Left", plan.left_foot, 0), ("Right", plan.right_foot, 1)):
        state = foot.state(t)
        state = np.column_stack([state, state[:, 4] + outwards[:, knee]])
        _pose_leg(Motion(skeleton, translations, quat_normalize(rotations), fps), side, state, foot.toes(t), rotations)
    return Motion(skeleton, translations, quat_normalize(rotations), fps, name)


def _chain(rotations: Array, names: tuple[str, ...]) -> Array:
    total = rotations[:, joint(names[0])]
    for name in names[1:]:
        total = quat_multiply(total, rotations[:, joint(name)])
    return total


def _curl_fingers(side: str, degrees: float, rotations: Array) -> None:
    sign = -1.0 if side == "Left" else 1.0
    for number in (1, 2, 3):
        rotations[:, joint(f"{side}HandMiddle{number}")] = quat_about_axis(2, np.radians(sign * degrees))


def _mirrored(q: Array) -> Array:
    return q * np.array([1.0, -1.0, -1.0, 1.0])


def _pose_arm(draft: Motion, side: str, arm: Swing | Reach, t: Array, rotations: Array) -> None:
    parts = _swung(arm.angles(t)) if isinstance(arm, Swing) else _reaching(draft, side, arm.wrist(t))
    for name, local in zip(("Shoulder", "Arm", "ForeArm"), parts, strict=True):
        rotations[:, joint(side + name)] = _mirrored(local) if side == "Right" else local


def _swung(angles: Array) -> tuple[Array, Array, Array]:
    """Local rotations of a left collar bone, upper arm and forearm; the collar bone takes a share of a raised arm."""
    forward, sideways, inwards, elbow = np.radians(angles).T
    lift = 0.10 * sideways
    collar = quat_about_axis(2, lift)
    raised = quat_multiply(quat_about_axis(0, -forward), quat_about_axis(2, sideways - lift - np.pi / 2))
    return collar, quat_multiply(raised, quat_about_axis(0, inwards)), quat_about_axis(1, -elbow)


def _reaching(draft: Motion, side: str, wrist: Array) -> tuple[Array, Array, Array]:
    """The same three for a wrist that goes to a place; a right arm is solved as a left one in the mirror."""
    world = world_pose(draft)
    flip = np.array([-1.0, 1.0, 1.0]) if side == "Right" else np.ones(3)
    neck, shoulder = (world.positions[:, joint(n)] * flip for n in ("Neck", side + "Arm"))
    chest = world.rotations[:, joint("Spine2")]
    chest = _mirrored(chest) if side == "Right" else chest
    offset = neck + wrist[:, :3] - shoulder
    distance = np.linalg.norm(offset, axis=1, keepdims=True)
    offset = offset * (_soft_limit(distance) / distance)
    bones, joints = _elbow_pose(np.radians(wrist[:, 3]))
    turns = two_bone_ik(*joints, offset)
    arm, forearm = (quat_multiply(turn, bone) for turn, bone in zip(turns, bones, strict=True))
    collar = quat_identity((len(wrist),))
    return collar, quat_multiply(quat_conjugate(chest), arm), quat_multiply(quat_conjugate(arm), forearm)


def _elbow_pose(swivel: Array) -> tuple[tuple[Array, Array], tuple[Array, Array, Array]]:
    """A left arm that points forwards with its elbow at a right angle: its bones' rotations, and its three joints."""
    aim = np.broadcast_to([0.0, 0.0, 1.0], (len(swivel), 3))
    elbow = np.stack([np.sin(swivel), -np.cos(swivel), np.zeros(len(swivel))], axis=1)
    hinge = np.cross(aim, elbow)
    along = [(aim + elbow) / np.sqrt(2), (aim - elbow) / np.sqrt(2)]
    bones = [matrix_to_quat(np.stack([bone, hinge, np.cross(bone, hinge)], axis=-1)) for bone in along]
    bent = UPPER_ARM * along[0]
    return (bones[0], bones[1]), (np.zeros_like(bent), bent, bent + FOREARM * along[1])


def _soft_limit(distance: Array) -> Array:
    start = 0.9 * _REACH
    room = _REACH - start
    return np.where(distance < start, distance, start + room * np.tanh((distance - start) / room))


def _pose_leg(draft: Motion, side: str, state: Array, toes: Array, rotations: Array) -> None:
    """Thigh, shin, foot and toes of one leg: the ankle exactly where the footwork wants it, the knee over the foot.

    state : (F, 6) ankle m, pitch and yaw of the foot and yaw of the knee in degrees; toes : (F,) degrees
    """
    world = world_pose(draft)
    facing = quat_about_axis(1, np.radians(state[:, 5]))
    hip, pelvis = world.positions[:, joint(side + "UpLeg")], world.rotations[:, joint("Hips")]
    bend = np.radians(20.0)
    knee = hip + quat_rotate(facing, np.array([0.0, -THIGH * np.cos(bend), THIGH * np.sin(bend)]))
    ankle = knee + quat_rotate(facing, np.array([0.0, -SHANK * np.cos(bend), -SHANK * np.sin(bend)]))
    turns = two_bone_ik(hip, knee, ankle, state[:, :3])
    thigh = quat_multiply(turns[0], quat_multiply(facing, quat_about_axis(0, -bend)))
    shin = quat_multiply(turns[1], quat_multiply(facing, quat_about_axis(0, bend)))
    sole = foot_turn(state[:, 3], state[:, 4])
    rotations[:, joint(side + "UpLeg")] = quat_multiply(quat_conjugate(pelvis), thigh)
    rotations[:, joint(side + "Leg")] = quat_multiply(quat_conjugate(thigh), shin)
    rotations[:, joint(side + "Foot")] = quat_multiply(quat_conjugate(shin), sole)
    rotations[:, joint(side + "ToeBase")] = quat_about_axis(0, -np.radians(toes))
