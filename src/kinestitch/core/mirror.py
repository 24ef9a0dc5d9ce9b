"""Left becomes right: the reflection of a motion in its rest pose's own plane of symmetry."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from kinestitch.core.kinematics import local_from_world, rest_pose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_normalize
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import SkeletonMismatchError

_WORD = re.compile(r"(?i)left|right")
_SIDE = re.compile(r"(?:(?<=[_.\- :])|^)([lLrR])(?=[_.\- ]|$|\d)|^([lr])(?=[A-Z])|^([LR])(?=[A-Z][a-z])")
_OTHER = {"left": "right", "right": "left", "l": "r", "r": "l"}


def _swap(match: re.Match[str]) -> str:
    found = match.group(0)
    other = _OTHER[found.lower()]
    if found.isupper():
        return other.upper()
    return other.capitalize() if found[0].isupper() else other


def mirrored_name(name: str) -> str:
    """The name of the joint on the other side, or the name itself: ``LeftArm`` ↔ ``RightArm``, ``Hand_L`` ↔ ``Hand_R``.

    >>> mirrored_name("mixamorig:LeftArm"), mirrored_name("thigh_l"), mirrored_name("Spine")
    ('mixamorig:RightArm', 'thigh_r', 'Spine')
    """
    prefix, colon, bare = name.rpartition(":")
    pattern = _WORD if _WORD.search(bare) else _SIDE
    return prefix + colon + pattern.sub(_swap, bare, count=1)


def mirror_pairs(skeleton: Skeleton) -> tuple[int, ...]:
    """For each joint the index of its counterpart on the other side (itself on the middle line).

    Where the rules of :func:`mirrored_name` find nothing, a first letter l or r counts too (``lfemur``, ``rfemur``),
    provided that the other joint exists.
    """
    place = {name: index for index, name in enumerate(skeleton.names)}

    def other(index: int, name: str) -> int:
        mirrored = mirrored_name(name)
        if mirrored == name:
            mirrored = _OTHER.get(name[:1], "") + name[1:]
        return place.get(mirrored, index)

    return tuple(other(index, name) for index, name in enumerate(skeleton.names))


def lateral_axis(skeleton: Skeleton) -> Array:
    """Unit vector (3,) from right to left in the rest pose's world; +X where no joint has a counterpart."""
    pairs = mirror_pairs(skeleton)
    positions, _ = rest_pose(skeleton)
    total = np.zeros(3)
    for joint, other in enumerate(pairs):
        if _is_left(skeleton.names[joint], skeleton.names[other]):
            total += positions[joint] - positions[other]
    size = np.linalg.norm(total)
    return total / size if size > 1e-9 else np.array([1.0, 0.0, 0.0])


def _is_left(name: str, other: str) -> bool:
    """Whether the first letter in which the names of two counterparts differ is an l."""
    return next((a in "lL" for a, b in zip(name, other, strict=False) if a != b), False)


def mirror(motion: Motion) -> Motion:
    """The motion with left and right exchanged, as seen in a mirror.

    Each joint's turn away from the rest pose, as the world sees it, is reflected in the rest pose's plane of symmetry
    through the origin and given to the joint's counterpart, so joint axes need no symmetry of their own. The mirror
    plane holds the world's origin; a clip that starts there starts there still. Mirroring twice gives the motion back
    where the rest pose is symmetric.

    Raises SkeletonMismatchError if no joint has a counterpart (names such as Left…/Right…, …_L/…_R are known).
    """
    skeleton = motion.skeleton
    pairs = np.array(mirror_pairs(skeleton))
    if (pairs == np.arange(len(pairs))).all():
        raise SkeletonMismatchError(
            f"Expected joints in left/right pairs, got none among {', '.join(skeleton.names[:4])}…. "
            "Name them Left…/Right…, …_L/…_R or l…/r…."
        )
    normal = lateral_axis(skeleton)
    world = world_pose(motion)
    _, rest = rest_pose(skeleton)
    turn = quat_multiply(world.rotations, quat_conjugate(rest))
    # Reflecting a rotation keeps w and the axis' part along the normal, and turns the rest of the axis round.
    axis = turn[..., :3]
    along = np.einsum("fji,i->fj", axis, normal)[..., None] * normal
    turn = np.concatenate([2 * along - axis, turn[..., 3:]], axis=-1)[:, pairs]
    rotations = quat_multiply(turn, rest)
    _, local = local_from_world(skeleton, np.zeros((motion.frames, skeleton.joint_count, 3)), rotations)
    return replace(motion, rotations=quat_normalize(local), translations=_mirror_translations(motion, normal, pairs))


def _mirror_translations(motion: Motion, normal: Array, pairs: np.ndarray) -> Array:
    """What each joint adds to its rest offset, reflected as the rest pose's world sees it; the root is reflected
    whole.
    """
    from kinestitch.core.rotation import quat_rotate

    skeleton = motion.skeleton
    _, rest = rest_pose(skeleton)
    parents = skeleton.parent_array
    frame = rest[np.where(parents < 0, 0, parents)].copy()
    frame[0] = [0.0, 0.0, 0.0, 1.0]
    base = skeleton.offsets.copy()
    base[0] = 0.0
    extra = quat_rotate(frame, motion.translations - base)
    reflected = extra - 2 * np.einsum("fji,i->fj", extra, normal)[..., None] * normal
    return base + quat_rotate(quat_conjugate(frame), reflected[:, pairs])
