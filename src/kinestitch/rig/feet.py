"""Feet on the ground: how high a rig's ankles stand, and where a scaled foot has to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import WorldPose, rest_pose
from kinestitch.core.rotation import Array, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import SIDES
from kinestitch.rig.hips import hip_height
from kinestitch.rig.reference import Reference

_TALLEST_TOE = 0.1
_ROLL = 0.03  # leg lengths over which the weight passes from heel to toe


@dataclass(frozen=True, slots=True)
class Stance:
    """How a rig stands, in m.

    leg : from hip joint to ankle along the bones; ankle : height of a flat foot's ankle over its toe joint
    toe : height of the toe joint over the ground, None where nothing tells
    """

    leg: float
    ankle: float
    toe: float | None


def stance(skeleton: Skeleton, joints: Mapping[str, int], pose: Reference, moving: WorldPose | None) -> Stance:
    """Measure a rig in the common pose; `moving`, a motion of it, tells the ground where the rest pose does not."""
    legs = [
        [joints[f"{side}_{part}"] for part in ("upper_leg", "lower_leg", "foot")]
        for side in SIDES
        if f"{side}_foot" in joints
    ]
    leg = float(np.mean([_length(pose.positions, chain) for chain in legs])) if legs else hip_height(skeleton)
    feet = [(joints[f"{side}_foot"], joints[f"{side}_toe"]) for side in SIDES if f"{side}_toe" in joints]
    if not feet:
        return Stance(leg, 0.0, None)
    ankle = float(np.mean([pose.positions[foot, 1] - pose.positions[toe, 1] for foot, toe in feet]))
    toes = [toe for _, toe in feet]
    if pose.grounded:
        return Stance(leg, ankle, float(rest_pose(skeleton)[0][toes, 1].mean()))
    if moving is None:
        return Stance(leg, ankle, None)
    lowest = float(np.percentile(moving.positions[:, toes, 1], 2, axis=0).mean())
    return Stance(leg, ankle, lowest if 0 <= lowest < _TALLEST_TOE * leg else None)


def _length(positions: Array, chain: list[int]) -> float:
    return float(np.linalg.norm(np.diff(positions[chain], axis=0), axis=-1).sum())


@dataclass(frozen=True, slots=True)
class Ground:
    """How places of one rig become places of another: scaled about the origin, feet lifted to their own height.

    scale : ratio of the heights of the hip joints over the ground
    toe, ankle : m to add to the height of a scaled toe joint or ankle
    """

    scale: float
    toe: float
    ankle: float

    def move(self, points: Array, lift: float = 0.0) -> Array:
        """Points (..., 3) m, scaled and lifted."""
        out = points * self.scale
        out[..., 1] += lift
        return out


def ground(source: Stance, target: Stance) -> Ground:
    """The map between two rigs' places; where one does not tell how high its toes stand, both are taken as alike."""
    toes = (0.0, 0.0) if source.toe is None or target.toe is None else (source.toe, target.toe)
    scale = (target.leg + target.ankle + toes[1]) / (source.leg + source.ankle + toes[0])
    toe = toes[1] - scale * toes[0]
    return Ground(scale, toe, toe + target.ankle - scale * source.ankle)


def ankle_targets(
    source: WorldPose, joints: tuple[int, int | None], rig: Stance, places: Ground, reach: Array, aside: Array
) -> Array:
    """Where a foot's ankle has to be, (F, 3) m.

    joints : the source's foot and toe; reach : (F, 3) m, from ankle to toe joint on the target, as its foot is turned
    aside : (F, 3) m, by how much the target's hip joint stands further out than the scaled source's; its level part
    counts, so that a broad body keeps a broad stance

    A foot that stands on its toes keeps them in place, one that stands on its heel the ankle above it.
    """
    foot, toe = joints
    beside = aside * [1.0, 0.0, 1.0]
    ankle = source.positions[:, foot]
    by_heel = places.move(ankle, places.ankle) + beside
    if toe is None:
        return by_heel
    tip = source.positions[:, toe]
    by_toe = places.move(tip, places.toe) + beside - reach
    raised = (ankle[:, 1] - rig.ankle - tip[:, 1]) / (_ROLL * rig.leg)
    weight = np.clip(0.5 + raised / 2, 0.0, 1.0)[:, None]
    return weight * by_toe + (1 - weight) * by_heel


def toe_reach(skeleton: Skeleton, foot: int, toe: int | None, turned: Array) -> Array:
    """From ankle to toe joint, (F, 3) m, for world rotations (F, 4) of the foot; the joints between are at rest."""
    offset = np.zeros(3)
    if toe is not None:
        chain = skeleton.chain(toe)
        for joint in reversed(chain[chain.index(foot) + 1 :]):
            offset = skeleton.offsets[joint] + quat_rotate(skeleton.rest[joint], offset)
    return quat_rotate(turned, np.broadcast_to(offset, (len(turned), 3)))
