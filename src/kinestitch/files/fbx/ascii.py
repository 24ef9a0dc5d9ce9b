"""Text FBX, read into the same node tree as the binary form."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from kinestitch.errors import FormatError
from kinestitch.files.fbx.nodes import Document, Node, PackedArray, Property

MAX_DEPTH = 100
_TOKEN = re.compile(
    r"""(?P<name>[A-Za-z_][\w|\-]*)[ \t]*:(?!:)   # a node begins
      | "(?P<string>[^"]*)"
      | (?P<number>[-+]?(?:\d[\w.+\-#]*|\.\d[\w.+\-#]*|(?:nan|inf)\b[\w()]*))
      | \*(?P<count>\d+)
      | (?P<mark>[{},])
      | (?P<word>[A-Za-z_][\w.]*)
      | (?P<rest>\S)""",
    re.VERBOSE | re.IGNORECASE,
)
_SPACE = re.compile(r"(?:[\s]+|;[^\n]*)+")
_VERSION = re.compile(r"FBXVersion:\s*(\d{4,5})|;\s*FBX\s+(\d)\.(\d)\.(\d)")


@dataclass(slots=True)
class _Reader:
    text: str
    at: int = 0

    def skip(self) -> None:
        blank = _SPACE.match(self.text, self.at)
        if blank:
            self.at = blank.end()

    def peek(self) -> re.Match[str] | None:
        self.skip()
        return _TOKEN.match(self.text, self.at)

    def fault(self, expected: str, got: str) -> FormatError:
        line = self.text.count("\n", 0, self.at) + 1
        return FormatError(f"Line {line}: expected {expected}, got {got}. The file is damaged; export it again.")

    def nodes(self, depth: int) -> tuple[Node, ...]:
        if depth > MAX_DEPTH:
            raise self.fault(f"nodes nested at most {MAX_DEPTH} deep", "deeper ones")
        found = []
        while (token := self.peek()) is not None and token["mark"] != "}":
            if token["name"] is None:
                raise self.fault("the name of a node", repr(token[0][:40]))
            self.at = token.end()
            found.append(self.node(token["name"], depth))
        return tuple(found)

    def node(self, name: str, depth: int) -> Node:
        values: list[Property] = []
        codes: list[str] = []
        while (token := self.peek()) is not None and token["name"] is None and token["mark"] != "}":
            if token["mark"] == "{":
                self.at = token.end()
                children = self.nodes(depth + 1)
                self.close()
                return Node(name, tuple(values), "".join(codes), children, terminated=True)
            if token["count"] is not None:
                self.at = token.end()
                return self.array(name, int(token["count"]) if len(token["count"]) < 12 else 1 << 62)
            self.at = token.end()
            if token["mark"] != ",":
                code, value = self.value(token)
                codes.append(code)
                values.append(value)
        return Node(name, tuple(values), "".join(codes))

    def value(self, token: re.Match[str]) -> tuple[str, Property]:
        if token["string"] is not None:
            return "S", token["string"].replace("&quot;", '"').replace("&cr;", "\r").replace("&lf;", "\n")
        if token["word"] is not None:
            return "C" if len(token["word"]) == 1 else "S", ord(token["word"]) if len(token["word"]) == 1 else token[
                "word"
            ]
        if token["number"] is None:
            raise self.fault("a value", repr(token[0][:40]))
        return number(token["number"])

    def array(self, name: str, count: int) -> Node:
        start = self.text.find("{", self.at)
        stop = self.text.find("}", self.at)
        head = self.text[self.at : start] if start >= 0 else "?"
        if start < 0 or stop < start or head.strip():
            raise self.fault(f"a block of {count} numbers", "something else")
        body = self.text[start + 1 : stop].split(":", 1)[-1]
        values = numbers(body)
        if values is None or len(values) != count:
            got = "text" if values is None else f"{len(values)}"
            raise self.fault(f"{count} numbers in {name[:40]!r}", got)
        self.at = stop + 1
        code = "l" if values.dtype.kind == "i" else "d"
        return Node(name, (PackedArray.of(values, code, compress=False),), code)

    def close(self) -> None:
        token = self.peek()
        if token is None or token["mark"] != "}":
            raise self.fault("'}'", "the end of the file")
        self.at = token.end()


def number(text: str) -> tuple[str, int | float]:
    """Type letter and value of one number; what is no number after all (``-1.#IND``) is NaN."""
    try:
        value = int(text)
        if abs(value) < 2**63:
            return "L", value
    except ValueError:
        pass
    try:
        return "D", float(text)
    except ValueError:
        return "D", float("nan")


def numbers(body: str) -> np.ndarray | None:
    """Comma-separated numbers as int64, or as float64 where one has a point or is too large; None for anything else."""
    parts = body.replace("\n", "").replace("\r", "").strip().strip(",").split(",") if body.strip() else []
    for kind in (np.int64, np.float64):
        try:
            return (
                np.array(parts, dtype=kind)
                if kind is np.float64
                else np.array([int(part) for part in parts], dtype=kind)
            )
        except (ValueError, OverflowError):
            continue
    values = [number(part.strip())[1] if part.strip() else None for part in parts]
    return None if None in values else np.array(values, dtype=np.float64)


def parse_ascii(data: bytes) -> Document:
    """The node tree of a text FBX file of any version; raises FormatError where the text is no FBX."""
    text = data.decode("utf-8", "surrogateescape").lstrip("\ufeff")
    found = _VERSION.search(text[:20_000])
    if found is None:
        raise FormatError(f"Expected an FBX file, got {data[:16]!r}. Check the suffix.")
    version = int(found[1]) if found[1] else int(found[2]) * 1000 + int(found[3]) * 100 + int(found[4]) * 10
    reader = _Reader(text)
    nodes = reader.nodes(0)
    if reader.peek() is not None:
        raise reader.fault("the name of a node", "'}'")
    if not nodes:
        raise FormatError("Expected FBX nodes, got none. The file is empty or cut short.")
    return Document(version, nodes, binary=False)
