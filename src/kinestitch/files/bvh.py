"""BVH in and out: Biovision's text files of joints, offsets and Euler angles."""

from __future__ import annotations

import math
import os
import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import EULER_ORDERS, Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import FormatError, KinestitchWarning, ParameterError, SkeletonMismatchError
from kinestitch.files.atomic import replacing
from kinestitch.files.bvh_frames import columns_of, read_frames
from kinestitch.files.bvh_hierarchy import Node, parse_hierarchy
from kinestitch.files.bvh_keeping import channels_for
from kinestitch.files.bvh_writing import hierarchy_text, in_world_axes, length_decimals, nodes_of, row_texts
from kinestitch.files.likeness import told_on
from kinestitch.files.naming import naming, unique_names
from kinestitch.files.rates import snap_rate

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "asf": 0.0254 / 0.45}
"""Metres of the units that `unit` may name; ``asf`` is that of Carnegie Mellon's files, 1/0.45 inch."""

_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_MOTION = re.compile(rb"^[ \t]*MOTION\b", re.IGNORECASE | re.MULTILINE)
_FRAMES = re.compile(rb"Frames[ \t]*:[ \t]*(\S*)[ \t]*", re.IGNORECASE)
_FRAME_TIME = re.compile(rb"Frame[ \t]+Time[ \t]*:[ \t]*(\S*)[ \t]*", re.IGNORECASE)


def read_bvh(path: str | os.PathLike[str], *, unit: str | float = "auto") -> Motion:
    """Read a BVH file.

    unit : ``"m"``, ``"cm"``, ``"mm"``, ``"inch"``, ``"asf"``, a number of metres, or ``"auto"``

    BVH names no unit. ``"auto"`` takes the largest side of the box around the rest pose, End Sites included: more than
    10 units are centimetres, fewer are metres. One family is known by name: files made from Carnegie Mellon's ASF
    skeletons (joints LHipJoint and LowerBack, 20 to 60 units) count in 1/0.45 inch = 0.0564444 m.

    The rest pose has no rotations; its offsets and End Sites (``Skeleton.tips``) are the file's, but an End Site of
    zero length says nothing and becomes NaN. Position channels, on whichever joint, stand in for the offset; any
    sequence of rotation channels is multiplied in the file's order. The rate is 1 / frame time, taken for a common one
    within 0.05 %.

    Rows after the declared number of frames are left out and repeated joint names get ``_2``, ``_3``, …, each with one
    counted KinestitchWarning. Raises FormatError, with the line number, for everything else: missing rows (a file cut
    short), a row of another length, NaN, no frames, several ROOTs; ParameterError for an unknown unit.
    """
    _metres(unit)
    data = Path(path).read_bytes()
    with naming(path):
        if b"\n" not in data:
            data = data.replace(b"\r", b"\n")
        header, position = _hierarchy_text(data)
        nodes = parse_hierarchy(header)
        frames, frame_time, position = _timing(data, position)
        metres = _scale(nodes, unit)
        skeleton = _skeleton(nodes, metres)
        translations, rotations = read_frames(
            data, position, frames, columns_of(nodes), offsets=skeleton.offsets, unit=metres
        )
        translations.setflags(write=False)  # what nobody else can write to is not copied
        rotations.setflags(write=False)
        return Motion(skeleton, translations, rotations, snap_rate(1.0 / frame_time), Path(path).stem)


def write_bvh(
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    unit: str | float = "auto",
    order: str = "ZXY",
    like: str | os.PathLike[str] | None = None,
) -> None:
    """Write a motion as BVH, so that :func:`read_bvh` gives it back to 1e-5° and 1e-6 m.

    unit : as in :func:`read_bvh`; ``"auto"`` writes centimetres, or metres for bodies so small that reading would take
        centimetres for something else
    order : sequence of the rotation channels
    like : a BVH file, read in `unit`, whose joints, their order, offsets, unit and channels the new one shall have;
        joints get more channels where those cannot tell the motion. The layout of its text is not kept.

    BVH knows no rest rotations: a motion that has some is told in joint axes that are parallel to the world's in the
    rest pose. Joints move as before; only their own frames turn by a constant. Joints other than the root get position
    channels where their translation is not the rest offset. White space and braces in names become ``_``. Joints are
    written, and so read back, depth first.

    Raises OutputError where the file cannot be written, ParameterError for an unknown unit or order; with `like`
    SkeletonMismatchError, FormatError.
    """
    if order not in EULER_ORDERS:
        raise ParameterError(f"Expected an Euler order out of {', '.join(EULER_ORDERS)}, got {order!r}.")
    told, nodes, metres = _told(motion, unit, order) if like is None else _told_like(motion, Path(like), unit)
    with replacing(path) as stream:
        stream.write(hierarchy_text(nodes, length_decimals(metres)).encode("utf-8", errors="replace"))
        stream.write(f"MOTION\nFrames: {told.frames}\nFrame Time: {1.0 / told.fps:.15g}\n".encode("ascii"))
        for text in row_texts(told, nodes, metres):
            stream.write(text.encode("ascii"))


def _told(motion: Motion, unit: str | float, order: str) -> tuple[Motion, list[Node], float]:
    """The motion as BVH can tell it, its joints in the file's unit, and that unit's metres."""
    told = in_world_axes(motion)
    metres = _metres(unit)
    nodes = nodes_of(told, metres or UNITS["cm"], order)
    if metres is None:
        metres = UNITS["cm"]
        if unit_of(nodes) != "cm":
            metres = UNITS["m"]
            nodes = nodes_of(told, metres, order)
    return told, nodes, metres


def _told_like(motion: Motion, like: Path, unit: str | float) -> tuple[Motion, list[Node], float]:
    """The same, on the joints of another file."""
    data = like.read_bytes()
    with naming(like):
        nodes = parse_hierarchy(_hierarchy_text(data if b"\n" in data else data.replace(b"\r", b"\n"))[0])
        metres = _scale(nodes, unit)
        with warnings.catch_warnings(action="ignore", category=KinestitchWarning):  # whoever read it has been told
            skeleton = _skeleton(nodes, metres)
    try:
        told = told_on(motion, skeleton)
    except SkeletonMismatchError as error:
        raise SkeletonMismatchError(f"{error} ({like})") from None
    nodes = [replace(node, name=name) for node, name in zip(nodes, skeleton.names, strict=True)]
    return told, channels_for(told, nodes), metres


def _hierarchy_text(data: bytes) -> tuple[str, int]:
    """Text of the hierarchy, and where the word MOTION behind it ends."""
    first = data[:4096].removeprefix(_BYTE_ORDER_MARK).split(maxsplit=1)
    if not first or first[0].upper() != b"HIERARCHY":
        got = repr(first[0][:24].decode("latin-1")) if first else "blank lines" if data else "an empty file"
        raise FormatError(f"Line 1: expected HIERARCHY, got {got}. Is this a BVH file?")
    match = _MOTION.search(data)
    if match is None:
        raise FormatError(
            "Expected a line MOTION after the hierarchy, got the end of the file. The file may be cut short."
        )
    head = data[: match.start()].removeprefix(_BYTE_ORDER_MARK)
    try:
        return head.decode("utf-8"), match.end()
    except UnicodeDecodeError:
        return head.decode("latin-1"), match.end()


def _timing(data: bytes, position: int) -> tuple[int, float, int]:
    """Frames, seconds a frame, and where the rows begin."""
    line, position, word = _labelled(data, position, _FRAMES, "Frames: and a number")
    if not word.isdigit() or len(word) > 12:
        raise FormatError(f"Line {line}: expected a number of frames, got {word[:24].decode('latin-1')!r}.")
    frames = int(word)
    if frames < 1:
        raise FormatError(f"Line {line}: expected at least one frame, got {frames}. Export it again.")
    line, position, word = _labelled(data, position, _FRAME_TIME, "Frame Time: and a number")
    try:
        seconds = float(word)
    except ValueError:
        seconds = math.nan
    if not 1e-6 <= seconds <= 1e6:
        raise FormatError(f"Line {line}: expected a frame time > 0 in seconds, got {word[:24].decode('latin-1')!r}.")
    return frames, seconds, position


def _labelled(data: bytes, position: int, pattern: re.Pattern[bytes], expected: str) -> tuple[int, int, bytes]:
    """Line number, end and value of the labelled line that has to come next."""
    while data[position : position + 1].isspace():
        position += 1
    line = data.count(b"\n", 0, position) + 1
    match = pattern.match(data, position)
    if match is None:
        got = data[position : position + 40].split(b"\n")[0].decode("latin-1").strip()
        raise FormatError(f"Line {line}: expected {expected}, got {got!r}.")
    return line, match.end(), match[1]


def _metres(unit: str | float) -> float | None:
    """Metres of a unit; None for "auto"."""
    if isinstance(unit, str):
        if unit != "auto" and unit not in UNITS:
            raise ParameterError(
                f"Expected a unit out of auto, {', '.join(UNITS)} or a number of metres, got {unit!r}."
            )
        return UNITS.get(unit)
    if not (math.isfinite(unit) and unit > 0):
        raise ParameterError(f"Expected a unit > 0 m, got {unit}.")
    return float(unit)


def _scale(nodes: list[Node], unit: str | float) -> float:
    metres = _metres(unit)
    return UNITS[unit_of(nodes)] if metres is None else metres


def unit_of(nodes: list[Node]) -> str:
    """The unit that ``"auto"`` takes: see :func:`read_bvh`."""
    places: list[Array] = []
    ends: list[Array] = []
    for node in nodes:
        above = places[node.parent] if node.parent >= 0 else np.zeros(3)
        places.append(above + np.asarray(node.offset))
        ends.append(places[-1] + np.asarray(node.tip or (0.0, 0.0, 0.0)))
    extent = float(np.ptp(np.array(places + ends), axis=0).max())
    if 20 <= extent <= 60 and {"lhipjoint", "lowerback"} <= {node.name.lower() for node in nodes}:
        return "asf"
    return "cm" if extent > 10 else "m"


def _skeleton(nodes: list[Node], metres: float) -> Skeleton:
    names, repeated = unique_names([node.name for node in nodes])
    if repeated:
        warnings.warn(
            KinestitchWarning(f"{repeated} joint name(s) used twice; a number was added to them."), stacklevel=4
        )
    tips = [(math.nan,) * 3 if node.tip is None or not any(node.tip) else node.tip for node in nodes]
    return Skeleton(
        tuple(names),
        tuple(node.parent for node in nodes),
        np.array([node.offset for node in nodes]) * metres,
        tips=np.array(tips) * metres,
    )
