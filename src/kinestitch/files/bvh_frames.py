"""The lower half of a BVH file: rows of channel values become translations and rotations, a block of rows at a time."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array, euler_to_quat, quat_about_axis, quat_identity, quat_multiply
from kinestitch.errors import FormatError, KinestitchWarning
from kinestitch.files.bvh_hierarchy import Node
from kinestitch.files.decimals import bad_token, parse_decimals

BLOCK = 1 << 17
"""Bytes of text parsed at a time: everything in between then fits a processor's cache."""

_LIMIT = 1e12


@dataclass(frozen=True, slots=True)
class Columns:
    """Where each channel of a row belongs.

    position : (joints, axes, columns) of all position channels
    rotations : for each sequence of axes, e.g. "ZXY", its joints (N,) and columns (N, len(axes))
    still : joints without a rotation channel
    """

    count: int
    labels: tuple[str, ...]
    position: tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]
    rotations: tuple[tuple[str, NDArray[np.intp], NDArray[np.intp]], ...]
    still: list[int]


def columns_of(nodes: list[Node]) -> Columns:
    """The meaning of each column of the rows of a file with these joints."""
    labels: list[str] = []
    position: list[tuple[int, int, int]] = []
    groups: dict[str, list[tuple[int, list[int]]]] = {}
    for joint, node in enumerate(nodes):
        start = len(labels)
        labels.extend(f"{node.name} {channel}" for channel in node.channels)
        turns = [(c, start + i) for i, c in enumerate(node.channels) if c.endswith("rotation")]
        position.extend(
            (joint, "XYZ".index(c[0]), start + i) for i, c in enumerate(node.channels) if c.endswith("position")
        )
        groups.setdefault("".join(c[0] for c, _ in turns), []).append((joint, [column for _, column in turns]))
    where = np.array(position, dtype=np.intp).reshape(-1, 3).T
    rotations = tuple(
        (axes, np.array([joint for joint, _ in members]), np.array([columns for _, columns in members], dtype=np.intp))
        for axes, members in groups.items()
        if axes
    )
    still = [joint for joint, _ in groups.get("", [])]
    return Columns(len(labels), tuple(labels), (where[0], where[1], where[2]), rotations, still)


def _turn(angles: Array, axes: str) -> Array:
    """Quaternions (..., 4) of angles (..., n) rad about the axes, first axis outermost."""
    if len(set(axes)) == len(axes) == 3:
        return euler_to_quat(angles, axes)
    q = quat_about_axis("XYZ".index(axes[0]), angles[..., 0])
    for i, letter in enumerate(axes[1:], start=1):
        q = quat_multiply(q, quat_about_axis("XYZ".index(letter), angles[..., i]))
    return q


def read_frames(
    data: bytes, start: int, frames: int, columns: Columns, *, offsets: Array, unit: float
) -> tuple[Array, Array]:
    """Translations (F, J, 3) m and rotations (F, J, 4) of the rows that begin at `start` of the file's bytes.

    frames : rows that the file declares; further ones are left out with one warning
    offsets : (J, 3) m, the translation of joints and axes without a position channel

    Raises FormatError with the line number for a row of another length, a token that is no finite number, missing rows.
    """
    possible = (len(data) - start) // (2 * columns.count) + 1
    if frames > possible:
        raise FormatError(f"Expected the {frames} frames that the file declares, got room for at most {possible}.")
    translations = np.empty((frames, len(offsets), 3))
    translations[:] = offsets
    rotations = np.empty((frames, len(offsets), 4))
    rotations[:, columns.still] = quat_identity()
    line = data.count(b"\n", 0, start) + 1
    done = 0
    while start < len(data) and done < frames:
        block = data[start : _block_end(data, start, columns.count)]
        if len(block) // (2 * columns.count) >= frames - done:
            block = _first_rows(block, frames - done)
        rows = _rows(block, line, columns)
        _fill(rows, columns, unit, translations[done : done + len(rows)], rotations[done : done + len(rows)])
        done += len(rows)
        line += block.count(b"\n")
        start += len(block)
    if done < frames:
        raise FormatError(
            f"Line {line}: expected {frames} frames as the file declares, got {done}. "
            f"The file may be cut short; if not, correct it to 'Frames: {done}'."
        )
    extra = sum(1 for row in data[start:].split(b"\n") if row.strip())
    if extra:
        warnings.warn(
            KinestitchWarning(f"{extra} row(s) after the {frames} frames that the file declares left out."),
            stacklevel=4,
        )
    return translations, rotations


def _block_end(data: bytes, start: int, values: int) -> int:
    """End of a block of whole lines of about BLOCK bytes; a line may be longer."""
    newline = data.rfind(b"\n", start, start + BLOCK) if start + BLOCK < len(data) else -1
    if newline < 0:
        newline = data.find(b"\n", start + BLOCK, start + BLOCK + 32 * values)
    return newline + 1 if newline >= 0 else min(len(data), start + BLOCK + 32 * values)


def _first_rows(block: bytes, count: int) -> bytes:
    """The part of the block that holds its first `count` rows that are not blank."""
    length = 0
    for row in block.split(b"\n"):
        count -= bool(row.strip())
        length += len(row) + 1
        if count == 0:
            break
    return block[:length]


def _rows(block: bytes, line: int, columns: Columns) -> Array:
    """Values (rows, channels) of a block of whole lines."""
    try:
        values, starts = parse_decimals(block)
        good = bool(np.isfinite(values).all())
    except ValueError:
        good = False
    if not good:
        below, place, token = bad_token(block) or (0, 0, "")
        label = columns.labels[place] if place < columns.count else f"value {place + 1}"
        raise FormatError(f"Line {line + below}: expected a number for {label}, got {token!r}. Export it again.")
    newlines = np.flatnonzero(np.frombuffer(block, dtype=np.uint8) == ord("\n"))
    counts = np.diff(np.searchsorted(starts, newlines), prepend=0, append=len(values))
    wrong = np.flatnonzero((counts != 0) & (counts != columns.count))
    if len(wrong):
        at = int(wrong[0])
        raise FormatError(
            f"Line {line + at}: expected {columns.count} channel values, got {counts[at]}. "
            "The file may be cut short; export it again."
        )
    return values.reshape(-1, columns.count)


def _fill(rows: Array, columns: Columns, unit: float, translations: Array, rotations: Array) -> None:
    joints, axes, where = columns.position
    if len(where):
        moves = rows[:, where]
        if np.abs(moves).max(initial=0.0) > _LIMIT:
            raise FormatError(f"Expected positions below {_LIMIT:g}, got {np.abs(moves).max():g}.")
        translations[:, joints, axes] = moves * unit
    for letters, members, turns in columns.rotations:
        q = _turn(np.radians(rows[:, turns]), letters)
        if members[-1] - members[0] == len(members) - 1:
            rotations[:, members[0] : members[-1] + 1] = q  # much faster than by index
        else:
            rotations[:, members] = q
