"""The parts of a body that may move in their own time: trunk, arms and legs."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.families import SIDES
from kinestitch.rig.roles import roles_of

BODY = "body"
_LIMBS = {"arm": ("shoulder", "upper_arm"), "leg": ("upper_leg",)}


@lru_cache(maxsize=64)
def joint_groups(skeleton: Skeleton) -> Mapping[str, tuple[int, ...]]:
    """Every joint once: ``body``, then as far as they are found ``left_arm``, ``left_leg``, ``right_arm`` and
    ``right_leg``.

    An arm begins at its shoulder and a leg at its hip, and each has all that hangs on it. Joints above the hips, spine
    and head are the body; a rig whose limbs nobody can tell is body alone.

    >>> from kinestitch.samples import sample
    >>> [len(joints) for joints in joint_groups(sample("walk").skeleton).values()]
    [7, 8, 5, 8, 5]
    """
    roles = roles_of(skeleton).joints
    tops: dict[int, str] = {}
    for side in SIDES:
        for limb, parts in _LIMBS.items():
            top = next((roles[f"{side}_{part}"] for part in parts if f"{side}_{part}" in roles), None)
            if top is not None:
                tops[top] = f"{side}_{limb}"
    found: dict[str, list[int]] = {name: [] for name in (BODY, *tops.values())}
    owner: list[str] = []
    for joint, parent in enumerate(skeleton.parents):
        owner.append(tops.get(joint, owner[parent] if parent >= 0 else BODY))
        found[owner[joint]].append(joint)
    return MappingProxyType({name: tuple(joints) for name, joints in found.items()})
