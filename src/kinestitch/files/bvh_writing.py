"""A motion told as BVH text: the hierarchy, then one row of channel values for each frame."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from kinestitch.core.kinematics import with_joint_axes
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_identity, quat_to_euler
from kinestitch.files.bvh_hierarchy import Node
from kinestitch.files.naming import unique_names

ANGLE_DECIMALS = 6
"""Of a degree: 1e-6° is far below what a float32 rotation can tell."""

_STILL = 1e-9
_FRAMES_AT_A_TIME = 512


def in_world_axes(motion: Motion) -> Motion:
    """The motion with a rest pose of no rotations, which is the only one that BVH can tell."""
    return with_joint_axes(motion, quat_identity()) if np.any(motion.skeleton.rest[:, :3]) else motion


def length_decimals(metres: float) -> int:
    """Decimals of lengths in a unit of so many metres: a hundredth of a micrometre."""
    return int(np.clip(math.ceil(8 + math.log10(metres)), 2, 15))


def nodes_of(motion: Motion, metres: float, order: str) -> list[Node]:
    """The joints of a motion without rest rotations as a BVH file has them, lengths rounded as they will be written.

    The root has six channels; other joints have position channels only where their translation leaves the rest offset.
    A leaf without a tip gets an End Site of zero length.
    """
    skeleton = motion.skeleton
    names, _ = unique_names([re.sub(r"[\s{}]+", "_", name.strip()) or "_" for name in skeleton.names])
    decimals = length_decimals(metres)

    def lengths(values: Array) -> tuple[float, float, float]:
        x, y, z = np.round(values / metres, decimals) + 0.0
        return float(x), float(y), float(z)

    moving = np.abs(motion.translations - skeleton.offsets).max(axis=(0, 2)) > _STILL
    moving[0] = True
    turns = [f"{axis}rotation" for axis in order]
    leaves = set(range(skeleton.joint_count)) - set(skeleton.parents)
    return [
        Node(
            name,
            skeleton.parents[joint],
            lengths(skeleton.offsets[joint]),
            ["Xposition", "Yposition", "Zposition", *turns] if moving[joint] else turns,
            lengths(np.nan_to_num(skeleton.tips[joint]))
            if joint in leaves or np.isfinite(skeleton.tips[joint]).all()
            else None,
        )
        for joint, name in enumerate(names)
    ]


def hierarchy_text(nodes: list[Node], decimals: int) -> str:
    """The text from HIERARCHY to the last brace."""
    children: list[list[int]] = [[] for _ in nodes]
    for joint, node in enumerate(nodes[1:], start=1):
        children[node.parent].append(joint)
    lines = ["HIERARCHY"]
    stack: list[tuple[int, int]] = [(0, 0)]  # (joint, depth), or (-1, depth) to close a block
    while stack:
        joint, depth = stack.pop()
        indent = "\t" * depth
        if joint < 0:
            lines.append(indent + "}")
            continue
        node = nodes[joint]
        lines += [f"{indent}{'JOINT' if depth else 'ROOT'} {node.name}", indent + "{"]
        lines.append(f"{indent}\tOFFSET {_spelt(node.offset, decimals)}")
        lines.append(f"{indent}\tCHANNELS {len(node.channels)} {' '.join(node.channels)}")
        if node.tip is not None:
            lines += [
                f"{indent}\tEnd Site",
                indent + "\t{",
                f"{indent}\t\tOFFSET {_spelt(node.tip, decimals)}",
                indent + "\t}",
            ]
        stack.append((-1, depth))
        stack.extend((child, depth + 1) for child in reversed(children[joint]))
    return "\n".join(lines) + "\n"


def _spelt(values: tuple[float, float, float], decimals: int) -> str:
    return " ".join(f"{value:.{decimals}f}" for value in values)


def written_order(nodes: list[Node]) -> list[int]:
    """Joints in the order in which the hierarchy's text names them: depth first."""
    children: list[list[int]] = [[] for _ in nodes]
    for joint, node in enumerate(nodes[1:], start=1):
        children[node.parent].append(joint)
    stack, result = [0], []
    while stack:
        result.append(stack.pop())
        stack.extend(reversed(children[result[-1]]))
    return result


def turn_order(node: Node) -> str:
    """The Euler order in which a joint's rotations are told: its channels' axes, then those it has no channels for."""
    own = "".join(dict.fromkeys(channel[0] for channel in node.channels if channel.endswith("rotation")))
    return own + "".join(axis for axis in "ZXY" if axis not in own)


def row_texts(motion: Motion, nodes: list[Node], metres: float) -> Iterator[str]:
    """The rows of channel values, some hundred frames at a time; angles run on beyond ±180° rather than jump."""
    decimals = length_decimals(metres)
    columns = [(joint, channel) for joint in written_order(nodes) for channel in nodes[joint].channels]
    is_angle = np.array([channel.endswith("rotation") for _, channel in columns])
    row = " ".join(f"%.{ANGLE_DECIMALS if angle else decimals}f" for angle in is_angle) + "\n"
    places = [(joint, "XYZ".index(channel[0])) for joint, channel in columns if channel.endswith("position")]
    moved, along = np.array(places, dtype=np.intp).reshape(-1, 2).T
    orders: dict[str, list[int]] = {}
    for joint in dict.fromkeys(joint for (joint, _), angle in zip(columns, is_angle, strict=True) if angle):
        orders.setdefault(turn_order(nodes[joint]), []).append(joint)
    slots = {joint: 3 * k for k, joint in enumerate(joint for group in orders.values() for joint in group)}
    pick = [
        slots[joint] + turn_order(nodes[joint]).index(channel[0])
        for joint, channel in columns
        if channel.endswith("rotation")
    ]
    previous: Array | None = None
    for start in range(0, motion.frames, _FRAMES_AT_A_TIME):
        frames = slice(start, start + _FRAMES_AT_A_TIME)
        turned = [quat_to_euler(motion.rotations[frames][:, group], order) for order, group in orders.items()]
        angles = np.concatenate(turned, axis=1) if turned else np.zeros((len(motion.rotations[frames]), 0, 3))
        if previous is not None:
            angles = np.concatenate([previous, angles])
        angles = np.unwrap(angles, axis=0)[0 if previous is None else 1 :]
        previous = angles[-1:]
        values = np.empty((len(angles), len(is_angle)))
        values[:, is_angle] = np.round(np.degrees(angles), ANGLE_DECIMALS).reshape(len(angles), -1)[:, pick]
        values[:, ~is_angle] = np.round(motion.translations[frames][:, moved, along] / metres, decimals)
        values += 0.0  # no "-0.000000"
        yield row * len(values) % tuple(values.ravel().tolist())
