"""Feet that stand: how a foot is turned when it is flat on the ground, told by the rest pose or by a motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import WorldPose
from kinestitch.core.rotation import Array, quat_between, quat_conjugate, quat_mean, quat_multiply
from kinestitch.rig.families import LIMBS, SIDES
from kinestitch.rig.posing import FORWARD, OFF, UP, Posing

_SOLES = (-0.03, 0.12)  # leg lengths: toes that rest at such a height rest on the ground
_FLAT_FOOT = np.radians(30.0)  # by which the toes lie below the ankle where neither rest nor motion tells
_PITCHES = (0.2, 0.75)  # sines of that angle that feet have
_STILLEST = 10  # a foot stands in one frame of so many


@dataclass(frozen=True, eq=False, slots=True)
class Standing:
    """How the feet of a motion stand where they move least.

    pitch : rad by which the toes lie below the ankle; toes : side → (4,) turn of the toe joint against the foot
    """

    pitch: float
    toes: Mapping[str, Array]


def standing_feet(joints: Mapping[str, int], moving: WorldPose | None) -> Standing:
    """Both feet's stillest frames; the smaller of their pitches counts, since heels are lifted and toes are not."""
    pitches, toes = [], {}
    for side in SIDES:
        foot, toe = joints.get(f"{side}_foot"), joints.get(f"{side}_toe")
        if foot is None or toe is None or moving is None or len(moving.positions) < 2:
            continue
        ends = moving.positions[:, [foot, toe]]
        speed = np.linalg.norm(np.diff(ends, axis=0), axis=-1).sum(axis=-1)
        still = np.argsort(speed, kind="stable")[: max(3, len(speed) // _STILLEST)]
        bone = ends[still, 0] - ends[still, 1]
        sines = bone[:, 1] / np.maximum(np.linalg.norm(bone, axis=-1), 1e-12)
        pitches.append(np.arcsin(np.clip(np.median(sines), *_PITCHES)))
        turns = quat_multiply(quat_conjugate(moving.rotations[still, foot]), moving.rotations[still, toe])
        toes[side] = quat_mean(turns)
    return Standing(float(min(pitches)) if pitches else _FLAT_FOOT, toes)


def is_grounded(pose: Posing) -> bool:
    """Whether the feet of a rest pose stand on height 0: toes ahead of the ankles and near the ground."""
    for side in SIDES:
        chain = [pose.joints.get(f"{side}_{part}") for part in (*LIMBS["leg"], "toe")]
        if any(joint is None for joint in chain):
            return False
        places = pose.rest[[joint for joint in chain if joint is not None]]
        height = places[3, 1] / np.linalg.norm(np.diff(places[:3], axis=0), axis=-1).sum()
        bone = places[3] - places[2]
        if not _SOLES[0] < height < _SOLES[1] or np.hypot(bone[0], bone[2]) < np.cos(OFF) * np.linalg.norm(bone):
            return False
    return True


def flatten_foot(pose: Posing, side: str, flat: Array | None, standing: Standing) -> None:
    """Toes ahead, and the foot tilted as at rest, or as in `standing` where the rest pose's feet do not stand.

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
        if np.hypot(bone[0], bone[2]) > np.cos(OFF) and bone[2] > 0:
            pose.turn(foot, quat_between([bone[0], 0.0, bone[2]], FORWARD))
            return
    pose.turns = before
    pose.swing(foot, toe, FORWARD * np.cos(standing.pitch) - UP * np.sin(standing.pitch))
    if toe is not None and side in standing.toes:
        wanted = quat_multiply(pose.rotation(foot), standing.toes[side])
        pose.turn(toe, quat_multiply(wanted, quat_conjugate(pose.rotation(toe))))
    elif toe is not None:
        pose.swing(toe, None, FORWARD)
