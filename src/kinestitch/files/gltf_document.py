"""A glTF document with its buffers; everything it says is checked before it is believed."""

from __future__ import annotations

import base64
import binascii
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError
from kinestitch.files.glb import is_glb, parse_glb, parse_json

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_LIMIT = 1e12
_DATA_URI = re.compile(r"data:[^,]{0,200};base64,", re.IGNORECASE)
_SCHEME = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:")

Json = dict[str, Any]


def objects(holder: Json, key: str) -> list[Json]:
    """The list of objects under `key`; empty if there is none."""
    value = holder.get(key, [])
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise FormatError(f"Expected a list of objects as {key!r}, got something else.")
    return value


def child(holder: Json, key: str) -> Json:
    """The object under `key`; raises FormatError if there is none."""
    value = holder.get(key)
    if not isinstance(value, dict):
        raise FormatError(f"Expected an object as {key!r}, got {value!r:.40}.")
    return value


def whole(holder: Json, key: str, *, below: int, default: int | None = None) -> int:
    """The integer in [0, below) under `key`."""
    value = holder.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < below:
        raise FormatError(f"Expected {key!r} to be a whole number from 0 to {below - 1}, got {value!r:.40}.")
    return value


def wholes(holder: Json, key: str, *, below: int) -> list[int]:
    """The list of integers in [0, below) under `key`; empty if there is none."""
    values = holder.get(key, [])
    if not isinstance(values, list):
        raise FormatError(f"Expected a list as {key!r}, got {values!r:.40}.")
    return [whole({key: value}, key, below=below) for value in values]


def numbers(holder: Json, key: str, default: tuple[float, ...]) -> Array:
    """The numbers under `key`, as many as `default` has."""
    values = holder.get(key, default)
    if not isinstance(values, list | tuple) or len(values) != len(default):
        raise FormatError(f"Expected {len(default)} numbers as {key!r}, got {values!r:.40}.")
    if not all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) < _LIMIT for v in values):
        raise FormatError(f"Expected finite numbers as {key!r}, got {values!r:.60}.")
    return np.array(values, dtype=np.float64)


def text(holder: Json, key: str, default: str) -> str:
    """The string under `key`; `default` if it is missing or empty."""
    value = holder.get(key, default)
    if not isinstance(value, str):
        raise FormatError(f"Expected a string as {key!r}, got {value!r:.40}.")
    return value or default


@dataclass(slots=True)
class GltfDocument:
    """A glTF file in memory.

    json : the document
    binary : the GLB's binary chunk, or None
    folder : where external buffers lie
    chunks : all chunks of a GLB behind its JSON, as (type, bytes)
    """

    json: Json
    binary: memoryview | bytes | None
    folder: Path
    chunks: tuple[tuple[int, memoryview | bytes], ...] = ()
    _buffers: dict[int, memoryview | bytes] = field(default_factory=dict)
    _lists: dict[str, list[Json]] = field(default_factory=dict)

    def objects(self, key: str) -> list[Json]:
        """The document's list of objects under `key`."""
        if key not in self._lists:
            self._lists[key] = objects(self.json, key)
        return self._lists[key]

    def buffer(self, index: int) -> memoryview | bytes:
        """Bytes of one buffer, from the binary chunk, base64 or a file beside this one."""
        if index not in self._buffers:
            self._buffers[index] = self._load_buffer(index)
        return self._buffers[index]

    def _load_buffer(self, index: int) -> memoryview | bytes:
        entry = self.objects("buffers")[index]
        if "uri" not in entry:
            if index != 0 or self.binary is None:
                raise FormatError(f"Expected a binary chunk for buffer {index}, got none. The file may be cut short.")
            return self.binary
        uri = text(entry, "uri", "")
        match = _DATA_URI.match(uri)
        if match:
            try:
                return base64.b64decode(uri[match.end() :], validate=True)
            except (binascii.Error, ValueError):
                raise FormatError(f"Expected base64 in buffer {index}, got text that is none.") from None
        name = unquote(uri)
        if _SCHEME.match(uri) or not name or "\0" in name or Path(name).is_absolute():
            raise FormatError(f"Expected a file beside this one for buffer {index}, got {uri[:60]!r}.")
        try:
            return (self.folder / name).read_bytes()
        except OSError as error:
            raise FormatError(f"Expected the file {name[:60]!r} beside this one, got: {error.strerror}.") from None

    def accessor(self, index: int, *kinds: str) -> Array:
        """Values (count, width) of an accessor of one of the `kinds`, e.g. ``"VEC3"``.

        Normalised integers come as fractions. Raises FormatError for anything that does not fit into its buffer.
        """
        entry = self.objects("accessors")[index]
        kind = text(entry, "type", "")
        if kind not in kinds:
            raise FormatError(f"Expected accessor {index} of type {' or '.join(kinds)}, got {kind[:20]!r}.")
        count = whole(entry, "count", below=2**31)
        dtype = self._component(entry)
        if "bufferView" in entry:
            raw = self._elements(entry, count, dtype, WIDTHS[kind]).astype(np.float64)
        else:
            if count > 2**16:
                raise FormatError(f"Expected accessor {index} to have a bufferView, got {count} zeros.")
            raw = np.zeros((count, WIDTHS[kind]))
        if "sparse" in entry:
            self._patch(child(entry, "sparse"), raw, dtype)
        if entry.get("normalized") is True and dtype.kind in "iu":
            raw = np.maximum(raw / np.iinfo(dtype).max, -1.0)
        if not (np.abs(raw) < _LIMIT).all():
            raise FormatError(f"Expected finite values in accessor {index}, got NaN, infinity or more than {_LIMIT:g}.")
        return raw

    @staticmethod
    def _component(entry: Json) -> np.dtype[Any]:
        component = entry.get("componentType")
        if not isinstance(component, int) or component not in COMPONENTS:
            raise FormatError(f"Expected a componentType out of {list(COMPONENTS)}, got {component!r:.40}.")
        return np.dtype(COMPONENTS[component])

    def _elements(self, entry: Json, count: int, dtype: np.dtype[Any], width: int) -> np.ndarray:
        """View (count, width) of the bytes that an accessor, or part of a sparse one, points to."""
        views = self.objects("bufferViews")
        view = views[whole(entry, "bufferView", below=len(views))]
        if "EXT_meshopt_compression" in (view.get("extensions") or {}):
            raise FormatError(
                "Expected plain animation data, got meshopt compression. Decompress it with gltf-transform."
            )
        data = self.buffer(whole(view, "buffer", below=len(self.objects("buffers"))))
        start = whole(view, "byteOffset", below=2**40, default=0)
        length = whole(view, "byteLength", below=2**40)
        offset = whole(entry, "byteOffset", below=2**40, default=0)
        element = dtype.itemsize * width
        stride = whole(view, "byteStride", below=2**20, default=element) or element
        used = offset + stride * (count - 1) + element if count else offset
        if used > length or start + length > len(data):
            raise FormatError(
                f"Expected {used} bytes of a bufferView and {start + length} of its buffer, "
                f"got {length} and {len(data)}. The file may be cut short."
            )
        return np.ndarray((count, width), dtype, data, start + offset, (stride, dtype.itemsize))

    def _patch(self, sparse: Json, raw: Array, dtype: np.dtype[Any]) -> None:
        count = whole(sparse, "count", below=len(raw) + 1)
        indices, values = child(sparse, "indices"), child(sparse, "values")
        where = self._elements(indices, count, self._component(indices), 1)[:, 0].astype(np.int64)
        if count and where.max() >= len(raw):
            raise FormatError(f"Expected sparse indices from 0 to {len(raw) - 1}, got {where.max()}.")
        raw[where] = self._elements(values, count, dtype, raw.shape[1])


def load_document(path: Path) -> GltfDocument:
    """Read a .glb or .gltf file; what it really is decides, not its suffix. Raises FormatError, FileNotFoundError."""
    data = path.read_bytes()
    if not data:
        raise FormatError("Expected a glTF file, got an empty one. Export it again.")
    if is_glb(data):
        container = parse_glb(data)
        document = GltfDocument(container.document, container.binary, path.parent, container.chunks)
    elif data[:64].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        document = GltfDocument(parse_json(data.removeprefix(b"\xef\xbb\xbf")), None, path.parent)
    else:
        raise FormatError(f"Expected a GLB file or JSON, got bytes that begin with {data[:8]!r}. Check the suffix.")
    version = text(child(document.json, "asset"), "version", "")
    if not version.startswith("2."):
        raise FormatError(f"Expected glTF 2.0, got version {version[:20]!r}.")
    return document
