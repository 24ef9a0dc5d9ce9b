"""The body's centre and size: which joint is the hips, and how high it stands."""

from __future__ import annotations

import re
from functools import lru_cache

import numpy as np

from kinestitch.core.kinematics import rest_pose
from kinestitch.core.mirror import mirror_pairs
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
    failing
    that the first joint with several children, failing that the root.
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
    """Indices (left, right) of the joints where the legs leave the hips: the pair of mirrored children of the hips."""
    pairs = mirror_pairs(skeleton)
    positions, _ = rest_pose(skeleton)
    hips = hips_joint(skeleton)
    found = [j for j in skeleton.children(hips) if pairs[j] != j and pairs[j] in skeleton.children(hips)]
    if not found:
        return None
    from kinestitch.core.mirror import lateral_axis

    lateral = lateral_axis(skeleton)
    left = max(found, key=lambda j: float((positions[j] - positions[pairs[j]]) @ lateral))
    return left, pairs[left]


def hip_height(skeleton: Skeleton) -> float:
    """Height in m of the hips above the lowest joint when the legs are straight: the longest way down a leg.

    Measured along the bones, so that it does not depend on the pose that a file calls rest.
    """
    hips = hips_joint(skeleton)
    lengths = np.linalg.norm(skeleton.offsets, axis=-1)
    legs = leg_roots(skeleton)
    starts = legs if legs is not None else (hips,)
    tallest = 0.0
    for start in starts:
        reach = {start: 0.0}
        for joint in range(start + 1, skeleton.joint_count):
            parent = skeleton.parents[joint]
            if parent in reach:
                reach[joint] = reach[parent] + float(lengths[joint])
        tallest = max(tallest, _to_ankle(skeleton, start, reach))
    return tallest if tallest > 0 else float(max(lengths.sum(), 1e-9))


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
