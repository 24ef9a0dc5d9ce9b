"""C3D files of SGI machines in the byte order of everybody else: the same file, every number turned round."""

from __future__ import annotations

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
    _swap_parameters(turned, start + 4, min(start + max(data[start + 2], 1) * _BLOCK, len(data)))
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


def _swap_parameters(data: bytearray, place: int, end: int) -> None:
    """Walk the chain of groups and parameters; each names its length in letters and the way to the next.

    The last one's way may lead anywhere, out of the section too: there the chain is ended.
    """
    while place + 2 <= end:
        letters = data[place] if data[place] < 128 else 256 - data[place]
        way = place + 2 + letters
        if letters == 0 or way + 4 > end:
            return
        _swap(data, way, way + 2, 2)
        step = int.from_bytes(data[way : way + 2], "little", signed=True)
        if 0 < data[place + 1] < 128:
            _swap_values(data, way + 2)
        if step <= 0 or way + step + 2 > end:
            data[way : way + 2] = bytes(2)
            return
        place = way + step


def _swap_values(data: bytearray, place: int) -> None:
    size = data[place] if data[place] < 128 else 256 - data[place]
    count = 1
    dimensions = data[place + 1]
    for dimension in data[place + 2 : place + 2 + dimensions]:
        count *= dimension
    first = place + 2 + dimensions
    if first + count * size > len(data):
        raise FormatError("Expected parameters inside of a C3D file, got some beyond its end.")
    if size in (2, 4):
        _swap(data, first, first + count * size, size)
