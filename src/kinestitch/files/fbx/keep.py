"""A file with its character, and another motion in it: only the curves of one take are touched."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.errors import FormatError, KinestitchWarning, ParameterError, SkeletonMismatchError
from kinestitch.files.fbx.animation import read_takes
from kinestitch.files.fbx.binary import is_binary, parse_binary
from kinestitch.files.fbx.bones import choose_joints
from kinestitch.files.fbx.build import ticks_of
from kinestitch.files.fbx.frames import frame_ticks
from kinestitch.files.fbx.graft import Graft
from kinestitch.files.fbx.nodes import Document, Node
from kinestitch.files.fbx.pose import needed_models
from kinestitch.files.fbx.read import choose_take, skeleton_of
from kinestitch.files.fbx.retake import sheet_of, stretch, tell
from kinestitch.files.fbx.scene import Scene
from kinestitch.files.fbx.unpose import said_by
from kinestitch.files.likeness import told_on
from kinestitch.files.naming import naming

_TEXT_MESH = re.compile(rb"^[ \t]*(?:Vertices|Shape)[ \t]*:", re.MULTILINE)


def kept_document(motion: Motion, like: Path, take: str | None) -> Document:
    """The document of the file `like` with the motion in its take; errors end with the file's name."""
    try:
        with naming(like), np.errstate(all="ignore"):
            return retold(_keepable(like), motion, take)
    except (ParameterError, SkeletonMismatchError) as error:
        raise type(error)(f"{error} ({like})") from None


def retold(document: Document, motion: Motion, wanted: str | None = None) -> Document:
    """The document with another motion in one of its takes, by default the one that the reader chooses.

    wanted : name of that take; a file without any gets a new one of that name
    """
    scene = Scene(document)
    takes = read_takes(scene)
    take = choose_take(takes, wanted) if takes else None
    title = wanted or motion.name or "Take 001"
    joints = choose_joints(scene, take)
    start = int(frame_ticks(take, needed_models(scene, joints), scene.fps)[0][0])
    told = told_on(motion, skeleton_of(scene, joints))
    said = said_by(scene, joints, take, start, told)
    ticks = start + ticks_of(motion.frames, motion.fps)
    graft = Graft(scene)
    sheet = sheet_of(graft, take, takes, title)
    tell(graft, sheet, take, said, ticks)
    stretch(graft, sheet, take, ticks, motion.fps, title)
    made = graft.document()
    if take is not None and sum(other.key_count() > 0 for other in takes) > 1:
        _warn_of_takes(made, take.name)
    return made


def _warn_of_takes(document: Document, written: str) -> None:
    chosen = choose_take(read_takes(Scene(document)))
    if chosen is not None and chosen.name != written:
        message = f"The motion is take {written!r}; reading takes {chosen.name!r}, which has more keys, unless asked."
        warnings.warn(KinestitchWarning(message), stacklevel=5)


def _keepable(like: Path) -> Document:
    data = like.read_bytes()
    document = parse_binary(data) if is_binary(data) else None
    if document is None or document.version < 7000 or document.order == ">":
        kind = "a text file" if document is None else "an older one"
        kind = "a big-endian one" if document is not None and document.order == ">" else kind
        raise FormatError(
            f"Expected a binary FBX 7 file to keep the character of, got {kind}. "
            "Export it again as binary FBX 7, from Blender for one."
        )
    return document


def has_character_fbx(path: Path) -> bool:
    """Whether the file holds a mesh. Raises FormatError for damaged binary files."""
    data = Path(path).read_bytes()
    if not is_binary(data):
        return _TEXT_MESH.search(data) is not None
    with naming(path):
        document = parse_binary(data)
    home = document.child("Objects")
    return any(map(_is_mesh, home.children if home is not None else document.nodes))


def _is_mesh(entry: Node) -> bool:
    return entry.name in {"Geometry", "Model"} and entry.child("Vertices") is not None
