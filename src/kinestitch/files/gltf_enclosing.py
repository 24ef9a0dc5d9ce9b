"""A changed glTF document as a file again: new bytes behind the old ones, .glb or .gltf, in this folder or another."""

from __future__ import annotations

import base64
import mimetypes
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from kinestitch.errors import KinestitchWarning
from kinestitch.files.glb import BINARY_CHUNK, json_bytes, serialise_glb
from kinestitch.files.gltf_document import GltfDocument, Json, text


def data_uri(data: bytes | memoryview, kind: str = "application/octet-stream") -> str:
    """The bytes as a URI that holds them."""
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def with_bytes(document: GltfDocument, lists: Json, added: bytes, path: Path, like: Path) -> Iterator[bytes]:
    """The bytes of a file `path` that holds the document read from `like`, with some lists changed and bytes added.

    lists : new values of members of the document
    added : what a new last bufferView holds; the lists count on it

    A GLB gets the new bytes behind its binary chunk, a .gltf a buffer of its own. In another folder, files beside the
    document are taken in. Raises FormatError for buffers that are not there, OutputError beyond 4 GiB.
    """
    new: Json = {**document.json, **lists}
    buffers = list(document.objects("buffers"))
    if path.resolve().parent != like.resolve().parent:
        buffers = [_inside(document, index) for index in range(len(buffers))]
        new |= {"images": _images_inside(document)} if "images" in new else {}
    views = list(document.objects("bufferViews"))
    new |= {"bufferViews": views, "buffers": buffers}
    if path.suffix.lower() == ".gltf":
        views.append({"buffer": len(buffers), "byteOffset": 0, "byteLength": len(added)})
        if buffers and "uri" not in buffers[0] and document.binary is not None:
            buffers[0] = {**buffers[0], "uri": data_uri(document.binary), "byteLength": len(document.binary)}
        buffers.append({"byteLength": len(added), "uri": data_uri(added)})
        return iter([json_bytes(new)])
    base = document.buffer(0) if buffers else b""
    start = len(base) + -len(base) % 4
    views.append({"buffer": 0, "byteOffset": start, "byteLength": len(added)})
    entry = {key: value for key, value in buffers[0].items() if key != "uri"} if buffers else {}
    buffers[:1] = [entry | {"byteLength": start + len(added)}]
    others: list[tuple[int, Any]] = [(kind, [data]) for kind, data in document.chunks if data is not document.binary]
    return serialise_glb(new, [(BINARY_CHUNK, [base, bytes(start - len(base)), added]), *others])


def _inside(document: GltfDocument, index: int) -> Json:
    """The buffer's entry with the bytes of a file beside the document taken in."""
    entry = document.objects("buffers")[index]
    uri = text(entry, "uri", "")
    return {**entry, "uri": data_uri(document.buffer(index))} if uri and not uri.startswith("data:") else entry


def _images_inside(document: GltfDocument) -> list[Json]:
    """The images' entries with the bytes of pictures beside the document taken in."""
    entries, lost = [], 0
    for entry in document.objects("images"):
        uri = text(entry, "uri", "")
        kind = mimetypes.guess_type(uri)[0] or ""
        if not uri or uri.startswith("data:"):
            entries.append(entry)
            continue
        picture = _bytes_beside(document.folder, unquote(uri)) if kind.startswith("image/") else None
        entries.append(entry if picture is None else {**entry, "uri": data_uri(picture, kind)})
        lost += picture is None
    if lost:
        warnings.warn(KinestitchWarning(f"{lost} picture(s) beside the file could not be taken along."), stacklevel=6)
    return entries


def _bytes_beside(folder: Path, name: str) -> bytes | None:
    """Bytes of a file named relative to the document; None where there is none."""
    if "\0" in name or Path(name).is_absolute():
        return None
    try:
        return (folder / name).read_bytes()
    except OSError:
        return None
