"""The GLB container: a header, one JSON chunk, binary chunks. Parsing and serialising keep chunks byte for byte."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from kinestitch.errors import FormatError, OutputError

JSON_CHUNK = 0x4E4F534A
BINARY_CHUNK = 0x004E4942
_MAGIC = b"glTF"
_LARGEST = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Glb:
    """What stands in a GLB file: the JSON document, and the chunks behind it as (type, bytes) in the file's order."""

    document: dict[str, Any]
    chunks: tuple[tuple[int, memoryview | bytes], ...] = ()

    @property
    def binary(self) -> memoryview | bytes | None:
        """Bytes of the first binary chunk, the file's buffer 0; None if there is none."""
        return next((data for kind, data in self.chunks if kind == BINARY_CHUNK), None)


def is_glb(data: bytes) -> bool:
    """Whether the bytes begin like a GLB file."""
    return data[:4] == _MAGIC


def parse_json(text: bytes) -> dict[str, Any]:
    """The JSON document of a glTF file; raises FormatError if it is none."""
    try:
        document = json.loads(text.decode("utf-8"), parse_constant=_no_number)
    except RecursionError:
        raise FormatError("Expected a JSON document, got one nested too deeply.") from None
    except ValueError as error:
        raise FormatError(f"Expected a JSON document, got text that is none: {error}.") from None
    if not isinstance(document, dict):
        raise FormatError(f"Expected a JSON object at the top, got {type(document).__name__}.")
    return document


def _no_number(name: str) -> float:
    raise ValueError(f"{name} is no JSON number")


def parse_glb(data: bytes) -> Glb:
    """Take a GLB file apart; chunks are views of `data`, not copies. Raises FormatError."""
    if not is_glb(data):
        raise FormatError(f"Expected a GLB file that begins with 'glTF', got {bytes(data[:4])!r}.")
    if len(data) < 20:
        raise FormatError(f"Expected a GLB file of at least 20 bytes, got {len(data)}. The file may be cut short.")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise FormatError(f"Expected GLB version 2, got {version}. Convert the file to glTF 2.0.")
    if length > len(data):
        raise FormatError(f"Expected {length} bytes as the header says, got {len(data)}. The file may be cut short.")
    view = memoryview(data)
    chunks: list[tuple[int, memoryview]] = []
    position = 12
    while position + 8 <= length:
        size, kind = struct.unpack_from("<II", data, position)
        position += 8
        if size > length - position:
            raise FormatError(f"Byte {position}: expected a chunk of {size} bytes, got {length - position}.")
        chunks.append((kind, view[position : position + size]))
        position += size + -size % 4
    if not chunks or chunks[0][0] != JSON_CHUNK:
        raise FormatError("Byte 12: expected a JSON chunk, got another kind.")
    return Glb(parse_json(bytes(chunks[0][1])), tuple(chunks[1:]))


def json_bytes(document: dict[str, Any]) -> bytes:
    """A document as JSON; raises FormatError for numbers that JSON cannot tell (a file may say 1e999)."""
    try:
        return json.dumps(document, separators=(",", ":"), allow_nan=False).encode("ascii")
    except (ValueError, RecursionError) as error:
        raise FormatError(f"Expected a document that JSON can hold, got: {error}.") from None


def serialise_glb(
    document: dict[str, Any], parts: Sequence[tuple[int, Sequence[bytes | memoryview]]]
) -> Iterator[bytes]:
    """The bytes of a GLB file, piece by piece.

    parts : (chunk type, pieces of its bytes) of each chunk behind the JSON

    Raises FormatError as :func:`json_bytes` does, OutputError beyond the 4 GiB that a GLB can tell.
    """
    text = json_bytes(document)
    text += b" " * (-len(text) % 4)
    sizes = [sum(len(memoryview(piece).cast("B")) for piece in pieces) for _, pieces in parts]
    total = 12 + 8 + len(text) + sum(8 + size + -size % 4 for size in sizes)
    if total > _LARGEST:
        raise OutputError(f"Expected a GLB file below 4 GiB, got {total} bytes. Write fewer frames.")
    yield _MAGIC + struct.pack("<IIII", 2, total, len(text), JSON_CHUNK) + text
    for (kind, pieces), size in zip(parts, sizes, strict=True):
        yield struct.pack("<II", size + -size % 4, kind)
        yield from (bytes(piece) for piece in pieces)
        yield b"\0" * (-size % 4)
