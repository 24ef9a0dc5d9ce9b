"""A motion as a glTF document: nodes in the rest pose, a skin, one animation, and the bytes they point to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kinestitch.core.kinematics import rest_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_continuous, quat_to_matrix
from kinestitch.core.skeleton import Skeleton

_FLOAT = 5126
_SAME = 1e-7
"""Channels that differ from the rest pose by no more than float32 can tell are left out."""


@dataclass(slots=True)
class _Builder:
    """The document's lists while they grow, and the pieces of its buffer."""

    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    pieces: list[bytes] = field(default_factory=list)
    size: int = 0

    def add(self, values: Array, kind: str, *, bounds: bool = False) -> int:
        """Index of a new accessor that holds the values (count, …) as float32."""
        data = np.ascontiguousarray(values, dtype="<f4")
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": data.nbytes})
        entry = {"bufferView": len(self.views) - 1, "componentType": _FLOAT, "count": len(data), "type": kind}
        if bounds:
            entry["min"], entry["max"] = [float(data.min())], [float(data.max())]
        self.accessors.append(entry)
        self.pieces.append(data.tobytes())
        self.size += data.nbytes
        return len(self.accessors) - 1


def document_of(motion: Motion) -> tuple[dict[str, Any], list[bytes]]:
    """The glTF document of a motion, and the pieces of its one buffer."""
    builder = _Builder()
    skeleton = motion.skeleton
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "kinestitch"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": _nodes(skeleton),
        "skins": [
            {
                "joints": list(range(skeleton.joint_count)),
                "skeleton": 0,
                "inverseBindMatrices": builder.add(_inverse_bind_matrices(skeleton), "MAT4"),
            }
        ],
        "animations": [_animation(motion, builder)],
    }
    document |= {
        "accessors": builder.accessors,
        "bufferViews": builder.views,
        "buffers": [{"byteLength": builder.size}],
    }
    return document, builder.pieces


def _nodes(skeleton: Skeleton) -> list[dict[str, Any]]:
    nodes: list[dict[str, Any]] = []
    rest = skeleton.rest.astype(np.float32).astype(float)
    for joint, name in enumerate(skeleton.names):
        node: dict[str, Any] = {"name": name}
        if below := skeleton.children(joint):
            node["children"] = list(below)
        node["translation"] = skeleton.offsets[joint].astype(np.float32).astype(float).tolist()
        node["rotation"] = rest[joint].tolist()
        nodes.append(node)
    return nodes


def _inverse_bind_matrices(skeleton: Skeleton) -> Array:
    """(J, 4, 4), column by column as glTF stores them."""
    positions, rotations = rest_pose(skeleton)
    turned_back = np.swapaxes(quat_to_matrix(rotations), -1, -2)
    matrices = np.zeros((skeleton.joint_count, 4, 4))
    matrices[:, :3, :3] = np.swapaxes(turned_back, -1, -2)
    matrices[:, 3, :3] = -(turned_back @ positions[..., None])[..., 0]
    matrices[:, 3, 3] = 1.0
    return matrices


def _animation(motion: Motion, builder: _Builder) -> dict[str, Any]:
    times = builder.add(np.arange(motion.frames) / motion.fps, "SCALAR", bounds=True)
    skeleton = motion.skeleton
    rotations = quat_continuous(motion.rotations)
    turned = 1.0 - np.abs(np.einsum("fji,ji->fj", rotations, skeleton.rest)).min(axis=0) > _SAME**2
    moved = np.abs(motion.translations - skeleton.offsets).max(axis=(0, 2)) > _SAME
    turned[0] = moved[0] = True  # the root's keys tell how many frames there are
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    for joint in range(skeleton.joint_count):
        for path, wanted, values, kind in (
            ("translation", moved[joint], motion.translations, "VEC3"),
            ("rotation", turned[joint], rotations, "VEC4"),
        ):
            if wanted:
                channels.append({"sampler": len(samplers), "target": {"node": joint, "path": path}})
                output = builder.add(values[:, joint], kind)
                samplers.append({"input": times, "interpolation": "LINEAR", "output": output})
    name = motion.name or "motion"
    return {"name": name, "samplers": samplers, "channels": channels, "extras": {"fps": motion.fps}}
