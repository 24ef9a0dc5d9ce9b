"""The body's centre and size: which joint is the hips, and how high it stands."""

from __future__ import annotations

import re
from functools import lru_cache

import numpy as np

from kinestitch.core.kinematics import rest_pose
from kinestitch.core.mirror import lateral_axis, mirror_pairs
from kinestitch.core.rotation import Array, quat_conjugate, quat_rotate
from kinestitch.core.skeleton import Skeleton

_HIPS = re.compile(r"(?i)^(hips?|pelvis|bip0*1[ _]?pelvis|bip0*1|center_?hip|koshi|j_bip_c_hips|hip_?center)$")
_PREFIX = re.compile(r"(?i)^(.*:|mixamorig\d*_)")
_SUFFIX = re.compile(r"\.\d{3}$")


def bare_name(name: str) -> str:
    """A joint's name without its namespace or copy number.

    >>> bare_name("mixamorig8:Hips"), bare_name("mixamorig_Hips.001"), bare_name("LeftArm")
    ('Hips', 'Hips', 'LeftArm')
    """
    return _SUFFIX.sub("", _PREFIX.sub("", name))


@lru_cache(maxsize=64)
def hips_joint(skeleton: Skeleton) -> int:
    """Index of the hips: by name, else the joint where legs and spine part.

    Without a known name it is the joint nearest the root whose three largest branches hold at least two joints each;
    failing that the first joint with several children, failing that the root.
    """
    for joint, name in enumerate(skeleton.names):
        if _HIPS.match(bare_name(name)):
            return joint
    sizes = _subtree_sizes(skeleton)
    branches = [
        sorted((sizes[child] for child in skeleton.children(j)), reverse=True) for j in range(skeleton.joint_count)
    ]
    for joint, branch in enumerate(branches):
        if len(branch) >= 3 and branch[2] >= 2:
            return joint
    return next((joint for joint, branch in enumerate(branches) if len(branch) >= 2), 0)


def _subtree_sizes(skeleton: Skeleton) -> list[int]:
    sizes = [1] * skeleton.joint_count
    for joint in range(skeleton.joint_count - 1, 0, -1):
        sizes[skeleton.parents[joint]] += sizes[joint]
    return sizes


@lru_cache(maxsize=64)
def leg_roots(skeleton: Skeleton) -> tuple[int, int] | None:
    """Indices (left, right) of the joints where the legs leave the body: the mirrored pair nearest below the hips.

    Counterparts that stand in one place (the hip joints of ASF and CMU files) are passed over; among several pairs the
    one with the longest limbs counts.
    """
    pairs = mirror_pairs(skeleton)
    positions, _ = rest_pose(skeleton)
    apart = np.linalg.norm(positions - positions[list(pairs)], axis=-1) > 1e-6
    level = skeleton.children(hips_joint(skeleton))
    while level:
        found = [j for j in level if pairs[j] in level and apart[j]]
        if found:
            leg = max(found, key=lambda j: _leg_length(skeleton, j))
            sides = (leg, pairs[leg])
            lateral = lateral_axis(skeleton)
            return sides if (positions[sides[0]] - positions[sides[1]]) @ lateral > 0 else sides[::-1]
        level = tuple(child for joint in level for child in skeleton.children(joint))
    return None


def hip_line(skeleton: Skeleton) -> Array | None:
    """From the right leg's root to the left one's at rest, told in the hips' frame: (3,) m; None without legs."""
    legs = leg_roots(skeleton)
    if legs is None:
        return None
    positions, rotations = rest_pose(skeleton)
    hips = quat_conjugate(rotations[hips_joint(skeleton)])
    return quat_rotate(hips, positions[legs[0]] - positions[legs[1]])


def hip_height(skeleton: Skeleton) -> float:
    """The body's size in m: the length of a leg from hip joint to ankle, so the height of the hips above the ankles.

    Measured along the bones, so that it does not depend on the pose that a file calls rest.
    """
    legs = leg_roots(skeleton)
    starts = legs if legs is not None else (hips_joint(skeleton),)
    tallest = max(_leg_length(skeleton, start) for start in starts)
    return tallest if tallest > 0 else float(max(np.linalg.norm(skeleton.offsets, axis=-1).sum(), 1e-9))


def _leg_length(skeleton: Skeleton, start: int) -> float:
    lengths = np.linalg.norm(skeleton.offsets, axis=-1)
    reach = {start: 0.0}
    for joint in range(start + 1, skeleton.joint_count):
        parent = skeleton.parents[joint]
        if parent in reach:
            reach[joint] = reach[parent] + float(lengths[joint])
    return _to_ankle(skeleton, start, reach)


def _to_ankle(skeleton: Skeleton, start: int, reach: dict[int, float]) -> float:
    """Way from the leg's root to its second joint down (knee, ankle), or to the chain's end where it is shorter."""
    joint, steps = start, 0
    while steps < 2:
        children = skeleton.children(joint)
        if not children:
            break
        joint = max(children, key=lambda j: reach[j])
        steps += 1
    return reach[joint]
