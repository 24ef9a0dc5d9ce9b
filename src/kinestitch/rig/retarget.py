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

from kinestitch.core.kinematics import WorldPose, rest_pose, world_pose
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
from kinestitch.rig.legs import hips_place, measured_legs, planted_legs, way_down
from kinestitch.rig.mapping import Mapping, check_mapping, find_mapping, unmatched
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

    Raises SkeletonMismatchError where the names do not tell all main joints, the mapping names joints that are not
    there, or the example moves another rig.
    """
    own = motion.skeleton
    mapping = _settled(own, skeleton, mapping, example)
    roles = _known_roles(own, skeleton, mapping)
    world = world_pose(motion)
    poses = reference(own, roles[0], motion), reference(skeleton, roles[1], example)
    turned = _turned(mapping, world, own, skeleton, poses)
    rotations = _carry(skeleton, turned, motion.frames)
    legs = measured_legs(world, (own, skeleton), roles, poses, example)
    place = hips_place(legs, rotations)
    if foot_ik:
        turned |= planted_legs(legs, turned, rotations, place)
        rotations = _carry(skeleton, turned, motion.frames)
    hips = roles[1]["hips"]
    result = replace(
        motion,
        skeleton=skeleton,
        rotations=_local_rotations(skeleton, rotations),
        translations=_local_translations(skeleton, rotations, hips, place),
    )
    return Retargeted(result, mapping, mapping.unmapped(skeleton))


def _settled(source: Skeleton, target: Skeleton, mapping: Mapping | None, example: Motion | None) -> Mapping:
    """The mapping to use, after all that can be refused before anything is computed."""
    if mapping is None:
        mapping = find_mapping(source, target)
        if not mapping.certain:
            raise SkeletonMismatchError(
                f"Expected rigs whose main joints are known by name, got names that do not tell {unmatched(mapping)}. "
                "Save a mapping, edit it, and pass it."
            )
    check_mapping(mapping, source, target)
    if example is not None and example.skeleton != target:
        raise SkeletonMismatchError("Expected an example that moves the target rig, got one of another rig.")
    return mapping


def _known_roles(source: Skeleton, target: Skeleton, mapping: Mapping) -> tuple[dict[str, int], dict[str, int]]:
    """The roles of both rigs; where names tell nothing, a joint plays what its counterpart in the mapping plays."""
    ours, theirs = dict(roles_of(source).joints), dict(roles_of(target).joints)
    played = {joint: role for role, joint in ours.items()}, {joint: role for role, joint in theirs.items()}
    for pair in mapping.pairs:
        if pair.towards:
            continue
        a, b = source.index(pair.source), target.index(pair.target)
        if a in played[0] and b not in played[1]:
            theirs[played[0][a]] = b
        elif b in played[1] and a not in played[0]:
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
        from_root = rest_pose(skeleton)[0][0] + way_down(skeleton, 0, above, rotations)
        translations[:, hips] = quat_rotate(quat_conjugate(rotations[:, above]), place - from_root)
    return translations
