"""Two clips of one rig: the same joints under another prefix, in another order, on longer bones, in other axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.kinematics import rest_pose, with_joint_axes
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import SkeletonMismatchError
from kinestitch.rig.hips import bare_name, hip_height, hips_joint

_DIRECTION_TOLERANCE = np.cos(np.radians(15.0))
_SAME_SIZE = 1e-3


def match_motion(motion: Motion, skeleton: Skeleton) -> Motion:
    """The motion told on `skeleton`, where both are the same rig in all but prefix, joint order, bone lengths or
    joint axes.

    Rotations are kept; where the bones are longer or shorter, translations take the proportions of `skeleton` and the
    root's travel is scaled by the ratio of hip heights. Rigs of one size keep every number.

    Raises SkeletonMismatchError that names the first joints that differ.
    """
    own = motion.skeleton
    if own is skeleton or own == skeleton:
        return motion
    motion = _in_order(motion, skeleton)
    bones = _bones(skeleton)
    if not _directions_agree(motion.skeleton.offsets[bones], skeleton.offsets[bones]).all():
        motion = _in_axes(motion, skeleton)
    return _in_size(motion, skeleton)


def _in_order(motion: Motion, skeleton: Skeleton) -> Motion:
    own = motion.skeleton
    ours = [bare_name(name) for name in own.names]
    theirs = [bare_name(name) for name in skeleton.names]
    if sorted(ours) != sorted(theirs) or len(set(ours)) != len(ours):
        raise _mismatch(skeleton, own, theirs, ours)
    order = [ours.index(name) for name in theirs]
    for place, joint in enumerate(order):
        parent = own.parents[joint]
        above = ours[parent] if parent >= 0 else None
        wanted = theirs[skeleton.parents[place]] if skeleton.parents[place] >= 0 else None
        if above != wanted:
            raise SkeletonMismatchError(
                f"Skeletons differ at joint {place}: {skeleton.names[place]!r} hangs on {wanted!r} and on {above!r}. "
                "Rename or retarget first."
            )
    renamed = Skeleton(skeleton.names, skeleton.parents, own.offsets[order], own.rest[order], own.tips[order])
    return replace(
        motion, skeleton=renamed, translations=motion.translations[:, order], rotations=motion.rotations[:, order]
    )


def _mismatch(skeleton: Skeleton, own: Skeleton, theirs: list[str], ours: list[str]) -> SkeletonMismatchError:
    """Names the first joints that the other rig lacks; mere differences of order do not count."""
    lacking = [
        index
        for a, b in ((theirs, ours), (ours, theirs))
        for index, name in enumerate(a)
        if name not in b or a.count(name) > 1
    ]
    place = min(lacking, default=0)
    left = repr(skeleton.names[place]) if place < len(theirs) else "nothing"
    right = repr(own.names[place]) if place < len(ours) else "nothing"
    return SkeletonMismatchError(
        f"Skeletons differ at joint {place}: {left} and {right} "
        f"({skeleton.joint_count} and {own.joint_count} joints). Rename or retarget first."
    )


def _directions_agree(a: Array, b: Array) -> np.ndarray:
    long = np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1)
    return np.einsum("ji,ji->j", a, b) >= _DIRECTION_TOLERANCE * long - 1e-12


def _bones(skeleton: Skeleton) -> list[int]:
    """The joints whose rest offset is a bone of the body: all but those from the root down to the hips, which carry
    the place.
    """
    place = set(skeleton.chain(hips_joint(skeleton)))
    return [joint for joint in range(skeleton.joint_count) if joint not in place]


def _in_axes(motion: Motion, skeleton: Skeleton) -> Motion:
    """Told in the joint axes of `skeleton`, if both rest poses show the same body in the same pose."""
    positions, _ = rest_pose(motion.skeleton)
    wanted, axes = rest_pose(skeleton)
    bones = _bones(skeleton)
    parents = skeleton.parent_array[bones]
    agree = _directions_agree(positions[bones] - positions[parents], wanted[bones] - wanted[parents])
    if not agree.all():
        joint = bones[int(np.argmin(agree))]
        raise SkeletonMismatchError(
            f"Rest poses differ at joint {joint}: {skeleton.names[joint]!r} points elsewhere. Retarget first."
        )
    return with_joint_axes(motion, axes)


def _in_size(motion: Motion, skeleton: Skeleton) -> Motion:
    own = motion.skeleton
    scale = hip_height(skeleton) / hip_height(own)
    bones = _bones(skeleton)
    lengths = np.linalg.norm(own.offsets[bones], axis=-1), np.linalg.norm(skeleton.offsets[bones], axis=-1)
    if abs(scale - 1) < _SAME_SIZE and np.allclose(*lengths, rtol=_SAME_SIZE, atol=1e-4):
        return replace(motion, skeleton=skeleton)
    translations = skeleton.offsets + (motion.translations - own.offsets) * scale
    translations[:, 0] = motion.translations[:, 0] * scale
    hips = hips_joint(skeleton)
    if hips != 0:
        translations[:, hips] = motion.translations[:, hips] * scale
    return replace(motion, skeleton=skeleton, translations=translations)
