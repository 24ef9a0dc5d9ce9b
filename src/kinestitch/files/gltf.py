"""glTF in and out: the skeleton and animation of .glb and .gltf files."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinestitch.core.kinematics import local_from_world
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.files.atomic import replacing
from kinestitch.files.glb import BINARY_CHUNK, json_bytes, serialise_glb
from kinestitch.files.gltf_animation import animation_name
from kinestitch.files.gltf_document import load_document
from kinestitch.files.gltf_enclosing import data_uri
from kinestitch.files.gltf_figure import Figure, open_figure
from kinestitch.files.gltf_keeping import kept_file
from kinestitch.files.gltf_scene import rigid_poses, worlds
from kinestitch.files.gltf_writing import document_of
from kinestitch.files.naming import naming

_FRAMES_AT_A_TIME = 1024


def read_gltf(path: str | os.PathLike[str], *, take: str | None = None) -> Motion:
    """Read the skeleton and one animation of a .glb or .gltf file.

    take : name of the animation; None takes the one that kinestitch wrote last into a file of several, else the one
        that moves the most of the skeleton, the longest of several

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
        figure = open_figure(document, take)
        translations, rotations = _frames(figure)
        several = len(document.objects("animations")) > 1
        name = figure.take.name if figure.take and several else path.stem
        return Motion(figure.skeleton, translations, rotations, figure.fps, name)


def list_takes(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Names of the file's animations, in the file's order, as :func:`read_gltf` takes them. Raises FormatError."""
    with naming(path):
        document = load_document(Path(path))
        return tuple(animation_name(entry, index) for index, entry in enumerate(document.objects("animations")))


def write_gltf(
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    like: str | os.PathLike[str] | None = None,
    take: str | None = None,
) -> None:
    """Write a skeleton and its animation as .glb, or as .gltf with everything inside if the path ends so.

    Nodes stand in the rest pose and carry a skin with its bind pose; rotations, and translations where they leave the
    rest offset, are float32 keys on every frame. Reading gives the motion back to 1e-4° and 1e-6 m (near the origin;
    float32 has seven digits). Joint tips and meshes are no part of it.

    like : a glTF file to write the motion into: see :func:`kinestitch.files.write` and
        :mod:`kinestitch.files.gltf_keeping`
    take : the animation of `like` that is replaced; None takes the one of the motion's name, else the one that
        :func:`read_gltf` takes

    Raises OutputError where the file cannot be written; with `like` SkeletonMismatchError, FormatError, ParameterError
    for an unknown take.
    """
    if like is not None:
        parts = kept_file(motion, Path(path), Path(like), take)
        with naming(like), replacing(path) as stream:
            for piece in parts:
                stream.write(piece)
        return
    if take is not None:
        motion = replace(motion, name=take)
    document, pieces = document_of(motion)
    with replacing(path) as stream:
        if Path(path).suffix.lower() == ".gltf":
            document["buffers"][0]["uri"] = data_uri(b"".join(pieces))
            stream.write(json_bytes(document))
        else:
            for piece in serialise_glb(document, [(BINARY_CHUNK, pieces)]):
                stream.write(piece)


def has_character_gltf(path: str | os.PathLike[str]) -> bool:
    """Whether any node of the file carries a mesh; raises FormatError."""
    with naming(path):
        return any("mesh" in node for node in load_document(Path(path)).objects("nodes"))


def _frames(figure: Figure) -> tuple[Array, Array]:
    """Local translations (F, J, 3) m and rotations (F, J, 4), some hundred frames at a time."""
    joints, times = figure.joints, figure.times
    translations = np.empty((len(times), len(joints), 3))
    rotations = np.empty((len(times), len(joints), 4))
    for start in range(0, len(times), _FRAMES_AT_A_TIME):
        frames = slice(start, start + _FRAMES_AT_A_TIME)
        places = worlds(
            figure.document, figure.parents, joints, figure.take, times=times[frames], frame=1.0 / figure.fps
        )
        poses = rigid_poses(places, joints, len(times[frames]))
        translations[frames], rotations[frames] = local_from_world(figure.skeleton, *poses)
    translations.setflags(write=False)  # what nobody else can write to is not copied
    rotations.setflags(write=False)
    return translations, rotations
