"""Where feet have to be around seams: the stances of the placed sources, and what becomes of those that a seam cuts.

A stance of a source stays where it was placed. Where one source stands until the seam and the other from it on, both
stances become one: it stands between the two places, nearer to the one it stands on longer, and the foot reaches it
and leaves it in its swings. A stance that lasts beyond the seam's window cannot be moved. Where the two places lie too
far apart to be one, or neither can be moved, the foot gets time around the seam to go from one to the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from kinestitch.core.rotation import (
    Array,
    quat_about_axis,
    quat_conjugate,
    quat_multiply,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.solve.contacts import Mask, runs
from kinestitch.solve.seam import Cluster

GROUND = (0, 2)
_APART, _TURNED = 0.35, np.radians(50.0)  # leg lengths and rad within which two stances can become one
_SINK = 2.5e-3  # m
_LIFT, _HIGHEST = 0.2, 0.09  # of a step's length, leg lengths


@dataclass(frozen=True, eq=False, slots=True)
class FootPath:
    """A foot in the world, frame by frame.

    pivot : (F, 3) m, the toe joint, or the ankle on a rig without toes; turn : (F, 4) world_from_foot
    """

    pivot: Array
    turn: Array


@dataclass(frozen=True, eq=False, slots=True)
class Wanted:
    """What is wanted of a foot.

    path : where it stands; stands : (n,) the frames in which it does; low : (n,) m, the height under which its pivot
    must not come: the floor, or the source's own height where it is lower, and on a step over a seam an arc above it
    """

    path: FootPath
    stands: Mask
    low: Array


@dataclass(slots=True)
class _Piece:
    """A contact [start, stop) within one segment, with its turn and shift on the ground."""

    start: int
    stop: int
    fixed: bool
    yaw: float
    shift: Array

    @property
    def weight(self) -> float:
        return 1e9 if self.fixed else float(self.stop - self.start)


@dataclass(frozen=True, slots=True)
class _Link:
    """Two pieces on the two sides of the seam before frame `seam`, with no time for a step between them, and by how
    much the later one lies off the earlier.
    """

    left: _Piece
    right: _Piece
    seam: int
    yaw: float
    shift: Array


def wanted_path(
    cut: FootPath, held: Mask, cluster: Cluster, *, bounded: tuple[bool, bool], leg: float, blend: int, shortest: int
) -> Wanted:
    """Where a foot stands on the frames of a cluster's window, and in which frames (n,) it does.

    cut : of the placed sources, window's frames only; held : (n,) frames in which it stands in them
    bounded : whether frames come before the window and after it, which shall stay as they are
    leg : m; blend : frames in which a foot passes from one place to the other; shortest : frames, of a stance
    """
    seams, count = cluster.local_frames, len(held)
    pieces = _pieces(held, seams, (blend if bounded[0] else 0, blend if bounded[1] else 0))
    links, tears = _links(cut, pieces, seams, leg, blend)
    _settle(pieces, links)
    lift = np.zeros(count)
    for tear in tears:
        _step(tear, lift, leg, blend)
    joined = {id(piece) for link in links for piece in (link.left, link.right)}
    stands = np.zeros(count, dtype=bool)
    pivot, turn = cut.pivot.copy(), cut.turn.copy()
    for piece in pieces:
        long = piece.stop - piece.start >= shortest or piece.start == 0 or piece.stop == count
        if piece.start < piece.stop and (long or id(piece) in joined):
            here = slice(piece.start, piece.stop)
            stands[here] = True
            pivot[here, GROUND] += piece.shift
            turn[here] = quat_multiply(quat_about_axis(1, piece.yaw), turn[here])
    for link in links:
        _even_out(FootPath(pivot, turn), link, blend)
    floor = float(np.median(cut.pivot[held, 1]))
    return Wanted(FootPath(pivot, turn), stands, np.minimum(cut.pivot[:, 1], floor) + lift)


def _pieces(held: Mask, seams: Sequence[int], margins: tuple[int, int]) -> list[_Piece]:
    """The contacts, cut at seams; those within a margin of the window's start or end are fixed."""
    pieces = []
    for start, stop in runs(held):
        bounds = [start, *(m for m in seams if start < m < stop), stop]
        for a, b in pairwise(bounds):
            pieces.append(_Piece(a, b, a < margins[0] or b > len(held) - margins[1], 0.0, np.zeros(2)))
    return pieces


def _links(
    cut: FootPath, pieces: Sequence[_Piece], seams: Sequence[int], leg: float, blend: int
) -> tuple[list[_Link], list[_Link]]:
    """Neighbours over a seam without time for a step between them: those that become one stance, and the others."""
    links: list[_Link] = []
    tears: list[_Link] = []
    tied = False  # whether the chain so far holds a piece that cannot be moved
    for left, right in pairwise(pieces):
        a, b = left.stop - 1, right.start
        between = [m for m in seams if a < m <= b]
        tied = tied or left.fixed
        if not between or b - a > 2 * blend:
            tied = False
            continue
        gap = cut.pivot[b, GROUND] - cut.pivot[a, GROUND]
        yaw = _yaw(quat_multiply(cut.turn[b], quat_conjugate(cut.turn[a])))
        near = (
            b - a <= blend and np.linalg.norm(gap) < _APART * leg and abs(yaw) < _TURNED and not (tied and right.fixed)
        )
        tied = tied and bool(near)
        (links if near else tears).append(_Link(left, right, between[0], yaw, gap))
    return links, tears


def _yaw(turn: Array) -> float:
    """The turn about Y nearest to a rotation (4,), in (−π, π]."""
    angle = 2 * np.arctan2(turn[1], turn[3])
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def _settle(pieces: Sequence[_Piece], links: Sequence[_Link]) -> None:
    """Give the pieces of every chain of links the turn and shift by which they meet, the longer ones the smaller."""
    after = {id(link.left): link for link in links}
    later = {id(link.right) for link in links}
    for first in pieces:
        if id(first) in later or id(first) not in after:
            continue
        chain, offsets = [first], [np.zeros(3)]
        while id(chain[-1]) in after:
            link = after[id(chain[-1])]
            chain.append(link.right)
            offsets.append(offsets[-1] + [link.yaw, *link.shift])
        mean = np.average(offsets, axis=0, weights=[piece.weight for piece in chain])
        for piece, offset in zip(chain, offsets, strict=True):
            if not piece.fixed:
                piece.yaw, piece.shift = float(mean[0] - offset[0]), mean[1:] - offset[1:]


def _step(tear: _Link, lift: Array, leg: float, blend: int) -> None:
    """Shorten both pieces, in place, by the time of a step around their seam, and lift the foot meanwhile."""
    tear.left.stop = max(min(tear.left.stop, tear.seam - blend), tear.left.start)
    tear.right.start = min(max(tear.right.start, tear.seam + blend), tear.right.stop)
    frames = np.arange(max(0, tear.seam - blend), min(len(lift), tear.seam + blend))
    share = (frames - tear.seam + blend) / (2 * blend)
    height = min(_LIFT * float(np.linalg.norm(tear.shift)), _HIGHEST * leg)
    lift[frames] += height * 16 * (share * (1 - share)) ** 2


def _even_out(path: FootPath, link: _Link, blend: int) -> None:
    """Share out what two linked pieces still differ by at their seam (height and roll), in place."""
    a, b = link.left.stop - 1, link.right.start
    rise = path.pivot[b] - path.pivot[a]
    roll = quat_to_rotvec(quat_multiply(path.turn[b], quat_conjugate(path.turn[a])))
    for frames, sign in (
        (np.arange(max(link.left.start, a - blend + 1), a + 1), 0.5),
        (np.arange(b, min(link.right.stop, b + blend)), -0.5),
    ):
        away = np.where(frames <= a, a - frames, frames - b) / blend
        share = sign * ease(1 - away)[:, None]
        path.pivot[frames] += share * rise
        path.turn[frames] = quat_multiply(rotvec_to_quat(share * roll), path.turn[frames])


def ease(share: Array) -> Array:
    """0 to 1 without a step in value or slope."""
    s = np.clip(share, 0.0, 1.0)
    return s * s * (3 - 2 * s)


def raised(heights: Array, low: Array) -> Array:
    """What has to be added to heights (n,) m so that they do not come below `low` (n,) m by more than 2.5 mm, without a
    kink.
    """
    missing = np.maximum(low - heights, 0.0)
    return np.where(missing < 2 * _SINK, missing**2 / (4 * _SINK), missing - _SINK)


def carry_over(offsets: Array, stands: Mask, blend: int) -> Array:
    """Offsets (n, C), known where a foot stands, carried over to the frames around: each end goes to 0 within `blend`
    frames, or as far as the next stance, with the slope it has.
    """
    out = np.where(stands[:, None], offsets, 0.0)
    for start, stop in runs(~stands):
        frames = np.arange(start, stop)
        for edge, inner, step in ((start - 1, start - 2, 1), (stop, stop + 1, -1)):
            if not 0 <= edge < len(stands):
                continue
            span = min(blend, stop - start + 1)
            known = 0 <= inner < len(stands) and bool(stands[inner])
            slope = offsets[edge] - offsets[inner] if known else np.zeros(offsets.shape[1])
            s = np.clip((frames - edge) * step / span, 0.0, 1.0)[:, None]
            out[frames] += ease(1 - s) * offsets[edge] + span * s * (1 - s) ** 2 * slope
    return out
