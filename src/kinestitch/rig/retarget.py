"""One rig's motion on another: the same turns in the world, on other bones.

Both rigs are put into one common pose (:mod:`kinestitch.rig.reference`). How far the source's joints have turned away
from it, told in the world's axes, is how far the target's joints turn; so joint axes and rest poses drop out, and twist
is kept. The path is scaled by the length of the legs, and the legs are bent so that the feet stand where the scaled
source's do.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np

from kinestitch.core.kinematics import WorldPose, rest_pose, two_bone_ik, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    quat_slerp,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import KinestitchWarning, SkeletonMismatchError
from kinestitch.rig.families import SIDES
from kinestitch.rig.feet import Ground, Stance, ankle_targets, ground, stance, toe_reach
from kinestitch.rig.mapping import Mapping, check_mapping, find_mapping
from kinestitch.rig.reference import Reference, reference
from kinestitch.rig.roles import roles_of


@dataclass(frozen=True, eq=False, slots=True)
class Retargeted:
    """A motion on another rig.

    mapping : the pairs that were used; unmapped : the target's joints that kept their rest
    """

    motion: Motion
    mapping: Mapping
    unmapped: tuple[str, ...]


def retarget(
    motion: Motion,
    skeleton: Skeleton,
    mapping: Mapping | None = None,
    *,
    foot_ik: bool = True,
    example: Motion | None = None,
) -> Motion:
    """The motion on another rig, as :func:`retargeted`; a KinestitchWarning counts the joints that keep their rest.

    A motion of this very rig comes back as it is.
    """
    if mapping is None and motion.skeleton == skeleton:
        return motion
    result = retargeted(motion, skeleton, mapping, foot_ik=foot_ik, example=example)
    if result.unmapped:
        warnings.warn(unmapped_note(result), KinestitchWarning, stacklevel=2)
    return result.motion


def unmapped_note(result: Retargeted) -> str:
    """A sentence that counts and names the joints which kept their rest."""
    few = ", ".join(result.unmapped[:4]) + ("…" if len(result.unmapped) > 4 else "")
    return f"{len(result.unmapped)} of {result.motion.skeleton.joint_count} joints keep their rest: {few}."


def retargeted(
    motion: Motion,
    skeleton: Skeleton,
    mapping: Mapping | None = None,
    *,
    foot_ik: bool = True,
    example: Motion | None = None,
) -> Retargeted:
    """The motion on another rig.

    mapping : which joints follow which; found by name where it is left out
    foot_ik : bend the legs so that the feet stand where the scaled source's do; without it the legs' directions are
    kept, and feet may slide where thighs, shins or hips have other proportions
    example : a motion of the target rig, which tells how its limbs bend where its rest pose shows no standing body

    All joints but the hips keep the target's bone lengths. Joints above the hips stand at rest.

    Raises SkeletonMismatchError where the names do not tell all main joints, or the mapping names joints that are not
    there.
    """
    own = motion.skeleton
    if mapping is None:
        mapping = find_mapping(own, skeleton)
        if not mapping.certain:
            raise SkeletonMismatchError(
                f"Expected two rigs whose main joints are known by name, got no {', no '.join(mapping.missing)}. "
                "Save a mapping, edit it, and pass it."
            )
    check_mapping(mapping, own, skeleton)
    roles = _known_roles(own, skeleton, mapping)
    world = world_pose(motion)
    poses = reference(own, roles[0], motion), reference(skeleton, roles[1], example)
    moving = world_pose(example) if example is not None else None
    stances = stance(own, roles[0], poses[0], world), stance(skeleton, roles[1], poses[1], moving)
    limbs = _Legs(world, roles, stances, ground(*stances))
    turned = _turned(mapping, world, own, skeleton, poses)
    hips = roles[1]["hips"]
    rotations = _carry(skeleton, turned, motion.frames)
    place = _hips_place(skeleton, limbs, rotations, hips)
    if foot_ik:
        _plant_feet(skeleton, limbs, turned, rotations, place)
        rotations = _carry(skeleton, turned, motion.frames)
    result = replace(
        motion,
        skeleton=skeleton,
        rotations=_local_rotations(skeleton, rotations),
        translations=_local_translations(skeleton, rotations, hips, place),
    )
    return Retargeted(result, mapping, mapping.unmapped(skeleton))


@dataclass(frozen=True, eq=False, slots=True)
class _Legs:
    """The source's world pose, and what is known of both rigs' joints, sizes and ground."""

    world: WorldPose
    roles: tuple[dict[str, int], dict[str, int]]
    stances: tuple[Stance, Stance]
    places: Ground


def _known_roles(source: Skeleton, target: Skeleton, mapping: Mapping) -> tuple[dict[str, int], dict[str, int]]:
    """The roles of both rigs; where names tell nothing, a joint plays what its counterpart in the mapping plays."""
    ours, theirs = dict(roles_of(source).joints), dict(roles_of(target).joints)
    played = {joint: role for role, joint in ours.items()}, {joint: role for role, joint in theirs.items()}
    for pair in mapping.pairs:
        if pair.towards:
            continue
        a, b = source.index(pair.source), target.index(pair.target)
        if a in played[0]:
            theirs[played[0][a]] = b
        elif b in played[1]:
            ours[played[1][b]] = a
    return ours, theirs


def _turned(
    mapping: Mapping, world: WorldPose, source: Skeleton, target: Skeleton, poses: tuple[Reference, Reference]
) -> dict[int, Array]:
    """World rotations (F, 4) of the target's mapped joints."""
    away: dict[int, Array] = {}

    def turn(name: str) -> Array:
        joint = source.index(name)
        if joint not in away:
            away[joint] = quat_multiply(world.rotations[:, joint], quat_conjugate(poses[0].rotations[joint]))
        return away[joint]

    turned = {}
    for pair in mapping.pairs:
        by = turn(pair.source)
        if pair.towards and pair.share:
            by = quat_slerp(by, turn(pair.towards), np.asarray(pair.share))
        joint = target.index(pair.target)
        turned[joint] = quat_multiply(by, poses[1].rotations[joint])
    return turned


def _carry(skeleton: Skeleton, turned: dict[int, Array], frames: int) -> Array:
    """World rotations (F, J, 4) of all joints: those that follow nothing stay at rest against their parents."""
    world = np.empty((frames, skeleton.joint_count, 4))
    for joint, parent in enumerate(skeleton.parents):
        if joint in turned:
            world[:, joint] = turned[joint]
        elif parent < 0:
            world[:, joint] = skeleton.rest[joint]
        else:
            world[:, joint] = quat_multiply(world[:, parent], skeleton.rest[joint])
    return quat_normalize(world)


def _hips_place(skeleton: Skeleton, limbs: _Legs, rotations: Array, hips: int) -> Array:
    """World positions (F, 3) m of the target's hips: the middle between its hip joints goes the source's scaled way."""
    ours, theirs = limbs.roles
    legs = [f"{side}_upper_leg" for side in SIDES if f"{side}_upper_leg" in ours and f"{side}_upper_leg" in theirs]
    sources = [ours[role] for role in legs] or [ours["hips"]]
    path = limbs.places.move(limbs.world.positions[:, sources].mean(axis=1))
    return path - _middle(skeleton, theirs, rotations) if legs else path


def _middle(skeleton: Skeleton, joints: dict[str, int], rotations: Array) -> Array:
    """From the hips to the middle between the hip joints, (F, 3) m in the world."""
    tops = [joints[f"{side}_upper_leg"] for side in SIDES if f"{side}_upper_leg" in joints]
    return np.mean([_offset(skeleton, joints["hips"], top, rotations) for top in tops], axis=0)


def _hip_joint(world: WorldPose, joints: dict[str, int], side: str) -> Array:
    """From the middle between the hip joints to one of them, (F, 3) m."""
    tops = [joints[f"{name}_upper_leg"] for name in SIDES if f"{name}_upper_leg" in joints]
    return world.positions[:, joints[f"{side}_upper_leg"]] - world.positions[:, tops].mean(axis=1)


def _offset(skeleton: Skeleton, start: int, joint: int, rotations: Array) -> Array:
    """From one joint to another below it, (F, 3) m in the world, for world rotations (F, J, 4)."""
    chain = skeleton.chain(joint)
    total = np.zeros((len(rotations), 3))
    for below in chain[chain.index(start) + 1 :]:
        total += quat_rotate(rotations[:, skeleton.parents[below]], skeleton.offsets[below])
    return total


def _plant_feet(skeleton: Skeleton, limbs: _Legs, turned: dict[int, Array], rotations: Array, place: Array) -> None:
    """Turn thighs and shins, in place of their entries in `turned`, until the ankles are where they have to be."""
    ours, theirs = limbs.roles
    hips = theirs["hips"]
    for side in SIDES:
        chain = [theirs.get(f"{side}_{part}") for part in ("upper_leg", "lower_leg", "foot")]
        if f"{side}_foot" not in ours or any(joint not in turned for joint in chain):
            continue
        thigh, shin, foot = (joint for joint in chain if joint is not None)
        toe = theirs.get(f"{side}_toe") if f"{side}_toe" in ours else None
        reach = toe_reach(skeleton, foot, toe, rotations[:, foot])
        source_joints = ours[f"{side}_foot"], ours[f"{side}_toe"] if toe is not None else None
        aside = _hip_joint(limbs.world, ours, side) * -limbs.places.scale
        aside += _offset(skeleton, hips, thigh, rotations) - _middle(skeleton, theirs, rotations)
        target = ankle_targets(limbs.world, source_joints, limbs.stances[0], limbs.places, reach, aside)
        top, knee, ankle = (place + _offset(skeleton, hips, joint, rotations) for joint in (thigh, shin, foot))
        by_thigh, by_shin = two_bone_ik(top, knee, ankle, target)
        turned[thigh] = quat_multiply(by_thigh, turned[thigh])
        turned[shin] = quat_multiply(by_shin, turned[shin])


def _local_rotations(skeleton: Skeleton, rotations: Array) -> Array:
    local = rotations.copy()
    parents = skeleton.parent_array[1:]
    local[:, 1:] = quat_multiply(quat_conjugate(rotations[:, parents]), rotations[:, 1:])
    return quat_normalize(local)


def _local_translations(skeleton: Skeleton, rotations: Array, hips: int, place: Array) -> Array:
    """(F, J, 3) m: every joint at its rest offset, but the hips, which are told in their parent's frame."""
    translations = np.broadcast_to(skeleton.offsets, (len(rotations), *skeleton.offsets.shape)).copy()
    if hips == 0:
        translations[:, 0] = place
    else:
        above = skeleton.parents[hips]
        from_root = rest_pose(skeleton)[0][0] + _offset(skeleton, 0, above, rotations)
        translations[:, hips] = quat_rotate(quat_conjugate(rotations[:, above]), place - from_root)
    return translations
