"""The figure of a glTF file: its joints, its skeleton, and the animation that moves it."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import local_from_world
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import KinestitchWarning
from kinestitch.files.gltf_animation import Take, choose_take, frame_times
from kinestitch.files.gltf_document import GltfDocument, text
from kinestitch.files.gltf_rest import rest_pose_of
from kinestitch.files.gltf_scene import chain, choose_joints, parents_of
from kinestitch.files.naming import unique_names


@dataclass(frozen=True, slots=True)
class Figure:
    """What a motion is read from, or written into.

    parents : parent of each node of the document, -1 at the top
    joints : nodes that are joints, parents first; the skeleton's joints in its order
    moving : the joints and all nodes above them
    take : the animation, None where none moves the joints
    times : (F,) s of the take's frames; fps : their rate
    """

    document: GltfDocument
    parents: list[int]
    joints: list[int]
    skeleton: Skeleton
    moving: frozenset[int]
    take: Take | None
    times: Array
    fps: float


def open_figure(document: GltfDocument, take: str | None) -> Figure:
    """The file's figure with the animation called `take`, or that which :func:`choose_take` prefers.

    Raises FormatError where there are no joints, ParameterError for an unknown take.
    """
    parents = parents_of(document)
    chosen = choose_take(document, take, None) if not document.objects("skins") else None
    animated = {node for node, _ in chosen.tracks} if chosen else set()
    joints, joint_parents = choose_joints(document, parents, animated)
    moving = frozenset(node for joint in joints for node in chain(parents, joint))
    chosen = choose_take(document, take, moving)
    times, fps = frame_times(chosen, len(joints))
    skeleton = _skeleton(document, parents, joints, joint_parents)
    return Figure(document, parents, joints, skeleton, moving, chosen, times, fps)


def _skeleton(document: GltfDocument, parents: list[int], joints: list[int], joint_parents: list[int]) -> Skeleton:
    nodes = document.objects("nodes")
    names, repeated = unique_names([text(nodes[joint], "name", f"node {joint}") for joint in joints])
    if repeated:
        warnings.warn(
            KinestitchWarning(f"{repeated} joint name(s) used twice; a number was added to them."), stacklevel=5
        )
    positions, rotations = rest_pose_of(document, parents, joints)
    bare = Skeleton(tuple(names), tuple(joint_parents), np.zeros((len(joints), 3)))
    offsets, rest = local_from_world(bare, positions, rotations)
    return Skeleton(bare.names, bare.parents, offsets, rest)
