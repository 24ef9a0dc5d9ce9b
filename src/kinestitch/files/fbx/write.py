"""From a motion to a skeleton-only FBX file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.kinematics import rest_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_to_matrix
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError
from kinestitch.files.atomic import replacing
from kinestitch.files.fbx import build
from kinestitch.files.fbx.binary import serialise
from kinestitch.files.fbx.build import curve_keys, node, numbers, properties, vector
from kinestitch.files.fbx.euler import continuous_degrees
from kinestitch.files.fbx.keep import kept_document
from kinestitch.files.fbx.nodes import Document
from kinestitch.files.fbx.parts import Parts
from kinestitch.files.fbx.presets import PLAIN, Preset, in_file, preset_named
from kinestitch.files.fbx.transform import quat_degrees

_TINY_METRES, _TINY_DEG = 1e-7, 1e-6


def write_fbx(
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    take: str | None = None,
    like: str | os.PathLike[str] | None = None,
    preset: str | None = None,
) -> None:
    """Write a motion as a binary FBX file: a skeleton alone, or the character of another file.

    take : name of the animation stack; the motion's name when left out. With `like` the take to replace, by default
        the one that the reader chooses
    like : a binary FBX 7 file from which everything but the animation is kept
    preset : ``unity``, ``unreal``, ``blender`` or ``maya``: axes, units and root as that program likes them (see
        :data:`kinestitch.files.fbx.PRESETS`); not with `like`, whose file has axes and units of its own

    Without `like`: FBX 7.4 with bones, their rest pose and one take, at the motion's own frame rate, one key per
    frame; without `preset` centimetres and Y up. The rest pose stands as bind pose and as PreRotation, so that all
    local rotations at zero show it. Tips of leaf joints are left out.

    With `like`: meshes, skins, shapes, materials, textures, properties and other takes come out bit for bit. The
    curves of the joints in the base layer of the take are replaced, one key per frame from the take's own start on;
    its other layers let go of the joints; scale, and what is no joint but carries joints, stands still as at the
    take's first frame. Curves of anything else (shapes, cameras) stay, at their own times. Joints that only the file
    has keep their rest. The length is told in the take and the time line, the rate in the time line if it changes.

    Raises OutputError if the file cannot be written; ParameterError for an unknown preset or take, or a preset beside
    `like`; with `like` also SkeletonMismatchError that names joints which the file lacks, FormatError for text, FBX 6
    and older, curves that takes share, and scale that no rotation makes up for; FileNotFoundError.
    """
    told = preset_named(preset)
    if like is None:
        document = motion_document(motion, take or motion.name or "Take 001", told)
    elif preset is not None:
        raise ParameterError(f"Expected like= or preset=, got both. A kept file has its own axes and units. ({like})")
    else:
        document = kept_document(motion, Path(like), take)
    data = serialise(document)
    with replacing(path) as stream:
        stream.write(data)


def motion_document(motion: Motion, take: str, preset: Preset = PLAIN) -> Document:
    """The node tree of a file that holds nothing but this motion."""
    motion = in_file(motion, preset)
    parts = Parts()
    ticks = build.ticks_of(motion.frames, motion.fps)
    bones = _add_bones(parts, motion.skeleton)
    _add_bind_pose(parts, motion.skeleton, bones)
    stop = int(ticks[-1])
    _add_take(parts, motion, bones, ticks, take, _TINY_METRES / preset.unit)
    nodes = [
        *build.header(),
        build.settings(motion.fps, stop, preset.settings, preset.unit),
        *build.documents(parts.key(), take),
        build.definitions(parts.objects),
        node("Objects", children=parts.objects),
        node("Connections", children=parts.links),
        build.takes(take, stop),
    ]
    return Document(build.VERSION, tuple(nodes))


def _add_bones(parts: Parts, skeleton: Skeleton) -> list[int]:
    keys: list[int] = []
    turns = quat_degrees(skeleton.rest, 0)
    for joint, name in enumerate(skeleton.names):
        details = properties(
            vector("PreRotation", turns[joint]),
            ("RotationActive", "bool", "", "", [1]),
            ("InheritType", "enum", "", "", [1]),
            ("DefaultAttributeIndex", "int", "Integer", "", [0]),
            vector("Lcl Translation", skeleton.offsets[joint], "Lcl Translation"),
        )
        model = [node("Version", "I", 232), details, node("Shading", "C", ord("Y")), node("Culling", "S", "CullingOff")]
        keys.append(parts.add("Model", name, "LimbNode", model))
        flesh = parts.add("NodeAttribute", name, "LimbNode", [node("TypeFlags", "S", "Skeleton")])
        parent = skeleton.parents[joint]
        parts.link(keys[joint], keys[parent] if parent >= 0 else 0)
        parts.link(flesh, keys[joint])
    return keys


def _add_bind_pose(parts: Parts, skeleton: Skeleton, bones: list[int]) -> None:
    positions, rotations = rest_pose(skeleton)
    matrices = np.tile(np.eye(4), (len(bones), 1, 1))
    matrices[:, :3, :3] = np.swapaxes(quat_to_matrix(rotations), -1, -2)  # FBX multiplies row vectors
    matrices[:, 3, :3] = positions
    entries = [
        node("PoseNode", children=[node("Node", "L", key), numbers("Matrix", "d", matrix.ravel())])
        for key, matrix in zip(bones, matrices, strict=True)
    ]
    head = [node("Type", "S", "BindPose"), node("Version", "I", 100), node("NbPoseNodes", "I", len(bones))]
    parts.add("Pose", "BindPose", "BindPose", [*head, *entries])


def _add_take(parts: Parts, motion: Motion, bones: list[int], ticks: NDArray[np.int64], take: str, tiny: float) -> None:
    stop = int(ticks[-1])
    spans = [(name, "KTime", "Time", "", [tick]) for name, tick in (("LocalStart", 0), ("LocalStop", stop))]
    spans += [(name, "KTime", "Time", "", [tick]) for name, tick in (("ReferenceStart", 0), ("ReferenceStop", stop))]
    stack = parts.add("AnimationStack", take, "", [properties(*spans)])
    layer = parts.add("AnimationLayer", "BaseLayer", "", [])
    parts.link(layer, stack)
    for joint, name, short, values in _channels(motion, tiny):
        default = [(f"d|{axis}", "Number", "", "A", [float(values[0, i])]) for i, axis in enumerate("XYZ")]
        group = parts.add("AnimationCurveNode", short, "", [properties(*default)])
        parts.link(group, layer)
        parts.link(group, bones[joint], name)
        whole = joint == 0  # the root keeps every key, so that a still clip keeps its length
        for i, axis in enumerate("XYZ"):
            keys = values[:, i] if whole or np.ptp(values[:, i]) > 0 else values[:1, i]
            parts.link(parts.add("AnimationCurve", "", "", curve_keys(ticks[: len(keys)], keys)), group, f"d|{axis}")


def _channels(motion: Motion, tiny: float) -> Iterator[tuple[int, str, str, Array]]:
    """Joint, property, short name and values (F, 3) of everything that is not at rest throughout.

    motion : in the file's axes and units; tiny : a distance there that does not count
    """
    rest = motion.skeleton.rest
    degrees = continuous_degrees(quat_multiply(quat_conjugate(rest), motion.rotations))
    for joint in range(motion.skeleton.joint_count):
        moved = motion.translations[:, joint]
        home = motion.skeleton.offsets[joint]
        if joint == 0 or np.abs(moved - home).max() > tiny:
            yield joint, "Lcl Translation", "T", moved
        if joint == 0 or np.abs(degrees[:, joint]).max() > _TINY_DEG:
            yield joint, "Lcl Rotation", "R", degrees[:, joint]
