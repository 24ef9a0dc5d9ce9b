"""A motion told as another BVH file tells its own: the same joints, order, offsets, unit and channels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_to_euler
from kinestitch.files.bvh_hierarchy import Node
from kinestitch.files.bvh_writing import turn_order

_STILL = 1e-9


def channels_for(motion: Motion, nodes: list[Node]) -> list[Node]:
    """The file's joints, with channels added where theirs cannot tell the motion: a knee that had one axis and turns
    about three, a joint without position channels that leaves its offset.
    """
    result = []
    for joint, node in enumerate(nodes):
        places = [channel for channel in node.channels if channel.endswith("position")]
        turns = [channel for channel in node.channels if channel.endswith("rotation")]
        order = turn_order(node)
        away = np.abs(motion.translations[:, joint] - motion.skeleton.offsets[joint]).max(axis=0)
        untold = [axis for axis in "XYZ" if f"{axis}position" not in places]
        more = len(places) < 3 and any(away["XYZ".index(axis)] > _STILL for axis in untold)
        angles = np.abs(quat_to_euler(motion.rotations[:, joint], order)).max(axis=0)
        known = len(dict.fromkeys(turns))
        full = known < len(turns) or any(angles[known:] > _STILL)
        channels = node.channels
        if more or full:
            moves = ["Xposition", "Yposition", "Zposition"] if more else places
            channels = [*moves, *([f"{axis}rotation" for axis in order] if full else turns)]
        result.append(replace(node, channels=channels))
    return result
