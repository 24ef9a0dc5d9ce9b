"""AMASS in and out: the .npz files of poses of the SMPL body models."""

from __future__ import annotations

import math
import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from kinestitch.core.kinematics import local_from_world, rest_pose, with_joint_axes
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_about_axis,
    quat_identity,
    quat_multiply,
    quat_rotate,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import FormatError, ParameterError, SkeletonMismatchError
from kinestitch.files.atomic import replacing
from kinestitch.files.naming import naming
from kinestitch.files.rates import snap_rate
from kinestitch.files.smpl import LAYOUTS, Layout, skeleton_of

_RATES = ("mocap_framerate", "mocap_frame_rate", "fps")
_PARTS = ("root_orient", "pose_body", "pose_jaw", "pose_eye", "pose_hand")
_LIMIT = 1e6
_PLAUSIBLE = 64 << 20
_MOST_TIMES_LARGER = 50
_LIMBS = ("elbow", "wrist", "knee", "ankle")


def read_amass(path: str | os.PathLike[str], *, up: str = "z", fps: float | None = None) -> Motion:
    """Read an AMASS file: poses of SMPL, SMPL-H or SMPL-X as rotation vectors, and a path.

    up : axis of the file that points up, ``"z"`` as in AMASS, or ``"y"``
    fps : frames a second; None takes the file's ``mocap_framerate``, ``mocap_frame_rate`` or ``fps``

    The length of a pose tells the model: 66 numbers are 22 joints of the body, 72 SMPL's 24, 156 SMPL-H's 52, 165
    SMPL-X's 55; instead of ``poses`` there may be ``root_orient``, ``pose_body`` and so on. Joints have the models' own
    names (``pelvis``, ``left_hip``, …).

    Such files say nothing of where a body's joints are. The skeleton is a mean adult body; ``betas`` and ``gender`` are
    ignored (see :mod:`kinestitch.files.smpl`), so that limbs may be some centimetres off and feet may float or sink a
    little. A file that holds rest positions as ``J`` or ``joints`` (J, 3) m has its own body.

    Nothing in the file is run: pickled arrays are refused. Raises FormatError for damaged files and other arrays,
    ParameterError for a wrong `up` or rate.
    """
    if up not in ("y", "z"):
        raise ParameterError(f"Expected up to be 'y' or 'z', got {up!r}.")
    if fps is not None and not (math.isfinite(fps) and fps > 0):
        raise ParameterError(f"Expected fps > 0, got {fps}.")
    path = Path(path)
    with naming(path), np.errstate(all="ignore"):
        arrays = _load(path)
        poses = _poses(arrays)
        trans = _floats(arrays, "trans", (len(poses), 3))
        layout = next((entry for entry in LAYOUTS if 3 * len(entry.names) == poses.shape[1]), None)
        if layout is None:
            known = ", ".join(str(3 * len(entry.names)) for entry in LAYOUTS)
            raise FormatError(f"Expected poses of {known} numbers a frame, got {poses.shape[1]}.")
        skeleton, pelvis = skeleton_of(layout, _own_joints(arrays, len(layout.names)))
        rotations = rotvec_to_quat(poses.reshape(len(poses), -1, 3))
        translations = np.tile(skeleton.offsets, (len(poses), 1, 1))
        translations[:, 0] = trans + pelvis
        if up == "z":
            lay = quat_about_axis(0, -math.pi / 2)
            translations[:, 0] = quat_rotate(lay, translations[:, 0])
            rotations[:, 0] = quat_multiply(lay, rotations[:, 0])
        return Motion(skeleton, translations, rotations, fps or _rate(arrays), path.stem)


def write_amass(motion: Motion, path: str | os.PathLike[str]) -> None:
    """Write a motion of a SMPL skeleton as an AMASS file, Z up.

    The joints have to be SMPL's, SMPL-H's or SMPL-X's by their exact names and parents, in a T-pose at rest; the 22
    joints of the body alone are written as SMPL-H with straight fingers. Rest positions are added as ``J``, so that
    :func:`read_amass` gives back the same body; other programs take the shape from ``betas``, which are zero, the mean
    body. Of translations only the root's are kept. Reading gives rotations and the root's path back to 1e-9.

    Raises SkeletonMismatchError for other skeletons, OutputError where the file cannot be written.
    """
    layout = _layout(motion.skeleton)
    told = with_joint_axes(motion, quat_identity())
    places, _ = rest_pose(told.skeleton)
    order = [told.skeleton.names.index(name) if name in told.skeleton.names else -1 for name in layout.names]
    stand = quat_about_axis(0, math.pi / 2)
    rotations = told.rotations.copy()
    rotations[:, 0] = quat_multiply(stand, rotations[:, 0])
    poses = np.zeros((told.frames, len(layout.names), 3))
    present = [index for index, joint in enumerate(order) if joint >= 0]
    poses[:, present] = quat_to_rotvec(rotations[:, [order[index] for index in present]])
    _, mean_pelvis = skeleton_of(layout)
    arrays: dict[str, Any] = {
        "poses": poses.reshape(told.frames, -1),
        "trans": quat_rotate(stand, told.translations[:, 0]) - mean_pelvis,
        "mocap_framerate": np.float64(told.fps),
        "mocap_frame_rate": np.float64(told.fps),
        "gender": np.array("neutral"),
        "betas": np.zeros(16),
        "dmpls": np.zeros((told.frames, 8)),
    }
    if len(present) == len(order):
        arrays["J"] = places[order] - places[order[0]] + mean_pelvis
    with replacing(path) as stream:
        np.savez_compressed(stream, **arrays)


def _load(path: Path) -> dict[str, Any]:
    """The arrays of the file that matter; numpy and zipfile answer damaged files with a dozen kinds of errors."""
    wanted = {"poses", "trans", "J", "joints", *_RATES, *_PARTS}
    size = path.stat().st_size
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
                members = {info.filename.removesuffix(".npy"): info.file_size for info in archive.zip.infolist()}
                total = sum(members.get(key, 0) for key in wanted)
                if total > max(_PLAUSIBLE, _MOST_TIMES_LARGER * size):
                    raise FormatError(f"Expected arrays that fit a file of {size} bytes, got {total} bytes of them.")
                return {key: archive[key] for key in wanted if key in members}
    except (FormatError, FileNotFoundError, IsADirectoryError, PermissionError):
        raise
    except Exception as error:
        reason = str(error).split("\n")[0][:120] or type(error).__name__
        raise FormatError(f"Expected a .npz file of plain arrays, got: {reason}. It may be damaged.") from error


def _floats(arrays: dict[str, Any], key: str, shape: tuple[int | None, ...]) -> Array:
    """An array as float64, checked; None in the shape takes any length."""
    if key not in arrays:
        raise FormatError(f"Expected an array {key!r}, got none. Is this an AMASS file?")
    array = np.asarray(arrays[key])
    fits = array.ndim == len(shape) and all(want in (None, n) for want, n in zip(shape, array.shape, strict=True))
    if not fits or array.dtype.kind not in "fiu":
        want = ", ".join("n" if n is None else str(n) for n in shape)
        raise FormatError(f"Expected numbers of shape ({want}) in {key!r}, got {array.dtype} {array.shape}.")
    values = array.astype(np.float64)
    if not (np.abs(values) < _LIMIT).all():
        raise FormatError(f"Expected finite numbers below {_LIMIT:g} in {key!r}, got others.")
    return np.asarray(values)


def _poses(arrays: dict[str, Any]) -> Array:
    """Rotation vectors (F, 3J), put together from their parts where the file has them apart."""
    if "poses" in arrays or "root_orient" not in arrays:
        poses = _floats(arrays, "poses", (None, None))
    else:
        parts = [_floats(arrays, key, (None, None)) for key in _PARTS if key in arrays]
        if len({len(part) for part in parts}) > 1:
            raise FormatError(f"Expected as many frames in every part of the pose, got {[len(p) for p in parts]}.")
        poses = np.concatenate(parts, axis=1)
    if not len(poses):
        raise FormatError("Expected at least one frame, got none.")
    return poses


def _own_joints(arrays: dict[str, Any], count: int) -> Array | None:
    for key in ("J", "joints"):
        if key in arrays and np.ndim(arrays[key]) == 2 and len(arrays[key]) >= count:
            return _floats(arrays, key, (None, 3))[:count]
    return None


def _rate(arrays: dict[str, Any]) -> float:
    for key in _RATES:
        if key in arrays:
            value = np.asarray(arrays[key]).reshape(-1)
            rate = float(value[0]) if value.size == 1 and value.dtype.kind in "fiu" else math.nan
            if not (math.isfinite(rate) and rate > 0):
                got = f"{value.item()!r:.24}" if value.size == 1 else f"{value.size} values"
                raise FormatError(f"Expected a frame rate > 0 in {key!r}, got {got}.")
            return snap_rate(rate)
    raise FormatError(f"Expected a frame rate in {' or '.join(_RATES)}, got none. Pass fps=.")


def _layout(skeleton: Skeleton) -> Layout:
    """The model whose joints these are; raises SkeletonMismatchError."""
    names = set(skeleton.names)
    layout = next((entry for entry in LAYOUTS if set(entry.names) == names), None)
    if layout is None:
        nearest = min(LAYOUTS, key=lambda entry: len(set(entry.names) ^ names))
        missing = sorted(set(nearest.names) - names)
        odd, verb = (missing, "without") if missing else (sorted(names - set(nearest.names)), "with")
        raise SkeletonMismatchError(
            f"Expected the joints of {', '.join(entry.name for entry in LAYOUTS[:3])} by name, got a skeleton {verb} "
            f"{', '.join(odd[:4])}. Retarget it to SMPL first."
        )
    above = [skeleton.names[parent] if parent >= 0 else "" for parent in skeleton.parents]
    tree = zip(layout.names, layout.parents, strict=True)
    wanted = {name: layout.names[parent] if parent >= 0 else "" for name, parent in tree}
    for name, parent in zip(skeleton.names, above, strict=True):
        if wanted[name] != parent:
            raise SkeletonMismatchError(f"Expected {name!r} below {wanted[name]!r}, got it below {parent!r}.")
    _check_rest(skeleton, layout)
    return LAYOUTS[1] if layout.name == "SMPL body" else layout


def _check_rest(skeleton: Skeleton, layout: Layout) -> None:
    """SMPL's angles count from the T-pose: arms out to the sides, legs straight, facing +Z."""
    places, _ = rest_pose(skeleton)
    offsets, _ = local_from_world(skeleton, places, np.broadcast_to(quat_identity(), (len(places), 4)))
    mean = layout.offsets
    for side in ("left_", "right_"):
        for limb in _LIMBS:
            ours, theirs = offsets[skeleton.index(side + limb)], mean[layout.names.index(side + limb)]
            size = np.linalg.norm(ours) * np.linalg.norm(theirs)
            angle = math.degrees(math.acos(np.clip(ours @ theirs / size, -1, 1))) if size > 0 else 0.0
            if angle > 30:
                raise SkeletonMismatchError(
                    f"Expected a rest pose like SMPL's (a T facing +Z), got {side}{limb} {angle:.0f}° off. "
                    "Retarget it to SMPL first."
                )
