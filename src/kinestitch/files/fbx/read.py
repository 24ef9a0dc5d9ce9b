"""From an FBX file to a motion."""

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_normalize
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import KinestitchWarning, ParameterError
from kinestitch.files.fbx.animation import Take, read_takes
from kinestitch.files.fbx.ascii import parse_ascii
from kinestitch.files.fbx.axes import to_y_up_metres
from kinestitch.files.fbx.binary import is_binary, parse_binary
from kinestitch.files.fbx.bones import SCENE, bind_matrices, choose_joints
from kinestitch.files.fbx.frames import frame_ticks
from kinestitch.files.fbx.legacy import read_old_takes
from kinestitch.files.fbx.nodes import Document
from kinestitch.files.fbx.pose import bare_skeleton, bind_poses, joint_name, local_poses, needed_models
from kinestitch.files.fbx.scene import Key, Scene
from kinestitch.files.naming import naming


def read_document(path: str | os.PathLike[str]) -> Document:
    """The node tree of a file, binary or text; raises FormatError without the path."""
    data = Path(path).read_bytes()
    return parse_binary(data) if is_binary(data) else parse_ascii(data)


def list_takes(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Names of the takes (animation stacks) in a file, in its own order.

    Raises FormatError for damaged files, FileNotFoundError.
    """
    with naming(path), np.errstate(all="ignore"):
        return tuple(take.name for take in takes_of(Scene(read_document(path))))


def read_fbx(path: str | os.PathLike[str], *, take: str | None = None) -> Motion:
    """Read the skeleton and one take of an FBX file: metres, Y up, at the file's own frame rate.

    take : name of the animation stack. None takes ``mixamo.com`` if there is one, else the stack with the most keys.

    Joints are bones; where a file has none, its animated objects and their ancestors. Frames run from the first to
    the last key. The rest pose is the bind pose where the file has one, else each bone's default transform. Scale has
    no place in a motion: joints stand where the scaled ones stood. Raises FormatError for damaged files and files
    without joints, ParameterError for an unknown take, FileNotFoundError.
    """
    try:
        with naming(path), np.errstate(all="ignore"):
            return _read(Path(path), take)
    except ParameterError as error:
        raise ParameterError(f"{error} ({path})") from None


def _read(path: Path, wanted: str | None) -> Motion:
    scene = Scene(read_document(path))
    take = choose_take(takes_of(scene), wanted)
    joints = choose_joints(scene, take)
    ticks, fps = frame_ticks(take, needed_models(scene, joints), scene.fps)
    skeleton = skeleton_of(scene, joints)
    _warn_of_names(scene, joints, skeleton)
    translations, rotations = _upright(scene, *local_poses(scene, joints, take, ticks))
    return Motion(skeleton, translations, quat_normalize(rotations), fps, path.stem)


def skeleton_of(scene: Scene, joints: tuple[Key, ...]) -> Skeleton:
    """The joints with their rest pose, metres and Y up."""
    bare = bare_skeleton(scene, joints)
    offsets, rest = _upright(scene, *_rest(scene, joints, bare.parents))
    return replace(bare, offsets=offsets[0], rest=quat_normalize(rest[0]))


def takes_of(scene: Scene) -> tuple[Take, ...]:
    """All takes of a scene, whatever the file's version."""
    return read_takes(scene) or read_old_takes(scene)


def choose_take(takes: tuple[Take, ...], wanted: str | None = None) -> Take | None:
    """The take called `wanted`; by default ``mixamo.com`` if it moves, else the one with the most keys, None of none.

    Raises ParameterError with the names there are.
    """
    if wanted is not None:
        for take in takes:
            if take.name == wanted:
                return take
        names = ", ".join(repr(take.name) for take in takes) or "none"
        raise ParameterError(f"Expected a take out of {names}, got {wanted!r}.")
    keys = [take.key_count() for take in takes]
    best = max(range(len(takes)), key=lambda i: (takes[i].name == "mixamo.com" and keys[i] > 0, keys[i]), default=None)
    return None if best is None else takes[best]


def _upright(scene: Scene, translations: Array, rotations: Array) -> tuple[Array, Array]:
    return to_y_up_metres(translations, rotations, scene.axes, scene.metres_per_unit)


def _rest(scene: Scene, joints: tuple[Key, ...], parents: tuple[int, ...]) -> tuple[Array, Array]:
    moved, turned = local_poses(scene, joints, None, np.zeros(1, dtype=np.int64))
    matrices = bind_matrices(scene)
    covered = sum(joint in matrices for joint in joints)
    if SCENE in joints:
        matrices = {**matrices, SCENE: np.eye(4)} if matrices else {}
    if joints[0] in matrices and 2 * covered >= len(joints):
        offsets, rest = bind_poses(joints, parents, matrices, (moved[0], turned[0]))
        return offsets[None], rest[None]
    return moved, turned


def _warn_of_names(scene: Scene, joints: tuple[Key, ...], bare: Skeleton) -> None:
    changed = sum(joint_name(scene, key) != name for key, name in zip(joints, bare.names, strict=True))
    if changed:
        message = f"{changed} joint names stood more than once and were numbered."
        warnings.warn(KinestitchWarning(message), stacklevel=4)
