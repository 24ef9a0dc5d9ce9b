"""How a motion or a recording crosses a pipe: a length, a JSON head, and the arrays as they are; nothing is run."""

from __future__ import annotations

import json
import struct
from typing import IO, Any

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.recording import Recording
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton

_LENGTH = struct.Struct("<Q")
_SKELETON = ("offsets", "rest", "tips")
_MOTION = ("translations", "rotations")
_RECORDING = ("markers", "analog")


def send(stream: IO[bytes], head: bytes, blobs: list[bytes]) -> None:
    """Write a head and any blobs."""
    stream.write(_LENGTH.pack(len(blobs)))
    for piece in (head, *blobs):
        stream.write(_LENGTH.pack(len(piece)))
        stream.write(piece)
    stream.flush()


def receive(stream: IO[bytes], limit: int) -> tuple[dict[str, Any], list[bytes]]:
    """Read what :func:`send` wrote; raises EOFError at its end, ValueError for anything else or more than `limit`."""
    (count,) = _LENGTH.unpack(_exactly(stream, _LENGTH.size))
    if count > 16:
        raise ValueError("too many pieces")
    pieces = []
    for _ in range(count + 1):
        (size,) = _LENGTH.unpack(_exactly(stream, _LENGTH.size))
        if size > limit:
            raise ValueError("too large a piece")
        pieces.append(_exactly(stream, size))
    head = json.loads(pieces[0])
    if not isinstance(head, dict):
        raise ValueError("no head")
    return head, pieces[1:]


def _exactly(stream: IO[bytes], size: int) -> bytes:
    data = stream.read(size)
    if len(data) < size:
        raise EOFError
    return data


def message_of(value: Motion | Recording) -> tuple[dict[str, Any], list[bytes]]:
    """Head and arrays of a value."""
    if isinstance(value, Motion):
        rig = value.skeleton
        head: dict[str, Any] = {"names": rig.names, "parents": rig.parents, "fps": value.fps, "name": value.name}
        arrays = [getattr(rig, field) for field in _SKELETON] + [getattr(value, field) for field in _MOTION]
    else:
        fields = ("marker_names", "rate", "analog_names", "analog_units", "analog_rate", "name")
        head = {field: getattr(value, field) for field in fields}
        arrays = [getattr(value, field) for field in _RECORDING]
    head["shapes"] = [array.shape for array in arrays]
    return head, [np.ascontiguousarray(array).tobytes() for array in arrays]


def value_of(head: dict[str, Any], blobs: list[bytes]) -> Motion | Recording:
    """The value of a message, built anew so that all its checks run."""
    shapes = head.pop("shapes")
    arrays = [_array(blob, shape) for blob, shape in zip(blobs, shapes, strict=True)]
    head.pop("warnings", None)
    if "parents" in head:
        rig = Skeleton(tuple(head["names"]), tuple(head["parents"]), *arrays[:3])
        translations, rotations = arrays[3:]
        return Motion(rig, translations, rotations, head["fps"], head["name"])
    markers, analog = arrays
    return Recording(markers=markers, analog=analog, **head)


def _array(blob: bytes, shape: list[int]) -> Array:
    return np.frombuffer(blob, dtype=np.float64).reshape(shape)
