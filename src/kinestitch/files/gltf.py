"""glTF in and out: the skeleton and animation of .glb and .gltf files."""

from __future__ import annotations

import base64
import json
import os
import warnings
from pathlib import Path

import numpy as np

from kinestitch.core.kinematics import local_from_world
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import KinestitchWarning
from kinestitch.files.atomic import replacing
from kinestitch.files.glb import BINARY_CHUNK, serialise_glb
from kinestitch.files.gltf_animation import Take, animation_name, choose_take, frame_times
from kinestitch.files.gltf_document import GltfDocument, load_document, text
from kinestitch.files.gltf_rest import rest_pose_of
from kinestitch.files.gltf_scene import chain, choose_joints, parents_of, rigid_poses, worlds
from kinestitch.files.gltf_writing import document_of
from kinestitch.files.naming import naming, unique_names

_FRAMES_AT_A_TIME = 1024


def read_gltf(path: str | os.PathLike[str], *, take: str | None = None) -> Motion:
    """Read the skeleton and one animation of a .glb or .gltf file.

    take : name of the animation; None takes the one that moves the most of the skeleton, the longest of several

    Joints are those of the skins, or without a skin the animated nodes and all above them. Frames run from the first
    key to the last, at the keys' own rate where they are regular (see
    :func:`kinestitch.files.gltf_animation.frame_times`). LINEAR, STEP and CUBICSPLINE keys are sampled as glTF says.
    Nodes above the skeleton, moving or not, are part of the root's motion; scale is part of the translations, so that
    joints stand where they stood. The rest pose is the bind pose where the skin has one, else the nodes' own
    transforms. Meshes and morph targets are no part of a motion. A file with a skin and no animation is one frame at
    30 fps.

    Repeated joint names get ``_2``, ``_3``, … with one counted KinestitchWarning. Raises FormatError for damaged files
    and files without joints, ParameterError for an unknown take, FileNotFoundError.
    """
    path = Path(path)
    with naming(path), np.errstate(all="ignore"):  # what overflows is refused where it matters
        document = load_document(path)
        parents = parents_of(document)
        chosen = choose_take(document, take, None) if not document.objects("skins") else None
        animated = {node for node, _ in chosen.tracks} if chosen else set()
        joints, joint_parents = choose_joints(document, parents, animated)
        moving = {node for joint in joints for node in chain(parents, joint)}
        chosen = choose_take(document, take, moving)
        times, fps = frame_times(chosen, len(joints))
        skeleton = _skeleton(document, parents, joints, joint_parents)
        translations, rotations = _frames(document, parents, joints, skeleton, chosen, times=times, fps=fps)
        several = len(document.objects("animations")) > 1
        return Motion(skeleton, translations, rotations, fps, chosen.name if chosen and several else path.stem)


def list_takes(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Names of the file's animations, in the file's order, as :func:`read_gltf` takes them. Raises FormatError."""
    with naming(path):
        document = load_document(Path(path))
        return tuple(animation_name(entry, index) for index, entry in enumerate(document.objects("animations")))


def write_gltf(motion: Motion, path: str | os.PathLike[str]) -> None:
    """Write a skeleton and its animation as .glb, or as .gltf with everything inside if the path ends so.

    Nodes stand in the rest pose and carry a skin with its bind pose; rotations, and translations where they leave the
    rest offset, are float32 keys on every frame. Reading gives the motion back to 1e-4° and 1e-6 m (near the origin;
    float32 has seven digits). Joint tips and meshes are no part of it. Raises OutputError where the file cannot be
    written.
    """
    document, pieces = document_of(motion)
    with replacing(path) as stream:
        if Path(path).suffix.lower() == ".gltf":
            data = base64.b64encode(b"".join(pieces)).decode("ascii")
            document["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
            stream.write(json.dumps(document, allow_nan=False).encode("ascii"))
        else:
            for piece in serialise_glb(document, [(BINARY_CHUNK, pieces)]):
                stream.write(piece)


def _frames(
    document: GltfDocument,
    parents: list[int],
    joints: list[int],
    skeleton: Skeleton,
    take: Take | None,
    *,
    times: Array,
    fps: float,
) -> tuple[Array, Array]:
    """Local translations (F, J, 3) m and rotations (F, J, 4), some hundred frames at a time."""
    translations = np.empty((len(times), len(joints), 3))
    rotations = np.empty((len(times), len(joints), 4))
    for start in range(0, len(times), _FRAMES_AT_A_TIME):
        frames = slice(start, start + _FRAMES_AT_A_TIME)
        places = worlds(document, parents, joints, take, times=times[frames], frame=1.0 / fps)
        poses = rigid_poses(places, joints, len(times[frames]))
        translations[frames], rotations[frames] = local_from_world(skeleton, *poses)
    translations.setflags(write=False)  # what nobody else can write to is not copied
    rotations.setflags(write=False)
    return translations, rotations


def _skeleton(document: GltfDocument, parents: list[int], joints: list[int], joint_parents: list[int]) -> Skeleton:
    nodes = document.objects("nodes")
    names, repeated = unique_names([text(nodes[joint], "name", f"node {joint}") for joint in joints])
    if repeated:
        warnings.warn(
            KinestitchWarning(f"{repeated} joint name(s) used twice; a number was added to them."), stacklevel=4
        )
    positions, rotations = rest_pose_of(document, parents, joints)
    bare = Skeleton(tuple(names), tuple(joint_parents), np.zeros((len(joints), 3)))
    offsets, rest = local_from_world(bare, positions, rotations)
    return Skeleton(bare.names, bare.parents, offsets, rest)
