"""ASF: Acclaim's skeletons, the half of a clip that an AMC file leaves out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from kinestitch.core.rotation import Array, quat_about_axis, quat_identity, quat_multiply
from kinestitch.errors import FormatError

CHANNELS = ("tx", "ty", "tz", "rx", "ry", "rz", "l")
_LIMIT = 1e9
_MOST_BONES = 10_000


@dataclass(slots=True)
class Bone:
    """One bone in the file's unit: where it starts in its parent, where it ends, its axes and its channels.

    vector : from the bone's start to its end, in world axes
    axes : xyzw, the frame that the bone's angles are measured in
    """

    name: str
    direction: tuple[float, float, float] = (0.0, 0.0, 0.0)
    length: float = 0.0
    angles: tuple[float, float, float] = (0.0, 0.0, 0.0)
    order: str = "XYZ"
    channels: tuple[str, ...] = ()
    axes: Array = field(default_factory=quat_identity)

    @property
    def vector(self) -> Array:
        """From start to end (3,), in the file's unit."""
        return np.array(self.direction) * self.length


@dataclass(slots=True)
class Asf:
    """A skeleton as its file has it: bones with the root first and parents before children.

    parents : one for each bone, -1 for the root
    radians : of one unit of the file's angles
    length : the number after ``length`` in ``:units``, NaN without one
    position : of the root, in the file's unit
    """

    bones: list[Bone]
    parents: list[int]
    radians: float
    length: float
    position: tuple[float, float, float]
    unused: int = 0


@dataclass(slots=True)
class _Reader:
    root: Bone = field(default_factory=lambda: Bone("root"))
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radians: float = math.radians(1.0)
    length: float = math.nan
    bones: dict[str, Bone] = field(default_factory=dict)
    children: dict[str, list[str]] = field(default_factory=dict)
    open_bone: Bone | None = None
    section: str = ""


def _fail(line: int, expected: str, got: str) -> FormatError:
    return FormatError(f"Line {line}: expected {expected}, got {got}.")


def numbers(line: int, words: list[str], count: int, what: str) -> tuple[float, ...]:
    """The first `count` words as finite numbers; raises FormatError with the line."""
    try:
        values = tuple(float(word) for word in words[:count])
    except ValueError:
        values = ()
    if len(values) != count or not all(abs(value) < _LIMIT for value in values):
        raise _fail(line, f"{count} number(s) after {what}", repr(" ".join(words)[:40]))
    return values


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split("#", 1)[0].split()
        if words:
            yield number, words


def parse_asf(text: str) -> Asf:
    """The skeleton of an ASF file. Raises FormatError with the line number."""
    reader = _Reader()
    line = 0
    for line, words in _statements(text):
        if words[0].startswith(":"):
            if reader.open_bone is not None:
                raise _fail(line, f"end after bone {reader.open_bone.name!r}", repr(words[0]))
            reader.section = words[0].lower()
            if reader.section == ":units" and len(words) > 1:
                _unit(reader, line, words[1:])
        elif reader.section in _SECTIONS:
            _SECTIONS[reader.section](reader, line, words)
        elif not reader.section:
            raise _fail(line, "a section like :units or :root", repr(words[0][:24]) + ". Is this an ASF file?")
    if not reader.bones or not reader.children:
        missing = ":bonedata" if not reader.bones else ":hierarchy"
        raise _fail(line, f"a section {missing}", "the end of the file. The file may be cut short")
    if reader.open_bone is not None:
        raise _fail(line, f"end after bone {reader.open_bone.name!r}", "the end of the file")
    return _ordered(reader)


def _unit(reader: _Reader, line: int, words: list[str]) -> None:
    keyword = words[0].lower()
    if keyword == "length":
        (reader.length,) = numbers(line, words[1:], 1, "length")
        if reader.length <= 0:
            raise _fail(line, "length > 0", words[1])
    elif keyword == "angle":
        kind = words[1].lower() if len(words) > 1 else "nothing"
        if kind[:3] not in ("deg", "rad"):
            raise _fail(line, "angle deg or rad", repr(kind[:24]))
        reader.radians = math.radians(1.0) if kind[:3] == "deg" else 1.0


def _root(reader: _Reader, line: int, words: list[str]) -> None:
    keyword = words[0].lower()
    if keyword == "order":
        reader.root.channels = _channels(line, words[1:])
    elif keyword == "axis":
        reader.root.order = _axis_order(line, words[1:2])
    elif keyword == "position":
        x, y, z = numbers(line, words[1:], 3, "position")
        reader.position = (x, y, z)
    elif keyword == "orientation":
        x, y, z = numbers(line, words[1:], 3, "orientation")
        reader.root.angles = (x, y, z)


def _bone(reader: _Reader, line: int, words: list[str]) -> None:
    keyword, rest = words[0].lower(), words[1:]
    bone = reader.open_bone
    if keyword == "begin":
        if bone is not None:
            raise _fail(line, f"end after bone {bone.name!r}", "begin")
        reader.open_bone = Bone("")
    elif bone is None:
        raise _fail(line, "begin", repr(words[0][:24]))
    elif keyword == "end":
        _close(reader, line, bone)
    elif keyword == "name":
        bone.name = rest[0] if rest else ""
    elif keyword == "direction":
        x, y, z = numbers(line, rest, 3, "direction")
        bone.direction = (x, y, z)
    elif keyword == "length":
        (bone.length,) = numbers(line, rest, 1, "length")
    elif keyword == "axis":
        x, y, z = numbers(line, rest, 3, "axis")
        bone.angles = (x, y, z)
        bone.order = _axis_order(line, rest[3:4])
    elif keyword == "dof":
        bone.channels = _channels(line, rest)


def _close(reader: _Reader, line: int, bone: Bone) -> None:
    if not bone.name:
        raise _fail(line, "a name before the end of a bone", "none")
    if bone.name in reader.bones or bone.name == "root":
        raise _fail(line, "bones with names of their own", f"{bone.name!r} twice")
    if len(reader.bones) >= _MOST_BONES:
        raise _fail(line, f"at most {_MOST_BONES} bones", "more")
    reader.bones[bone.name] = bone
    reader.open_bone = None


def _hierarchy(reader: _Reader, line: int, words: list[str]) -> None:
    if words[0].lower() in ("begin", "end"):
        return
    for name in words:
        if name != "root" and name not in reader.bones:
            raise _fail(line, "names of bones", repr(name[:40]))
    reader.children.setdefault(words[0], []).extend(words[1:])


_SECTIONS = {":units": _unit, ":root": _root, ":bonedata": _bone, ":hierarchy": _hierarchy}


def _channels(line: int, words: list[str]) -> tuple[str, ...]:
    channels = tuple(word.lower() for word in words)
    if len(set(channels)) < len(channels) or not set(channels) <= set(CHANNELS):
        raise _fail(line, f"channels out of {', '.join(CHANNELS)}", repr(" ".join(words)[:40]))
    return channels


def _axis_order(line: int, words: list[str]) -> str:
    order = words[0].upper() if words else "nothing"
    if sorted(order) != ["X", "Y", "Z"]:
        raise _fail(line, "an order of axes like XYZ", repr(order[:24]))
    return order


def _ordered(reader: _Reader) -> Asf:
    """Bones depth first from the root."""
    bones, parents = [reader.root], [-1]
    waiting = [(name, 0) for name in reversed(reader.children.get("root", []))]
    seen = {"root"}
    while waiting:
        name, parent = waiting.pop()
        if name in seen:
            raise FormatError(f"Expected every bone once in :hierarchy, got {name!r} twice.")
        seen.add(name)
        parents.append(parent)
        bones.append(reader.bones[name])
        waiting += [(child, len(bones) - 1) for child in reversed(reader.children.get(name, []))]
    for bone in bones:
        bone.axes = turned(np.array(bone.angles) * reader.radians, bone.order.lower())
    unused = len(reader.bones) + 1 - len(bones)
    return Asf(bones, parents, reader.radians, reader.length, reader.position, unused)


def turned(angles: Array, axes: str) -> Array:
    """Quaternions (..., 4) of angles (..., n) rad about fixed axes, the first one first: ``"xyz"`` is Rz Ry Rx."""
    result = np.broadcast_to(quat_identity(), (*angles.shape[:-1], 4))
    for column, axis in enumerate(axes):
        result = quat_multiply(quat_about_axis("xyz".index(axis), angles[..., column]), result)
    return np.asarray(result)
