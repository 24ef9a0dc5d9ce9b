"""Binary FBX, both ways: node records with 32- or 64-bit headers, typed properties, zlib arrays and the footer."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np

from kinestitch.errors import FormatError
from kinestitch.files.fbx.nodes import ARRAY_TYPES, Document, Node, PackedArray, Property

MAGIC = b"Kaydara FBX Binary  \x00\x1a"
MAX_DEPTH = 100
MAX_NODES = 20_000_000
_SCALARS = {"B": "b", "C": "B", "Y": "h", "I": "i", "L": "q", "F": "f", "D": "d"}
_FOOTER_ID = bytes.fromhex("fabcab09d0c8d466b176fb831cf7267e")
_FOOTER_MAGIC = bytes.fromhex("f85a8c6adef5d97eece90ce3758f290b")
# key of the creation time that belongs to _FOOTER_ID; readers that check the pair find it right
FILE_ID = bytes.fromhex("28b32aebb624ccc2bfc8b02aa92bfcf1")
CREATION_TIME = "1970-01-01 10:00:00:000"


@dataclass(slots=True)
class _Reader:
    data: memoryview
    order: str
    wide: bool
    left: int = MAX_NODES

    def __post_init__(self) -> None:
        self.head = struct.Struct(self.order + ("QQQB" if self.wide else "IIIB"))
        self.triple = struct.Struct(self.order + "III")
        self.length = struct.Struct(self.order + "I")
        self.scalars = {code: struct.Struct(self.order + letter) for code, letter in _SCALARS.items()}

    head: struct.Struct = None  # type: ignore[assignment]
    triple: struct.Struct = None  # type: ignore[assignment]
    length: struct.Struct = None  # type: ignore[assignment]
    scalars: dict[str, struct.Struct] = None  # type: ignore[assignment]

    def nodes(self, start: int, stop: int, depth: int) -> tuple[tuple[Node, ...], bool, int]:
        """Nodes from `start` until an empty record or `stop`; whether an empty record closed them; where they ended."""
        if depth > MAX_DEPTH:
            raise _damaged(start, f"nodes nested at most {MAX_DEPTH} deep", "deeper ones")
        found: list[Node] = []
        while start < stop:
            if start + self.head.size > stop:
                raise _damaged(start, "a node", "the end of the data")
            end, count, length, name_length = self.head.unpack_from(self.data, start)
            if end == 0:
                return tuple(found), True, start + self.head.size
            found.append(self.node(start, stop, (end, count, length, name_length), depth))
            start = end
        return tuple(found), False, start

    def node(self, start: int, stop: int, head: tuple[int, int, int, int], depth: int) -> Node:
        end, count, length, name_length = head
        name_at = start + self.head.size
        values_at = name_at + name_length
        children_at = values_at + length
        if not start < end <= stop or children_at > end:
            raise _damaged(start, f"a node that ends by byte {stop}", f"one that ends at {max(end, children_at)}")
        self.left -= 1
        if count > length or self.left < 0:
            raise _damaged(start, f"at most {length} properties in {length} bytes", f"a claim of {count}")
        name = bytes(self.data[name_at:values_at]).decode("utf-8", "surrogateescape")
        codes, properties = self.properties(values_at, children_at, count)
        children, terminated, reached = self.nodes(children_at, end, depth + 1)
        if reached != end:
            raise _damaged(reached, f"the end of node {name[:40]!r} at byte {end}", "more bytes")
        return Node(name, properties, codes, children, terminated)

    def properties(self, at: int, stop: int, count: int) -> tuple[str, tuple[Property, ...]]:
        codes = []
        values: list[Property] = []
        data = self.data
        for _ in range(count):
            if at >= stop:
                raise _damaged(at, "a property", "the end of the node")
            code = chr(data[at])
            at += 1
            scalar = self.scalars.get(code)
            if scalar is not None:
                if at + scalar.size > stop:
                    raise _damaged(at, "a number", "the end of the node")
                values.append(scalar.unpack_from(data, at)[0])
                at += scalar.size
            elif code in "SR":
                raw, at = self.blob(at, stop)
                values.append(raw.decode("utf-8", "surrogateescape") if code == "S" else raw)
            elif code in ARRAY_TYPES:
                array, at = self.packed(code, at, stop)
                values.append(array)
            else:
                raise _damaged(at - 1, "a property type", repr(code))
            codes.append(code)
        if at != stop:
            raise _damaged(at, f"properties up to byte {stop}", f"{stop - at} bytes more")
        return "".join(codes), tuple(values)

    def blob(self, at: int, stop: int) -> tuple[bytes, int]:
        if at + 4 > stop:
            raise _damaged(at, "a length", "the end of the node")
        end = at + 4 + self.length.unpack_from(self.data, at)[0]
        if end > stop:
            raise _damaged(at, f"a string that ends by byte {stop}", f"one that ends at {end}")
        return bytes(self.data[at + 4 : end]), end

    def packed(self, code: str, at: int, stop: int) -> tuple[PackedArray, int]:
        if at + 12 > stop:
            raise _damaged(at, "an array", "the end of the node")
        count, encoding, length = self.triple.unpack_from(self.data, at)
        at += 12
        size = count * np.dtype(ARRAY_TYPES[code]).itemsize
        if encoding == 0:
            length = size  # some writers leave the length of raw arrays at nonsense
        elif encoding != 1:
            raise _damaged(at, "array encoding 0 or 1", str(encoding))
        if at + length > stop:
            raise _damaged(at, f"an array that ends by byte {stop}", f"one that ends at {at + length}")
        return PackedArray(code, count, encoding, self.data[at : at + length], self.order), at + length


def _damaged(at: int, expected: str, got: str) -> FormatError:
    return FormatError(f"Byte {at}: expected {expected}, got {got}. The file is damaged or cut short; export it again.")


def is_binary(data: bytes) -> bool:
    """Whether the bytes start like a binary FBX file."""
    return data[: len(MAGIC) - 2] == MAGIC[:-2]


def parse_binary(data: bytes) -> Document:
    """The node tree of a binary FBX file of any version; raises FormatError for damaged bytes."""
    if not is_binary(data):
        raise FormatError(f"Expected a binary FBX file, got {bytes(data[:16])!r}.")
    if len(data) < 27:
        raise _damaged(len(data), "a header of 27 bytes", "the end of the file")
    order = ">" if data[22] == 1 else "<"
    version = struct.unpack_from(order + "I", data, 23)[0]
    if not 3000 <= version < 10000:
        raise FormatError(f"Expected an FBX version from 3000 to 9999, got {version}.")
    reader = _Reader(memoryview(data), order, version >= 7500)
    nodes, closed, end = reader.nodes(27, len(data), 0)
    if not closed and version >= 7000:
        raise _damaged(end, "an empty record after the last node", "the end of the file")
    return Document(version, nodes, True, order, bytes(data[end:]), end)


def serialise(document: Document) -> bytes:
    """The bytes of a binary FBX file; a parsed one that was not touched comes back byte for byte."""
    wide = document.version >= 7500
    if document.order == ">":
        raise FormatError(
            "Expected a little-endian FBX file to write back, got a big-endian one. Convert it to a new file."
        )
    out = bytearray(MAGIC + b"\x00" + struct.pack("<I", document.version))
    for node in document.nodes:
        _put(out, node, wide)
    out += bytes(25 if wide else 13)
    if document.footer and len(out) == document.end:
        return bytes(out + document.footer)
    identity = document.footer[:16] if len(document.footer) >= 16 else _FOOTER_ID
    out += identity
    out += bytes(-len(out) % 16 or 16)
    return bytes(out + bytes(4) + struct.pack("<I", document.version) + bytes(120) + _FOOTER_MAGIC)


def _put(out: bytearray, node: Node, wide: bool) -> None:
    head = struct.Struct("<QQQB" if wide else "<IIIB")
    start = len(out)
    name = node.name.encode("utf-8", "surrogateescape")
    out += bytes(head.size) + name
    values_at = len(out)
    for code, value in zip(node.codes, node.properties, strict=True):
        _put_property(out, code, value)
    length = len(out) - values_at
    for child in node.children:
        _put(out, child, wide)
    if node.terminated:
        out += bytes(head.size)
    head.pack_into(out, start, len(out), len(node.properties), length, len(name))


def _put_property(out: bytearray, code: str, value: Property) -> None:
    out += code.encode()
    if isinstance(value, PackedArray):
        out += struct.pack("<III", value.count, value.encoding, len(value.payload))
        out += value.payload
    elif isinstance(value, str | bytes):
        raw = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value
        out += struct.pack("<I", len(raw)) + raw
    else:
        out += struct.pack("<" + _SCALARS[code], value)
