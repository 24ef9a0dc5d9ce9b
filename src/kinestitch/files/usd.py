"""USD in and out: UsdSkel skeletons and their animation in .usd, .usda, .usdc and .usdz files."""

from __future__ import annotations

import os
import re
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from kinestitch.core.kinematics import local_from_world
from kinestitch.core.motion import Motion
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import FormatError, KinestitchWarning, OutputError, ParameterError
from kinestitch.files.atomic import replacing
from kinestitch.files.extras import optional
from kinestitch.files.naming import naming, unique_names
from kinestitch.files.usd_animation import frame_times, joint_worlds
from kinestitch.files.usd_rig import Rig, choose_rig, rest_worlds, stage_frame
from kinestitch.files.usd_writing import UNITS, build_stage

LIBRARIES = ("pxr.Usd", "pxr.UsdGeom", "pxr.UsdSkel", "pxr.UsdUtils")
"""What an isolated reader imports before its memory is limited."""

_TOLD = re.compile(r": '(.*?)'?\s*$", re.MULTILINE)


def read_usd(path: str | os.PathLike[str], *, take: str | None = None) -> Motion:
    """Read the skeleton and one animation of a USD file (the extra ``usd``).

    take : name of the SkelAnimation; None takes the one that the skeleton is bound to, else the one that names the most
        of its joints

    Of several skeletons the one that is animated and has the most joints is read. Frames run from the first time sample
    to the last, ``timeCodesPerSecond`` of them a second; more where samples stand between time codes, and where there
    are more than 240 codes a second, as many as there are samples. Where the file has one animation only, the stage's
    own range adds the frames before and after that stand still. Values between samples are interpolated as USD does.
    Joints that an animation leaves out keep their ``restTransforms``. Transforms above the skeleton, moving or not, are
    part of the root's motion; scale is part of the translations, so that joints stand where they stood. ``upAxis`` and
    ``metersPerUnit`` are taken into account. The rest pose is ``bindTransforms``, else ``restTransforms``. Several root
    joints get one above them, called like the skeleton.

    Joint names are ``jointNames``, else the last parts of the joints' paths; repeated ones get ``_2``, ``_3``, … with
    one counted KinestitchWarning. A skeleton without animation is one frame. Meshes, skins and blend shapes are no part
    of a motion.

    Raises FormatError for damaged files and files without joints, ParameterError for an unknown take,
    MissingExtraError without usd-core, FileNotFoundError. usd-core is native code: read files that you do not trust
    with :func:`kinestitch.files.isolated.read_isolated`.
    """
    path = Path(path)
    with _opened(path) as stage:
        rig, chosen = choose_rig(stage, take)
        times, fps = frame_times(stage, rig, chosen)
        skeleton = _skeleton(stage, rig)
        poses = joint_worlds(rig, chosen, times, stage_frame(stage))
        translations, rotations = local_from_world(skeleton, *poses)
        name = chosen.name if chosen and len(rig.takes) > 1 else path.stem
        return Motion(skeleton, translations, rotations, fps, name)


def list_takes(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Names of the SkelAnimations that fit the skeleton, as :func:`read_usd` takes them. Raises what that raises."""
    with _opened(Path(path)) as stage:
        return tuple(take.name for take in choose_rig(stage, None)[0].takes)


def has_character_usd(path: str | os.PathLike[str]) -> bool:
    """Whether the file holds a mesh. Raises FormatError, MissingExtraError."""
    with _opened(Path(path)) as stage:
        return any(prim.GetTypeName() == "Mesh" for prim in stage.Traverse())


def write_usd(motion: Motion, path: str | os.PathLike[str], *, unit: str = "m") -> None:
    """Write a skeleton and its animation: a SkelRoot with a Skeleton and a SkelAnimation, Y up.

    unit : ``"m"`` or ``"cm"``, the file's ``metersPerUnit``

    ``.usda`` is text, ``.usd`` and ``.usdc`` are binary. Joint paths are made of legal letters; ``jointNames`` keeps
    the names, so that reading gives them back. Rotations and translations are float32 on every frame: reading gives
    the motion back to 1e-4° and 1e-6 m (near the origin). Joint tips and meshes are no part of it.

    Raises OutputError where the file cannot be written, ParameterError for an unknown unit, MissingExtraError without
    usd-core.
    """
    if unit not in UNITS:
        raise ParameterError(f"Expected a unit out of {', '.join(UNITS)}, got {unit!r}.")
    suffix = Path(path).suffix.lower()
    with _quiet(), replacing(path) as stream, tempfile.TemporaryDirectory() as folder:
        stage = build_stage(motion, UNITS[unit])
        whole = Path(folder) / f"motion{suffix}"
        if not stage.GetRootLayer().Export(str(whole)):
            raise OutputError(f"Expected to write {suffix}, got a failure of the USD library. ({path})")
        stream.write(whole.read_bytes())


@contextmanager
def _quiet() -> Iterator[Any]:
    """The library's own messages go nowhere; its errors become exceptions."""
    usd_utils = optional("pxr.UsdUtils", "usd")
    delegate = usd_utils.CoalescingDiagnosticDelegate()
    try:
        yield delegate
    finally:
        delegate.TakeUncoalescedDiagnostics()
        del delegate


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The stage of a file; errors inside, the library's too, become a FormatError that ends with the path."""
    usd = optional("pxr.Usd", "usd")
    if not path.is_file():
        path.open("rb").close()
    with naming(path), _quiet(), np.errstate(all="ignore"):
        try:
            stage = usd.Stage.Open(str(path.absolute()))
            if not stage:
                raise FormatError("Expected a USD file, got something that the USD library cannot open.")
            yield stage
        except (RuntimeError, UnicodeDecodeError) as error:
            raise FormatError(f"Expected a file that the USD library can read, got: {_reason(error, path)}.") from error


def _reason(error: Exception, path: Path) -> str:
    """What the library says, in one line and without its own file names."""
    try:
        told = _TOLD.search(str(error))
    except UnicodeDecodeError:
        return "text that is no UTF-8"
    reason = told[1] if told else "an error of its own"
    return " ".join(reason.replace(f"{path.absolute()}:", "line ").split())[:160]


def _skeleton(stage: Any, rig: Rig) -> Skeleton:
    names, repeated = unique_names(list(rig.names))
    if repeated:
        warnings.warn(
            KinestitchWarning(f"{repeated} joint name(s) used twice; a number was added to them."), stacklevel=4
        )
    bare = Skeleton(tuple(names), rig.parents, np.zeros((len(names), 3)))
    offsets, rest = local_from_world(bare, *rest_worlds(rig, stage_frame(stage)))
    return Skeleton(bare.names, bare.parents, offsets, rest)
