"""C3D as bytes: is the file whole, and SGI machines' files in everybody else's byte order.

The library that reads C3D trusts its files; what is plainly wrong is found here, before it crashes on it.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

import numpy as np

from kinestitch.errors import FormatError

MIPS, INTEL = 86, 84
"""Numbers that stand in a C3D file for the processor that wrote it."""

_BLOCK = 512
_MAGIC = 0x50
_WORDS_OF_HEADER = ((2, 12, 2), (12, 16, 4), (16, 20, 2), (20, 24, 4))
_EVENTS = slice(294, 512)


def processor(data: bytes) -> int:
    """Number of the processor that wrote a C3D file; raises FormatError for other files."""
    if len(data) < 2 * _BLOCK or data[1] != _MAGIC:
        got = "an empty file" if not data else "something else, or a file cut short"
        raise FormatError(f"Expected a C3D file, got {got}.")
    start = (data[0] - 1) * _BLOCK
    if data[0] < 2 or start + _BLOCK > len(data):
        raise FormatError(f"Expected parameters at block {data[0]} of a C3D file, got its end.")
    return data[start + 3]


def little_endian(data: bytes) -> bytes:
    """A big-endian C3D file (processor 86) as a little-endian one (84), without the header's events.

    Raises FormatError where parameters or data lie outside of the file.
    """
    turned = bytearray(data)
    for first, last, size in _WORDS_OF_HEADER:
        _swap(turned, first, last, size)
    turned[_EVENTS] = bytes(_EVENTS.stop - _EVENTS.start)
    start = (data[0] - 1) * _BLOCK
    turned[start + 3] = INTEL
    _swap_parameters(turned, start + 4, _end(data, start))
    first = (int.from_bytes(turned[16:18], "little") - 1) * _BLOCK
    if not 0 < first <= len(turned):
        raise FormatError(f"Expected the data of a C3D file inside of it, got its start at byte {first}.")
    scale = np.frombuffer(turned, "<f4", 1, 12)[0]
    _swap(turned, first, len(turned), 4 if scale < 0 else 2)
    return bytes(turned)


def _swap(data: bytearray, first: int, last: int, size: int) -> None:
    """Turn round every number of `size` bytes in a part of the file."""
    count = (last - first) // size
    numbers = np.frombuffer(bytes(data[first : first + count * size]), f">u{size}")
    data[first : first + count * size] = numbers.astype(f"<u{size}").tobytes()


def check_whole(data: bytes) -> None:
    """Look whether a little-endian file (Intel or DEC) has all the parameters and data that it speaks of.

    Raises FormatError.
    """
    start = (data[0] - 1) * _BLOCK
    for is_parameter, place in _chain(bytearray(data), start + 4, _end(data, start), turn=False):
        if is_parameter:
            _values(data, place)
    points, samples, first, last, _ = struct.unpack_from("<5H", data, 2)
    begin = (int.from_bytes(data[16:18], "little") - 1) * _BLOCK
    frames = last - first + 1
    if not 0 < begin <= len(data) or frames < 1:
        raise FormatError(f"Expected data of at least one frame in a C3D file, got {frames} at byte {begin}.")
    needed = begin + frames * (4 * points + samples) * 2
    if last < 0xFFFF and needed > len(data):
        raise FormatError(
            f"Expected {needed} bytes for {frames} frames of a C3D file, got {len(data)}. The file may be cut short."
        )


def _end(data: bytes, start: int) -> int:
    return min(start + max(data[start + 2], 1) * _BLOCK, len(data))


def _swap_parameters(data: bytearray, place: int, end: int) -> None:
    for group, values in _chain(data, place, end, turn=True):
        if group:
            _swap_values(data, values)


def _chain(data: bytearray, place: int, end: int, *, turn: bool) -> Iterator[tuple[bool, int]]:
    """Walk groups and parameters: whether it is a parameter, and where its values begin.

    Each names its length in letters and the way to the next; the last one's way may lead anywhere, out of the section
    too: there the chain is ended.

    turn : turn the ways round from big-endian, in place
    """
    while place + 2 <= end:
        letters = data[place] if data[place] < 128 else 256 - data[place]
        way = place + 2 + letters
        if letters == 0 or way + 4 > end:
            return
        if turn:
            _swap(data, way, way + 2, 2)
        step = int.from_bytes(data[way : way + 2], "little", signed=True)
        yield 0 < data[place + 1] < 128, way + 2
        if step <= 0 or way + step + 2 > end:
            data[way : way + 2] = bytes(2)
            return
        place = way + step


def _values(data: bytes | bytearray, place: int) -> tuple[int, int, int]:
    """Where a parameter's numbers begin and end, and how long each is; raises FormatError outside of the file."""
    size = data[place] if data[place] < 128 else 256 - data[place]
    dimensions = data[place + 1]
    first = place + 2 + dimensions
    last = first + math.prod(data[place + 2 : first]) * size
    if size not in (1, 2, 4) or dimensions > 7 or last > len(data):
        raise FormatError("Expected parameters inside of a C3D file, got one of another form or beyond its end.")
    return first, last, size


def _swap_values(data: bytearray, place: int) -> None:
    first, last, size = _values(data, place)
    if size > 1:
        _swap(data, first, last, size)
