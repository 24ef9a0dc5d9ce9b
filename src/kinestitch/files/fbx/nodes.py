"""The FBX node tree as values: named nodes with typed properties and children, whatever file they stood in."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError

ARRAY_TYPES = {"b": "i1", "c": "i1", "i": "i4", "l": "i8", "f": "f4", "d": "f8"}
MAX_ARRAY_BYTES = (
    1 << 29
)  # 512 MiB: an hour of 65 joints at 240 fps is 40 MiB a curve set; more is a decompression bomb


@dataclass(frozen=True, slots=True, eq=False)
class PackedArray:
    """An array property as the file holds it, so that writing it back gives the same bytes; decoded when asked.

    code : one of ``ARRAY_TYPES``
    count : number of elements
    encoding : 0 raw, 1 zlib
    payload : the bytes in the file
    order : byte order, ``<`` or ``>``
    """

    code: str
    count: int
    encoding: int
    payload: bytes | memoryview
    order: str = "<"

    @classmethod
    def of(cls, values: NDArray, code: str, *, compress: bool = True) -> PackedArray:
        """Pack numbers as type `code`; short arrays stay raw, as the FBX SDK keeps them."""
        array = np.ascontiguousarray(values, dtype="<" + ARRAY_TYPES[code])
        raw = array.tobytes()
        if compress and len(raw) > 128:
            return cls(code, array.size, 1, zlib.compress(raw, 6))
        return cls(code, array.size, 0, raw)

    def values(self) -> NDArray:
        """The elements (count,), read-only; raises FormatError if the bytes do not hold exactly that many."""
        dtype = np.dtype(self.order + ARRAY_TYPES[self.code])
        size = self.count * dtype.itemsize
        raw = self.payload
        if self.encoding == 1:
            raw = _inflate(self.payload, size)
        if len(raw) != size:
            raise FormatError(
                f"Expected an array of {size} bytes, got {len(raw)}. The file is damaged; export it again."
            )
        return np.frombuffer(raw, dtype)


def _inflate(payload: bytes | memoryview, size: int) -> bytes:
    # zlib expands at most 1032:1, so a larger claim is false and is refused before anything is allocated
    if size > MAX_ARRAY_BYTES or size > 1040 * len(payload) + 64:
        raise FormatError(f"Expected an array that fits its {len(payload)} packed bytes, got a claim of {size} bytes.")
    try:
        machine = zlib.decompressobj()
        raw = machine.decompress(payload, size + 1)
    except zlib.error as error:
        raise FormatError(
            f"Expected zlib data in an array, got: {error}. The file is damaged; export it again."
        ) from None
    return raw


Property = int | float | str | bytes | PackedArray


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """One node: ``name: properties { children }``.

    properties : int for codes B, C, Y, I, L; float for F, D; str for S (undecodable bytes as surrogates); bytes for R;
        :class:`PackedArray` for arrays
    codes : one type letter per property
    terminated : a binary file closes the list of children with an empty record (also where there are none)
    """

    name: str
    properties: tuple[Property, ...] = ()
    codes: str = ""
    children: tuple[Node, ...] = field(default=())
    terminated: bool = False

    def all(self, name: str) -> Iterator[Node]:
        """Children of that name, in order."""
        return (child for child in self.children if child.name == name)

    def child(self, name: str) -> Node | None:
        """The first child of that name, or None."""
        return next(self.all(name), None)

    def text(self, index: int = 0) -> str:
        """Property `index` as a string; empty where it is missing or no string."""
        value = self.properties[index] if index < len(self.properties) else ""
        return value if isinstance(value, str) else ""

    def integer(self, index: int = 0, default: int = 0) -> int:
        """Property `index` as an int; `default` where it is missing or no finite number."""
        value = self.properties[index] if index < len(self.properties) else default
        if isinstance(value, int):
            return value
        return int(value) if isinstance(value, float) and abs(value) < 2**63 else default

    def number(self, index: int = 0, default: float = 0.0) -> float:
        """Property `index` as a float; `default` where it is missing or no number."""
        value = self.properties[index] if index < len(self.properties) else default
        return float(value) if isinstance(value, int | float) else default

    def array(self) -> Array:
        """The node's numbers (n,) as float64: its first array property, else all its scalar numbers."""
        if self.properties and isinstance(self.properties[0], PackedArray):
            return self.properties[0].values().astype(np.float64)
        return np.array([v for v in self.properties if isinstance(v, int | float)], dtype=np.float64)

    def raw(self) -> NDArray:
        """The node's numbers (n,) in the type that the file gives them."""
        if self.properties and isinstance(self.properties[0], PackedArray):
            return self.properties[0].values()
        return self.array()

    def integers(self) -> NDArray[np.int64]:
        """The node's numbers (n,) as int64 (key times lose digits as floats)."""
        if self.properties and isinstance(self.properties[0], PackedArray):
            values = self.properties[0].values()
            if values.dtype.kind == "f":
                values = np.where(np.abs(values) < 2.0**62, values, 0)
            return values.astype(np.int64)
        return np.array([self.integer(i) for i in range(len(self.properties))], dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Document:
    """A whole file: its version (7400 is FBX 7.4), its top nodes, and what a binary file says around them.

    binary : False for text files
    order : byte order, ``<`` or ``>``
    footer : bytes after the last node, as they stood
    end : file offset at which the footer started
    """

    version: int
    nodes: tuple[Node, ...]
    binary: bool = True
    order: str = "<"
    footer: bytes = b""
    end: int = 0

    def child(self, name: str) -> Node | None:
        """The first top node of that name, or None."""
        return next((node for node in self.nodes if node.name == name), None)
