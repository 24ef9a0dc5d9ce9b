"""Damage to files: a seed number tells what happens, so that a case can be made again."""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Callable, Sequence

LARGEST = 1 << 20
"""Bytes that a mutated file may have: duplicated blocks shall not grow without end."""

HUGE = (0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 1 << 40, (1 << 63) - 1, 1 << 63)
WORDS = (
    *(
        "nan",
        "inf",
        "-1",
        "0",
        "1",
        "1e308",
        "1e999",
        "%00",
        "1e-320",
        "-0",
        "99999999999999999999",
        "2147483647",
        "1e9",
        "3.5",
    ),
    *("{", "}", '"', "*", ":", ",", "", "\0", "é", "\n", "[", "]", "(", ")", "<", ">", "#", "@"),
)

Change = Callable[[random.Random, bytes], bytes]


def mutate(data: bytes, others: Sequence[bytes], seed: str, change: Change | None) -> bytes:
    """A damaged file: one to four changes.

    others : files to splice with; change : a mutation that knows the format
    """
    rng = random.Random(seed)
    for _ in range(rng.choice((1, 1, 1, 2, 2, 4))):
        if change is not None and rng.random() < 0.6:
            data = change(rng, data)
            continue
        kinds = (_flip, _bytes, _truncate, _double, _drop, _count, _splice)
        text = b"\0" not in data[:512]
        kind = rng.choice((_words, _lines, *kinds) if text else kinds)
        data = kind(rng, data, others)[:LARGEST]
    return data


def _place(rng: random.Random, data: bytes) -> tuple[int, int]:
    """Start and end of a block, mostly short."""
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + int(len(data) ** rng.random()))


def _flip(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    changed = bytearray(data)
    for _n in range(rng.choice((1, 1, 2, 8))):
        if changed:
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _bytes(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    start, stop = _place(rng, data)
    return data[:start] + rng.randbytes(min(stop - start, 64)) + data[start + min(stop - start, 64) :]


def _truncate(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _double(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    start, stop = _place(rng, data)
    at = rng.choice((stop, rng.randrange(len(data) + 1)))
    return data[:at] + data[start:stop] * rng.choice((1, 1, 2, 20)) + data[at:]


def _drop(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    start, stop = _place(rng, data)
    return data[:start] + data[stop:]


def _count(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    code = rng.choice(("<I", ">I", "<Q", "<H", "<d", "<f"))
    size = struct.calcsize(code)
    if len(data) < size:
        return data
    at = rng.randrange(len(data) - size + 1)
    at -= at % 4 * (rng.random() < 0.5)
    if code in ("<d", "<f"):
        new = struct.pack(code, rng.choice((float("nan"), float("inf"), -1e30, 1e38, 1e-40, 0.0)))
    else:
        new = struct.pack(code, rng.choice(HUGE) % (1 << 8 * size))
    return data[:at] + new + data[at + size :]


def _splice(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    other = rng.choice(others)
    start, stop = _place(rng, other)
    if rng.random() < 0.5:
        return data[: rng.randrange(len(data) + 1)] + other[start:]
    at = rng.randrange(len(data) + 1)
    return data[:at] + other[start:stop] + data[at + rng.choice((0, stop - start)) :]


def _words(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    """Words of a text replaced by strange ones, or by others of the text."""
    words = re.split(rb"([\s,:{}\[\]()]+)", data)
    places = [i for i in range(0, len(words), 2) if words[i]]
    for _n in range(rng.choice((1, 1, 3))):
        if places:
            other = rng.choice((rng.choice(WORDS).encode(), words[rng.choice(places)]))
            words[rng.choice(places)] = other
    return b"".join(words)


def _lines(rng: random.Random, data: bytes, _: Sequence[bytes]) -> bytes:
    """Lines of a text left out, said twice, or moved."""
    lines = data.split(b"\n")
    at, to = rng.randrange(len(lines)), rng.randrange(len(lines))
    line = lines[at]
    if rng.random() < 0.6:
        del lines[at]
    if rng.random() < 0.6:
        lines[to:to] = [line] * rng.choice((1, 1, 50))
    return b"\n".join(lines)
