"""ASF/AMC in: Acclaim's pairs of a skeleton file and a motion file, as Carnegie Mellon publishes them."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_normalize, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import FormatError, KinestitchWarning, ParameterError
from kinestitch.files.asf import Asf, numbers, parse_asf, turned
from kinestitch.files.naming import naming

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
"""Metres of the units that `unit` may name."""

CMU_RATE = 120.0
"""Frames a second of Carnegie Mellon's recordings."""


def read_amc(
    path: str | os.PathLike[str],
    *,
    skeleton: str | os.PathLike[str] | None = None,
    fps: float | None = None,
    unit: str | float = "auto",
) -> Motion:
    """Read an AMC file and the ASF file that belongs to it.

    skeleton : the ASF file; None takes the one beside the AMC file with its name, with its name up to the first ``_``
        (``01.asf`` for ``01_01.amc``), or the only one in the folder
    fps : frames a second; None takes the file's ``:samples-per-second``, else 120, the rate of Carnegie Mellon's files
    unit : ``"m"``, ``"cm"``, ``"mm"``, ``"inch"``, a number of metres, or ``"auto"``

    ``"auto"`` reads ``length`` of the ASF file's ``:units`` as CMU means it: lengths are in 1/length inch, 0.45 gives
    0.0564 m. A length of 1, or none, names no unit: then skeletons larger than 10 units are in centimetres, smaller
    ones in metres.

    Joints are the root and the bones, depth first; each sits where its bone starts, and ``Skeleton.tips`` holds the
    ends of the last ones. Joint axes are parallel to the world's in the rest pose, which is the ASF file's own (all
    angles zero). Angles are about fixed axes, in the order of the channels, in the frame that ``axis`` gives. The
    root's ``orientation`` is part of the rest pose and turns all that the AMC file says, positions too.

    Bones of which the AMC file says nothing keep their rest pose. Raises FormatError with the line number for damaged
    files, for bones that miss in some frames, that change length or move (channels ``l``, ``tx``, ``ty``, ``tz``), and
    where no skeleton is found; ParameterError for a rate ≤ 0 or an unknown unit.
    """
    path = Path(path)
    if fps is not None and not (math.isfinite(fps) and fps > 0):
        raise ParameterError(f"Expected fps > 0, got {fps}.")
    scale = _metres(unit)
    with naming(path):
        lines = _text(path).splitlines()
        where = find_skeleton(path) if skeleton is None else Path(skeleton)
    with naming(where):
        asf = parse_asf(_text(where))
    with naming(path):
        if asf.unused:
            message = f"{asf.unused} bone(s) of {where.name} are not in its hierarchy and were left out."
            warnings.warn(KinestitchWarning(message), stacklevel=3)
        metres = _auto_unit(asf) if scale is None else scale
        frames = _frames(lines, asf)
        rig = _skeleton(asf, metres)
        with np.errstate(all="ignore"):
            translations, rotations = _poses(frames, asf, rig, metres)
        return Motion(rig, translations, rotations, fps or frames.rate or CMU_RATE, path.stem)


def find_skeleton(path: Path) -> Path:
    """The ASF file beside an AMC file; raises FormatError where there is none, or several that could be meant."""
    beside = {entry.name.lower(): entry for entry in sorted(path.parent.iterdir()) if entry.suffix.lower() == ".asf"}
    for name in (path.stem, path.stem.split("_", 1)[0]):
        if found := beside.get(f"{name.lower()}.asf"):
            return found
    if len(beside) == 1:
        return next(iter(beside.values()))
    raise FormatError(
        f"Expected an .asf file named like the .amc file beside it, got {len(beside) or 'no'} .asf files. "
        "Pass skeleton= with the path of the right one."
    )


def _text(path: Path) -> str:
    return path.read_bytes().removeprefix(b"\xef\xbb\xbf").decode("latin-1")


def _metres(unit: str | float) -> float | None:
    if isinstance(unit, str):
        if unit != "auto" and unit not in UNITS:
            raise ParameterError(f"Expected a unit out of auto, {', '.join(UNITS)} or a number, got {unit!r}.")
        return UNITS.get(unit)
    if not (math.isfinite(unit) and unit > 0):
        raise ParameterError(f"Expected a unit > 0 m, got {unit}.")
    return float(unit)


def _auto_unit(asf: Asf) -> float:
    if math.isfinite(asf.length) and asf.length != 1.0:
        return UNITS["inch"] / asf.length
    ends = np.zeros((len(asf.bones), 3))
    for index, bone in enumerate(asf.bones[1:], start=1):
        ends[index] = ends[asf.parents[index]] + bone.vector
    return UNITS["cm"] if np.ptp(ends, axis=0).max() > 10 else UNITS["m"]


@dataclass(slots=True)
class _Frames:
    """What the AMC file says: for each bone by name one row of values for each frame."""

    rows: dict[str, list[tuple[float, ...]]]
    count: int = 0
    rate: float = 0.0
    radians: float | None = None
    pending: set[str] = field(default_factory=set)


def _frames(lines: list[str], asf: Asf) -> _Frames:
    widths = {bone.name: len(bone.channels) for bone in asf.bones}
    frames = _Frames({name: [] for name in widths})
    number = 0
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            _header(frames, number, words)
        elif len(words) == 1 and words[0].isdigit():
            _next_frame(frames, number)
        elif not frames.count:
            raise FormatError(
                f"Line {number}: expected a frame number, got {line.strip()[:40]!r}. Is this an AMC file?"
            )
        else:
            _values(frames, number, words, widths)
    if not frames.count:
        raise FormatError(f"Line {number}: expected at least one frame, got the end of the file.")
    _next_frame(frames, number)
    frames.count -= 1
    return frames


def _header(frames: _Frames, line: int, words: list[str]) -> None:
    keyword = words[0].lower()
    if keyword in (":degrees", ":radians"):
        frames.radians = math.radians(1.0) if keyword == ":degrees" else 1.0
    elif keyword == ":samples-per-second":
        (frames.rate,) = numbers(line, words[1:], 1, keyword)
        if frames.rate <= 0:
            raise FormatError(f"Line {line}: expected a rate > 0, got {words[1]}.")


def _next_frame(frames: _Frames, line: int) -> None:
    """End a frame: bones that were there in the first one have to be there in every one."""
    if frames.count == 1:
        frames.rows = {name: rows for name, rows in frames.rows.items() if rows}
        if not frames.rows:
            raise FormatError(f"Line {line}: expected values of bones in frame 1, got none.")
    elif frames.count:
        late = next((name for name, rows in frames.rows.items() if len(rows) != frames.count), None)
        if late is not None:
            raise FormatError(
                f"Line {line}: expected values of {late!r} before the end of frame {frames.count}, got none. "
                "The file may be cut short."
            )
    frames.count += 1


def _values(frames: _Frames, line: int, words: list[str], widths: dict[str, int]) -> None:
    name, width = words[0], widths.get(words[0])
    if width is None:
        raise FormatError(
            f"Line {line}: expected a bone of the skeleton, got {name[:40]!r}. Is this the right .asf file?"
        )
    if len(words) - 1 != width:
        raise FormatError(f"Line {line}: expected {width} value(s) for {name!r}, got {len(words) - 1}.")
    rows = frames.rows.get(name)
    if rows is None or len(rows) != frames.count - 1:
        raise FormatError(f"Line {line}: expected {name!r} once in every frame, got it in some only, or twice.")
    rows.append(numbers(line, words[1:], width, name))


def _skeleton(asf: Asf, metres: float) -> Skeleton:
    offsets = np.zeros((len(asf.bones), 3))
    tips = np.full((len(asf.bones), 3), math.nan)
    for index, bone in enumerate(asf.bones):
        parent = asf.parents[index]
        offsets[index] = asf.bones[parent].vector if index else asf.position
        if index and index not in asf.parents and bone.length:
            tips[index] = bone.vector
    rest = np.tile([0.0, 0.0, 0.0, 1.0], (len(asf.bones), 1))
    rest[0] = asf.bones[0].axes
    names = tuple(bone.name for bone in asf.bones)
    return Skeleton(names, tuple(asf.parents), offsets * metres, rest, tips * metres)


def _poses(frames: _Frames, asf: Asf, rig: Skeleton, metres: float) -> tuple[Array, Array]:
    """Local translations (F, J, 3) m and rotations (F, J, 4)."""
    radians = asf.radians if frames.radians is None else frames.radians
    translations = np.tile(rig.offsets, (frames.count, 1, 1))
    rotations = np.tile(rig.rest, (frames.count, 1, 1))
    for index, bone in enumerate(asf.bones):
        if bone.name not in frames.rows:
            continue
        values = np.array(frames.rows[bone.name])
        turns = [column for column, channel in enumerate(bone.channels) if channel.startswith("r")]
        others = [(column, channel) for column, channel in enumerate(bone.channels) if not channel.startswith("r")]
        if others and (index or any(channel == "l" for _, channel in others)):
            raise FormatError(
                f"Expected rotations only on {bone.name!r}, got {others[0][1]!r}. Bones that stretch are not read."
            )
        turn = turned(values[:, turns] * radians, "".join(bone.channels[column][1] for column in turns))
        if index:
            turn = quat_multiply(quat_multiply(bone.axes, turn), quat_conjugate(bone.axes))
        else:
            turn = quat_multiply(bone.axes, turn)
            place = np.zeros((frames.count, 3))
            for column, channel in others:
                place[:, "xyz".index(channel[1])] = values[:, column]
            translations[:, 0] = rig.offsets[0] + quat_rotate(bone.axes, place) * metres
        rotations[:, index] = quat_normalize(turn)
    return translations, rotations
