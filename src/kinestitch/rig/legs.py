"""A retargeted body's place and legs: hips on the scaled path, ankles where the scaled feet stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import WorldPose, two_bone_ik, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import LIMBS, SIDES
from kinestitch.rig.feet import Ground, Stance, ankle_targets, ground, stance
from kinestitch.rig.posing import FORWARD
from kinestitch.rig.reference import Reference


@dataclass(frozen=True, eq=False, slots=True)
class Legs:
    """What has to be known of two rigs to carry the legs of one over to the other.

    world : the source's world pose; ours, theirs : role → joint on the source and on the target
    standing : how the source stands; places : how its places become the target's
    skeleton, pose : the target, and how it looks in the common pose
    """

    world: WorldPose
    ours: Mapping[str, int]
    theirs: Mapping[str, int]
    standing: Stance
    places: Ground
    skeleton: Skeleton
    pose: Reference


def measured_legs(
    world: WorldPose,
    skeletons: tuple[Skeleton, Skeleton],
    roles: tuple[Mapping[str, int], Mapping[str, int]],
    poses: tuple[Reference, Reference],
    example: Motion | None,
) -> Legs:
    """Measure source and target; `example` is a motion of the target."""
    moving = world_pose(example) if example is not None else None
    standing = stance(skeletons[0], roles[0], poses[0], world)
    places = ground(standing, stance(skeletons[1], roles[1], poses[1], moving))
    return Legs(world, *roles, standing, places, skeletons[1], poses[1])


def hips_place(legs: Legs, rotations: Array) -> Array:
    """World positions (F, 3) m of the target's hips, for world rotations (F, J, 4) of its joints.

    The middle between the hip joints goes the scaled way of the source's; without legs on both rigs the hips do.
    """
    tops = [f"{side}_upper_leg" for side in SIDES]
    if not all(top in legs.ours and top in legs.theirs for top in tops):
        return legs.places.move(legs.world.positions[:, legs.ours["hips"]])
    middle = legs.world.positions[:, [legs.ours[top] for top in tops]].mean(axis=1)
    return legs.places.move(middle) - _middle(legs, rotations)


def _middle(legs: Legs, rotations: Array) -> Array:
    """From the target's hips to the middle between its hip joints, (F, 3) m."""
    hips = legs.theirs["hips"]
    ways = [way_down(legs.skeleton, hips, legs.theirs[f"{side}_upper_leg"], rotations) for side in SIDES]
    return np.mean(ways, axis=0)


def way_down(skeleton: Skeleton, start: int, joint: int, rotations: Array) -> Array:
    """From one joint to another below it, (F, 3) m in the world, for world rotations (F, J, 4) and rest offsets."""
    chain = skeleton.chain(joint)
    total = np.zeros((len(rotations), 3))
    for below in chain[chain.index(start) + 1 :]:
        total += quat_rotate(rotations[:, skeleton.parents[below]], skeleton.offsets[below])
    return total


def planted_legs(legs: Legs, turned: Mapping[int, Array], rotations: Array, place: Array) -> dict[int, Array]:
    """World rotations (F, 4) of thighs and shins that bring the ankles where they have to be; feet keep their turn.

    turned : world rotations of the mapped joints; rotations : (F, J, 4) of all joints; place : (F, 3) m of the hips
    """
    hips, bent = legs.theirs["hips"], {}
    roles = [tuple(f"{side}_{part}" for part in LIMBS["leg"]) for side in SIDES]
    if not all(role in legs.ours and legs.theirs.get(role) in turned for leg in roles for role in leg):
        return {}
    for side, leg in zip(SIDES, roles, strict=True):
        thigh, shin, foot = (legs.theirs[role] for role in leg)
        target = _ankle_target(legs, side, turned, rotations)
        top, knee, ankle = (place + way_down(legs.skeleton, hips, joint, rotations) for joint in (thigh, shin, foot))
        by_thigh, by_shin = two_bone_ik(top, knee, ankle, target)
        bent[thigh] = quat_multiply(by_thigh, turned[thigh])
        bent[shin] = quat_multiply(by_shin, turned[shin])
    return bent


def _ankle_target(legs: Legs, side: str, turned: Mapping[int, Array], rotations: Array) -> Array:
    """Where an ankle has to be, (F, 3) m."""
    foot, toe = legs.theirs[f"{side}_foot"], legs.theirs.get(f"{side}_toe")
    own_toe = legs.ours.get(f"{side}_toe") if toe is not None else None
    reach = way_down(legs.skeleton, foot, toe, rotations) if toe is not None else np.zeros((len(rotations), 3))
    tip = toe if toe in turned else foot
    assert tip is not None
    turn = quat_multiply(rotations[:, tip], quat_conjugate(legs.pose.rotations[tip]))
    tops = [legs.ours[f"{name}_upper_leg"] for name in SIDES]
    out = legs.world.positions[:, legs.ours[f"{side}_upper_leg"]] - legs.world.positions[:, tops].mean(axis=1)
    wider = way_down(legs.skeleton, legs.theirs["hips"], legs.theirs[f"{side}_upper_leg"], rotations)
    aside = wider - _middle(legs, rotations) - legs.places.scale * out
    return ankle_targets(
        legs.world,
        (legs.ours[f"{side}_foot"], own_toe),
        legs.standing,
        legs.places,
        (reach, aside, quat_rotate(turn, FORWARD)),
    )
