"""The upper half of a BVH file: joints with their offsets, channels and End Sites, as text and as values."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from kinestitch.errors import FormatError

_CHANNEL = re.compile(r"([XYZ])(position|rotation)$", re.IGNORECASE)
_LIMIT = 1e12
_BRACES = re.compile(r"([{}])")


@dataclass(slots=True)
class Node:
    """One joint as the file has it: lengths in the file's unit, channels like ``"Zrotation"`` in the file's order."""

    name: str
    parent: int
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    channels: list[str] = field(default_factory=list)
    tip: tuple[float, float, float] | None = None


@dataclass(slots=True)
class _Reader:
    """Where parsing stands: the joints so far and the blocks that are open (None for an End Site)."""

    nodes: list[Node] = field(default_factory=list)
    open_blocks: list[Node | None] = field(default_factory=list)
    waiting: bool = False  # a joint or End Site was named and its "{" has not come yet


def _fail(line: int, expected: str, got: str) -> FormatError:
    return FormatError(f"Line {line}: expected {expected}, got {got}. Export it again.")


def _statements(text: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and words of each statement; braces stand alone."""
    for number, line in enumerate(text.split("\n"), start=1):
        for piece in _BRACES.split(line) if "{" in line or "}" in line else (line,):
            words = piece.split()
            if words:
                yield number, words


def parse_hierarchy(text: str) -> list[Node]:
    """The joints of the text between ``HIERARCHY`` and ``MOTION``, parents before children.

    Raises FormatError with the line number.
    """
    reader = _Reader()
    statements = _statements(text)
    line, words = next(statements, (1, ["nothing"]))
    if words[0].upper() != "HIERARCHY":
        raise _fail(line, "HIERARCHY", repr(" ".join(words)[:40]))
    rest = words[1:]
    while True:
        if not rest:
            following = next(statements, None)
            if following is None:
                break
            line, rest = following
        rest = _statement(reader, line, rest)
    if reader.open_blocks or reader.waiting:
        raise _fail(line, "a closing '}' for every joint", f"{len(reader.open_blocks) + reader.waiting} left open")
    if not reader.nodes:
        raise _fail(line, "ROOT and the name of a joint", "the end of the hierarchy")
    if not any(node.channels for node in reader.nodes):
        raise _fail(line, "at least one joint with channels", "none")
    return reader.nodes


def _statement(reader: _Reader, line: int, words: list[str]) -> list[str]:
    """Take one statement in; return the words on its line that belong to the next one."""
    keyword = words[0].upper()
    if keyword == "{":
        if not reader.waiting:
            raise _fail(line, "OFFSET, CHANNELS, JOINT, End Site or '}'", "'{'")
        reader.waiting = False
        return words[1:]
    if reader.waiting:
        raise _fail(line, "'{'", repr(words[0][:40]))
    if keyword == "}":
        if not reader.open_blocks:
            raise _fail(line, "ROOT or MOTION", "'}' that closes nothing")
        reader.open_blocks.pop()
        return words[1:]
    if keyword in ("ROOT", "JOINT"):
        _open_joint(reader, line, keyword, " ".join(words[1:]))
        return []
    if not reader.open_blocks:
        raise _fail(line, "ROOT or MOTION", repr(words[0][:40]))
    if keyword == "END":
        if reader.open_blocks[-1] is None:
            raise _fail(line, "OFFSET or '}' in an End Site", "another End Site")
        reader.open_blocks.append(None)
        reader.waiting = True
        return []
    if keyword == "OFFSET":
        return _offset(reader, line, words)
    if keyword == "CHANNELS":
        return _channels(reader, line, words)
    raise _fail(line, "OFFSET, CHANNELS, JOINT, End Site or '}'", repr(words[0][:40]))


def _open_joint(reader: _Reader, line: int, keyword: str, name: str) -> None:
    if not name:
        raise _fail(line, f"a name after {keyword}", "none")
    parent = -1
    if keyword == "ROOT":
        if reader.nodes:
            raise FormatError(
                f"Line {line}: expected one ROOT, got a second one, {name[:40]!r}. "
                "Save each figure as a file of its own."
            )
    else:
        if not reader.open_blocks or reader.open_blocks[-1] is None:
            raise _fail(line, "JOINT inside a ROOT or JOINT", f"JOINT {name[:40]!r} outside")
        above = reader.open_blocks[-1]
        parent = next(i for i in range(len(reader.nodes) - 1, -1, -1) if reader.nodes[i] is above)
    node = Node(name, parent)
    reader.nodes.append(node)
    reader.open_blocks.append(node)
    reader.waiting = True


def _offset(reader: _Reader, line: int, words: list[str]) -> list[str]:
    try:
        x, y, z = (float(word) for word in words[1:4])
    except ValueError:
        raise _fail(line, "three numbers after OFFSET", repr(" ".join(words[1:4])[:60])) from None
    if not all(math.isfinite(v) and abs(v) < _LIMIT for v in (x, y, z)):
        raise _fail(line, "a finite OFFSET", repr(" ".join(words[1:4])[:60]))
    node = reader.open_blocks[-1]
    if node is not None:
        node.offset = (x, y, z)
    else:
        leaf = reader.open_blocks[-2]
        if leaf is not None and leaf.tip is None:
            leaf.tip = (x, y, z)
    return words[4:]


def _channels(reader: _Reader, line: int, words: list[str]) -> list[str]:
    node = reader.open_blocks[-1]
    count = words[1] if len(words) > 1 else ""
    if node is None:
        raise _fail(line, "no CHANNELS in an End Site", "some")
    if not count.isdecimal() or len(count) > 3:
        raise _fail(line, "the number of channels after CHANNELS", repr(count[:40]))
    names = words[2 : 2 + int(count)]
    if len(names) < int(count):
        raise _fail(line, f"{count} channel names", str(len(names)))
    for name in names:
        match = _CHANNEL.match(name)
        if match is None:
            raise _fail(line, "a channel like Xposition or Zrotation", repr(name[:40]))
        channel = match[1].upper() + match[2].lower()
        if channel.endswith("position") and channel in node.channels:
            raise _fail(line, "each position channel once in a joint", f"{channel} twice")
        node.channels.append(channel)
    return words[2 + int(count) :]
