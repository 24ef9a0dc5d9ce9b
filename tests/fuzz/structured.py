"""Damage behind the container: a file is taken apart, one of its values is changed, and it is put together again."""

from __future__ import annotations

import io
import json
import random
import warnings
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from kinestitch.errors import KinestitchError
from kinestitch.files.fbx.binary import is_binary, parse_binary, serialise
from kinestitch.files.fbx.nodes import Document, Node, PackedArray
from kinestitch.files.glb import is_glb, parse_glb, serialise_glb

NUMBERS = (0, 1, -1, 2, 3, 255, 10**6, 2**31 - 1, 2**31, 2**53, 1e-300, 0.5, -1e9, 1e30, 1e300)
RUBBISH = (None, True, False, "", "x", [], [[]], [0], {}, {"a": 1}, [1, 2, 3, 4], "VEC3", "MAT4", *NUMBERS)


def amass(rng: random.Random, data: bytes) -> bytes:
    """An array of the archive changed, left out, renamed or doubled; checksums stay right."""
    import numpy as np

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {entry.filename: archive.read(entry) for entry in archive.infolist() if entry.file_size < 1 << 20}
    except Exception:  # no archive any more
        return data
    if not members:
        return data
    name = rng.choice(sorted(members))
    action = rng.random()
    if action < 0.15:
        del members[name]
    elif action < 0.3:
        members[rng.choice(("J.npy", "joints.npy", "poses.npy", "fps.npy", "x"))] = members[name]
    elif action < 0.5:
        content = bytearray(members[name])
        for _ in range(min(len(content), rng.choice((1, 3)))):
            content[rng.randrange(min(len(content), rng.choice((128, 1 << 20))))] = rng.randrange(256)
        members[name] = bytes(content)
    else:
        shape = rng.choice(((), (0,), (1,), (3,), (2, 3), (2, 72), (24, 3), (2, 24, 3), (1, 0), (52, 3), (2, 156)))
        value = rng.choice((0.0, 0.5, 1e9, 1e300, float("nan"), float("inf"), -1.0))
        kind = rng.choice(("<f8", "<f4", ">f8", "<f2", "<c16", "|b1", "<i4", "<U3", "|S2", "<M8[s]", "<u8"))
        buffer = io.BytesIO()
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            array = np.full(shape, value)
            np.save(buffer, array.astype("<i8").astype(kind) if kind == "<M8[s]" else array.astype(kind))
        members[name] = buffer.getvalue()
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
        for member, content in members.items():
            archive.writestr(zipfile.ZipInfo(member), content)
    return out.getvalue()


def glb(rng: random.Random, data: bytes) -> bytes:
    """A member of the JSON replaced, left out or doubled; lengths stay right."""
    try:
        container = parse_glb(data) if is_glb(data) else None
        document = json.loads(json.dumps(container.document)) if container else json.loads(data)
    except (KinestitchError, ValueError, RecursionError):
        return data
    if not isinstance(document, dict):
        return data
    _change_json(rng, document)
    try:
        if container is None:
            return json.dumps(document).encode()
        return b"".join(serialise_glb(document, [(kind, [chunk]) for kind, chunk in container.chunks]))
    except ValueError:
        return data


def _places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, below in items:
        yield (*path, key)
        yield from _places(below, (*path, key))


def _change_json(rng: random.Random, document: dict[str, Any]) -> None:
    places = list(_places(document))
    if not places:
        return
    *above, key = rng.choice(places)
    holder: Any = document
    for step in above:
        holder = holder[step]
    action = rng.random()
    if action < 0.2:
        del holder[key]
    elif action < 0.35 and isinstance(holder, list):
        holder[key:key] = [holder[key]] * rng.choice((1, 1, 30))
    elif action < 0.6:
        other: Any = document
        for step in rng.choice(places):
            other = other[step]
        holder[key] = json.loads(json.dumps(other))
    elif isinstance(holder[key], int) and not isinstance(holder[key], bool) and action < 0.8:
        holder[key] += rng.choice((-1, 1, 2, 100))
    else:
        holder[key] = rng.choice(RUBBISH)


def fbx(rng: random.Random, data: bytes) -> bytes:
    """A node left out, doubled or moved, or one of its properties changed; offsets stay right."""
    if not is_binary(data):
        return data
    try:
        document = parse_binary(data)
    except KinestitchError:
        return data
    every = list(_nodes(document.nodes))
    if not every:
        return data
    target, other = rng.choice(every), rng.choice(every)
    try:
        return serialise(_with(document, target, _changed(rng, target, other)))
    except Exception:  # a tree that no file can hold
        return data


def _nodes(nodes: tuple[Node, ...]) -> Iterator[Node]:
    for node in nodes:
        yield node
        yield from _nodes(node.children)


def _with(document: Document, target: Node, new: tuple[Node, ...]) -> Document:
    def walk(nodes: tuple[Node, ...]) -> tuple[Node, ...]:
        out: list[Node] = []
        for node in nodes:
            if node is target:
                out += new
            else:
                below = walk(node.children)
                out.append(node if below == node.children else replace(node, children=below))
        return tuple(out)

    return replace(document, nodes=walk(document.nodes))


def _changed(rng: random.Random, target: Node, other: Node) -> tuple[Node, ...]:
    action = rng.random()
    if action < 0.1:
        return ()
    if action < 0.2:
        return (target,) * rng.choice((2, 2, 30))
    if action < 0.3:
        return (target, other)
    if action < 0.4 or not target.properties:
        return (replace(target, name=other.name),)
    place = rng.randrange(len(target.properties))
    values = list(target.properties)
    values[place] = _value(rng, target.properties[place], other)
    return (replace(target, properties=tuple(values)),)


def _value(rng: random.Random, value: Any, other: Node) -> Any:
    same = [entry for entry in other.properties if type(entry) is type(value)]
    if same and rng.random() < 0.5:
        return rng.choice(same)
    if isinstance(value, PackedArray):
        return _array(rng, value)
    if isinstance(value, str):
        return rng.choice(("", "x", value[::-1], value + "\x00\x01Model", "LimbNode", "mixamo.com", "\udcff"))
    if isinstance(value, int):
        return rng.choice((0, 1, -1, 5, 2**31 - 1, -(2**31), value + 1))
    return rng.choice((0.0, -1.0, float("nan"), float("inf"), 1e300, 1e-300)) if isinstance(value, float) else value


def _array(rng: random.Random, array: PackedArray) -> PackedArray:
    if rng.random() < 0.3:
        return replace(array, count=rng.choice((0, 1, array.count + 1, 2 * array.count, 2**31 - 1)))
    values = array.values().copy()
    if not len(values):
        return array
    strange = (0, -1, 1, 2**31 - 1) if values.dtype.kind in "iu" else (float("nan"), float("inf"), 1e30, -1e300, 0.0)
    if rng.random() < 0.5:
        values[rng.randrange(len(values))] = _fitting(rng.choice(strange), values.dtype)
    else:
        rng.shuffle(values)
    return PackedArray.of(values, array.code)


def _fitting(value: float, dtype: Any) -> Any:
    import numpy as np

    with np.errstate(all="ignore"):
        return np.array(value).astype(dtype)
