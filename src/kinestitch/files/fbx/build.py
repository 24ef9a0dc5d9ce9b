"""Parts of a new FBX document: nodes from plain values, property lists, and everything around the objects."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.files.fbx.binary import CREATION_TIME, FILE_ID
from kinestitch.files.fbx.curves import TICKS
from kinestitch.files.fbx.nodes import Node, PackedArray, Property
from kinestitch.files.fbx.scene import CUSTOM_TIME_MODE, TIME_MODES

VERSION = 7400
CREATOR = "kinestitch"
Y_UP = (("Up", 1, 1), ("Front", 2, 1), ("Coord", 0, 1), ("OriginalUp", 1, 1))
_LINEAR = 0x4 | 0x100 | 0x2000 | 0x4000
_THIRDS = struct.unpack("<f", struct.pack("<I", 0x0D050D05))[0]  # both tangent weights 0.3333, packed


def node(name: str, codes: str = "", *values: Property, children: Iterable[Node] = ()) -> Node:
    """A node; `codes` has one type letter per value."""
    inner = tuple(children)
    return Node(name, values, codes, inner, terminated=bool(inner) or not codes)


def numbers(name: str, code: str, values: NDArray) -> Node:
    """A node of one array property."""
    return Node(name, (PackedArray.of(values, code),), code)


def properties(*entries: tuple[str, str, str, str, Sequence[float | str]]) -> Node:
    """A Properties70 block of (name, type, label, flags, values); the type says how the values are stored."""
    items = []
    for name, kind, label, flags, values in entries:
        code = {"int": "I", "enum": "I", "bool": "I", "KTime": "L", "KString": "S", "object": "S"}.get(kind, "D")
        items.append(node("P", "SSSS" + code * len(values), name, kind, label, flags, *values))
    return node("Properties70", children=items)


def vector(name: str, values: Sequence[float], kind: str = "Vector3D") -> tuple[str, str, str, str, Sequence[float]]:
    """Property entry of three numbers; `kind` is also the name for the animated local ones."""
    local = kind.startswith("Lcl")
    return name, kind, "" if local else "Vector", "A" if local else "", [float(value) for value in values]


def time_mode(fps: float) -> tuple[int, float]:
    """TimeMode and CustomFrameRate of a frame rate."""
    for known, mode in TIME_MODES.items():
        if abs(known - fps) < 1e-7 * fps:
            return mode, -1.0
    return CUSTOM_TIME_MODE, fps


def ticks_of(frames: int, fps: float) -> NDArray[np.int64]:
    """Times (F,) in FBX ticks of frames 0 to F − 1."""
    return np.rint(np.arange(frames) * (TICKS / fps)).astype(np.int64)


def curve_keys(ticks: NDArray[np.int64], values: Array, version: int = 4008) -> list[Node]:
    """What an AnimationCurve holds: linear keys of values (K,) at times (K,)."""
    return [
        node("Default", "D", float(values[0])),
        node("KeyVer", "I", version),
        numbers("KeyTime", "l", ticks),
        numbers("KeyValueFloat", "f", values),
        numbers("KeyAttrFlags", "i", np.array([_LINEAR])),
        numbers("KeyAttrDataFloat", "f", np.array([0.0, 0.0, _THIRDS, 0.0])),
        numbers("KeyAttrRefCount", "i", np.array([len(values)])),
    ]


def header() -> list[Node]:
    """The nodes before the settings; the date is fixed so that equal motions give equal files."""
    stamp = zip(
        ("Year", "Month", "Day", "Hour", "Minute", "Second", "Millisecond"), (1970, 1, 1, 10, 0, 0, 0), strict=True
    )
    return [
        node(
            "FBXHeaderExtension",
            children=[
                node("FBXHeaderVersion", "I", 1003),
                node("FBXVersion", "I", VERSION),
                node("EncryptionType", "I", 0),
                node(
                    "CreationTimeStamp",
                    children=[node("Version", "I", 1000), *(node(name, "I", value) for name, value in stamp)],
                ),
                node("Creator", "S", CREATOR),
            ],
        ),
        node("FileId", "R", FILE_ID),
        node("CreationTime", "S", CREATION_TIME),
        node("Creator", "S", CREATOR),
    ]


def settings(fps: float, stop: int, axes: Sequence[tuple[str, int, int]] = Y_UP, unit: float = 0.01) -> Node:
    """Global settings: axes, size of a unit in metres, the frame rate, and a time line up to tick `stop`."""
    mode, custom = time_mode(fps)
    entries: list[tuple[str, str, str, str, Sequence[float | str]]] = []
    for name, axis, sign in axes:
        entries.append((f"{name}Axis", "int", "Integer", "", [axis]))
        entries.append((f"{name}AxisSign", "int", "Integer", "", [sign]))
    entries += [
        ("UnitScaleFactor", "double", "Number", "", [unit * 100]),
        ("OriginalUnitScaleFactor", "double", "Number", "", [unit * 100]),
        ("TimeMode", "enum", "", "", [mode]),
        ("TimeSpanStart", "KTime", "Time", "", [0]),
        ("TimeSpanStop", "KTime", "Time", "", [stop]),
        ("CustomFrameRate", "double", "Number", "", [custom]),
    ]
    return node("GlobalSettings", children=[node("Version", "I", 1000), properties(*entries)])


def documents(key: int, take: str) -> list[Node]:
    """The document list, the empty references, and which take is current."""
    scene = properties(("SourceObject", "object", "", "", []), ("ActiveAnimStackName", "KString", "", "", [take]))
    return [
        node(
            "Documents",
            children=[
                node("Count", "I", 1),
                node("Document", "LSS", key, "", "Scene", children=[scene, node("RootNode", "L", 0)]),
            ],
        ),
        node("References"),
    ]


def definitions(objects: Sequence[Node]) -> Node:
    """How many objects of each type follow."""
    counts: dict[str, int] = {"GlobalSettings": 1}
    for entry in objects:
        counts[entry.name] = counts.get(entry.name, 0) + 1
    types = [node("ObjectType", "S", name, children=[node("Count", "I", count)]) for name, count in counts.items()]
    return node("Definitions", children=[node("Version", "I", 100), node("Count", "I", sum(counts.values())), *types])


def takes(name: str, stop: int) -> Node:
    """The list of takes that readers of old show."""
    span = [
        node("FileName", "S", f"{name}.tak"),
        node("LocalTime", "LL", 0, stop),
        node("ReferenceTime", "LL", 0, stop),
    ]
    return node("Takes", children=[node("Current", "S", name), node("Take", "S", name, children=span)])
