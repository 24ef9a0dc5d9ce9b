"""Decimal numbers out of text, many at once: the same doubles as Python's ``float``, several times faster.

A number of at most eight digits before and eight behind the point is an integer below 2^53 over a power of ten, and
IEEE division of the two rounds correctly. Such numbers are put together eight digits at a time, all tokens of a text in
parallel; everything else (exponents, more digits) goes through ``float`` one by one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array

_ALLOWED = b"0123456789+-.eE \t\n\r\v\f"
_PLUS, _MINUS, _POINT, _ZERO, _SPACE = b"+-.0 "
_EXACT = 2**53
_POWERS = 10 ** np.arange(9, dtype=np.uint64)
_KEEP = np.array([(2**64 - 1) ^ (2 ** (8 * (8 - count)) - 1) for count in range(9)], dtype=np.uint64)


def parse_decimals(text: bytes) -> tuple[Array, NDArray[np.intp]]:
    """All numbers (N,) of a text of numbers and white space, and where in the text each begins (N,).

    Raises ValueError at the first token that is no decimal number (``nan`` and ``inf`` are none); use :func:`bad_token`
    to find it.
    """
    if text.translate(None, _ALLOWED):
        raise ValueError("not a decimal number")
    padded = b" " * 8 + text + b" "
    bytes_ = np.frombuffer(padded, dtype=np.uint8)
    gaps = np.flatnonzero(bytes_ <= _SPACE)
    starts, ends = gaps[:-1] + 1, gaps[1:]
    empty = starts == ends
    if empty.any():
        starts, ends = starts[~empty], ends[~empty]
    first = bytes_[starts]
    signed = (first == _MINUS) | (first == _PLUS)
    digits = starts + signed
    point = _points(bytes_, starts, digits, ends)
    whole, fraction = point - digits, np.maximum(ends - point - 1, 0)
    slow = (whole > 8) | (fraction > 8) | (whole + fraction == 0)
    is_digit = (bytes_ - np.uint8(_ZERO)) < 10
    if np.count_nonzero(is_digit) != int((whole + fraction).sum()):
        slow[_with_odd_bytes(~is_digit & (bytes_ > _SPACE), starts, signed, point, ends)] = True
    np.minimum(whole, 8, out=whole)
    np.minimum(fraction, 8, out=fraction)
    windows = np.ndarray((len(padded) - 7,), "<u8", padded, 0, (1,))
    number = _digits_before(windows, point, whole) * _POWERS[fraction] + _digits_before(windows, ends, fraction)
    slow |= number >= _EXACT
    values = number.astype(np.float64) / _POWERS[fraction].astype(np.float64)
    values *= np.where(first == _MINUS, -1.0, 1.0)
    for index in np.flatnonzero(slow):
        values[index] = float(padded[starts[index] : ends[index]])
    return values, starts - 8


def _points(
    bytes_: NDArray[np.uint8], starts: NDArray[np.intp], digits: NDArray[np.intp], ends: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Where each token's first decimal point stands; its end where it has none."""
    points = np.flatnonzero(bytes_ == _POINT)
    if len(points) == len(starts) and bool(((points >= digits) & (points < ends)).all()):
        return points
    found = ends.copy()
    owner = np.searchsorted(starts, points, side="right") - 1
    found[owner[::-1]] = points[::-1]
    return np.maximum(found, digits)


def _with_odd_bytes(
    odd: NDArray[np.bool_],
    starts: NDArray[np.intp],
    signed: NDArray[np.bool_],
    point: NDArray[np.intp],
    ends: NDArray[np.intp],
) -> NDArray[np.intp]:
    """Tokens that hold more than digits, one leading sign and one point."""
    odd[starts[signed]] = False
    odd[point[point < ends]] = False
    return np.searchsorted(starts, np.flatnonzero(odd), side="right") - 1


def _digits_before(windows: NDArray[np.uint64], stop: NDArray[np.intp], count: NDArray[np.intp]) -> NDArray[np.uint64]:
    """The number that the `count` ≤ 8 digits in front of `stop` spell: pairs, then fours, then all eight at once."""
    number = windows[stop - 8]
    number &= _KEEP[count]
    for mask, factor, shift in (
        (0x0F0F0F0F0F0F0F0F, 2561, 8),
        (0x00FF00FF00FF00FF, 6553601, 16),
        (0x0000FFFF0000FFFF, 42949672960001, 32),
    ):
        number &= np.uint64(mask)
        number *= np.uint64(factor)
        number >>= np.uint64(shift)
    return number


def bad_token(text: bytes) -> tuple[int, int, str] | None:
    """Line (from 0), place in the line (from 0) and spelling of the first token that is no finite decimal number."""
    for line, row in enumerate(text.split(b"\n")):
        for place, token in enumerate(row.split()):
            try:
                good = not token.translate(None, _ALLOWED) and np.isfinite(float(token))
            except ValueError:
                good = False
            if not good:
                return line, place, token[:24].decode("latin-1")
    return None
