"""A motion told on the skeleton of the file whose character it shall move."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from kinestitch.core.kinematics import local_from_world, rest_pose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_distance, quat_multiply, quat_normalize, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import SkeletonMismatchError

SAME_PLACE = 0.01
"""Share of the body's size by which joints of one body may rest apart."""

_PREFIX = re.compile(r"(?i)^(.*:|mixamorig\d*_)")
_NAMED = 4


def told_on(motion: Motion, skeleton: Skeleton) -> Motion:
    """The motion on `skeleton`, a file's: world positions stay, joints get that skeleton's order and axes.

    Joints are matched by name, or without what stands before a colon (``mixamorig8:Hips`` is ``Hips``). Joints that
    only `skeleton` has keep their rest in their parent's frame.

    Raises SkeletonMismatchError that names joints which `skeleton` lacks, or one that rests elsewhere.
    """
    if motion.skeleton == skeleton:
        return motion
    places = _places(motion.skeleton, skeleton)
    axes = _axes(motion.skeleton, skeleton, places)
    pose = world_pose(motion)
    positions = np.empty((motion.frames, skeleton.joint_count, 3))
    rotations = np.empty((motion.frames, skeleton.joint_count, 4))
    for joint, parent in enumerate(skeleton.parents):
        own = places[joint]
        if own >= 0:
            positions[:, joint] = pose.positions[:, own]
            rotations[:, joint] = quat_multiply(pose.rotations[:, own], axes[joint])
        elif parent < 0:
            positions[:, joint], rotations[:, joint] = skeleton.offsets[joint], skeleton.rest[joint]
        else:
            moved = quat_rotate(rotations[:, parent], skeleton.offsets[joint])
            positions[:, joint] = positions[:, parent] + moved
            rotations[:, joint] = quat_multiply(rotations[:, parent], skeleton.rest[joint])
    translations, local = local_from_world(skeleton, positions, quat_normalize(rotations))
    return replace(motion, skeleton=skeleton, translations=translations, rotations=quat_normalize(local))


def _bare(name: str) -> str:
    return _PREFIX.sub("", name).strip().lower()


def _places(own: Skeleton, skeleton: Skeleton) -> list[int]:
    """For each joint of `skeleton` that of the motion which moves it, -1 where there is none."""
    ours, wanted = list(own.names), list(skeleton.names)
    if not set(ours) <= set(wanted):
        bare = [_bare(name) for name in ours], [_bare(name) for name in wanted]
        if all(len(set(names)) == len(names) for names in bare):
            ours, wanted = bare
    place = {name: joint for joint, name in enumerate(ours)}
    known = set(wanted)
    missing = [own.names[joint] for name, joint in place.items() if name not in known]
    if missing:
        more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
        raise SkeletonMismatchError(
            f"Expected joints of the file whose character is kept, got {', '.join(map(repr, missing[:_NAMED]))}{more}, "
            "which it has not. Retarget first, or write a skeleton alone."
        )
    return [place.get(name, -1) for name in wanted]


def _axes(own: Skeleton, skeleton: Skeleton, places: list[int]) -> Array:
    """Rotations (J, 4) from each joint's axes in `skeleton` to those of the motion: what both call their rest differs
    by no more than that.
    """
    ours, theirs = rest_pose(own), rest_pose(skeleton)
    shared = [joint for joint, place in enumerate(places) if place >= 0]
    pick = [places[joint] for joint in shared]
    axes = np.zeros((skeleton.joint_count, 4))
    axes[:, 3] = 1.0
    turn = quat_multiply(quat_conjugate(ours[1][pick]), theirs[1][shared])
    if (np.abs(quat_distance(turn, axes[shared])) > 1e-6).any():
        axes[shared] = turn
    there = theirs[0][shared] - theirs[0][shared[0]]
    here = ours[0][pick] - ours[0][pick[0]]
    size = float(np.ptp(theirs[0], axis=0).max())
    apart = np.linalg.norm(here - there, axis=-1)
    worst = int(np.argmax(apart))
    if apart[worst] > SAME_PLACE * size + 1e-6:
        raise SkeletonMismatchError(
            f"Expected the body of the file whose character is kept, got one whose {own.names[pick[worst]]!r} rests "
            f"{apart[worst]:.3g} m elsewhere. Retarget first, or write a skeleton alone."
        )
    return quat_normalize(axes)
