"""Feet on the ground: how high a rig's ankles stand, and where a scaled foot has to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import WorldPose, rest_pose
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import SIDES
from kinestitch.rig.hips import hip_height
from kinestitch.rig.reference import Reference

_TALLEST_TOE, _TALLEST_ANKLE = 0.1, 0.25  # leg lengths
_LEVEL = np.array([1.0, 0.0, 1.0])
_ROLL = 0.03  # leg lengths over which the weight passes from heel to toe


@dataclass(frozen=True, slots=True)
class Stance:
    """How a rig stands, in m.

    leg : from hip joint to ankle along the bones
    ankle, foot : of a flat foot, the ankle's height over the toe joint and its distance behind it; on a rig without
    toes the ankle's height over the ground, None where nothing tells
    toe : height of the toe joint over the ground, None where nothing tells
    """

    leg: float
    ankle: float | None
    foot: float
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
        ankles = [joints[f"{side}_foot"] for side in SIDES if f"{side}_foot" in joints]
        return Stance(leg, _lowest(skeleton, ankles, leg, moving), 0.0, 0.0)
    _, ankle, foot = np.mean([pose.positions[foot] - pose.positions[toe] for foot, toe in feet], axis=0).tolist()
    toes = [toe for _, toe in feet]
    if pose.grounded:
        return Stance(leg, ankle, -foot, float(rest_pose(skeleton)[0][toes, 1].mean()))
    if moving is None:
        return Stance(leg, ankle, -foot, None)
    lowest = float(np.percentile(moving.positions[:, toes, 1], 2, axis=0).mean())
    return Stance(leg, ankle, -foot, lowest if 0 <= lowest < _TALLEST_TOE * leg else None)


def _lowest(skeleton: Skeleton, ankles: list[int], leg: float, moving: WorldPose | None) -> float | None:
    """Height in m at which ankles stand, from the rest pose or a motion; None where neither shows a likely one."""
    if not ankles:
        return None
    heights = [rest_pose(skeleton)[0][ankles, 1].mean()]
    if moving is not None:
        heights.append(np.percentile(moving.positions[:, ankles, 1], 2, axis=0).mean())
    return next((float(height) for height in heights if 0 < height < _TALLEST_ANKLE * leg), None)


def _length(positions: Array, chain: list[int]) -> float:
    return float(np.linalg.norm(np.diff(positions[chain], axis=0), axis=-1).sum())


@dataclass(frozen=True, slots=True)
class Ground:
    """How places of one rig become places of another: scaled about the origin, feet lifted to their own height.

    scale : ratio of the heights of the hip joints over the ground
    toe, ankle : m to add to the height of a scaled toe joint or ankle
    ahead : m by which the toe joint stands further ahead of the ankle than on the scaled source
    """

    scale: float
    toe: float
    ankle: float
    ahead: float

    def move(self, points: Array, lift: float = 0.0) -> Array:
        """Points (..., 3) m, scaled and lifted."""
        out = points * self.scale
        out[..., 1] += lift
        return out


def ground(source: Stance, target: Stance) -> Ground:
    """The map between two rigs' places; where one does not tell how high it stands, both are taken as alike."""
    toes = (0.0, 0.0) if source.toe is None or target.toe is None else (source.toe, target.toe)
    share = target.leg / source.leg
    ankles = (
        source.ankle if source.ankle is not None else (target.ankle or 0.0) / share,
        target.ankle if target.ankle is not None else (source.ankle or 0.0) * share,
    )
    scale = (target.leg + ankles[1] + toes[1]) / (source.leg + ankles[0] + toes[0])
    toe = toes[1] - scale * toes[0]
    return Ground(scale, toe, toe + ankles[1] - scale * ankles[0], target.foot - scale * source.foot)


def ankle_targets(
    source: WorldPose, joints: tuple[int, int | None], rig: Stance, places: Ground, offsets: tuple[Array, Array, Array]
) -> Array:
    """Where a foot's ankle has to be, (F, 3) m.

    joints : the source's foot and toe
    offsets : (F, 3) each. m from ankle to toe joint on the target, as its foot is turned; m by which the target's hip
    joint stands further out than the scaled source's (its level part counts, so that a broad body keeps a broad
    stance); and the direction ahead of the toes

    A foot that stands on its toes keeps them in place, one that stands on its heel the ankle above it.
    """
    foot, toe = joints
    reach, aside, ahead = offsets
    beside = aside * _LEVEL
    ankle = source.positions[:, foot]
    by_heel = places.move(ankle, places.ankle) + beside
    if toe is None:
        return by_heel
    tip = source.positions[:, toe]
    by_toe = places.move(tip, places.toe) + beside + places.ahead * ahead * _LEVEL - reach
    raised = (ankle[:, 1] - (rig.ankle or 0.0) - tip[:, 1]) / (_ROLL * rig.leg)
    weight = np.clip(0.5 + raised / 2, 0.0, 1.0)[:, None]
    return weight * by_toe + (1 - weight) * by_heel
