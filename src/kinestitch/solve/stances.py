"""Where feet have to be around seams: the stances of the placed sources, and what becomes of those that a seam cuts.

A stance of a source stays where it was placed. Where one source stands until the seam and the other from it on, and not
far off, both stances become one: it stands between the two places, nearer to the one it stands on longer. Where holding
a foot would throw it harder than a leg can, it is released earlier, or put down later: so it gets the time for a step.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence, Set
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import (
    Array,
    quat_about_axis,
    quat_conjugate,
    quat_multiply,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.solve.contacts import SHORTEST, Mask, runs
from kinestitch.solve.laplacian import second_difference
from kinestitch.solve.seam import Cluster
from kinestitch.solve.swings import GROUND, carry_over

_APART, _UNEVEN, _TURNED = 0.35, 0.1, np.radians(50.0)  # leg lengths and rad within which two stances can become one
_PAUSE = 0.15  # s that may lie between them
_LONGER = 0.1  # s that a foot has to stand longer if they do not
_HARDEST = 18.0  # leg lengths per s², what holding a foot may add to its acceleration
_ALIKE = 1e-9  # share by which two peaks may differ and still count as equally high
_TIE = 2  # frames by which the peak may be nearer to one stance than to the other, and both still give way


@dataclass(frozen=True, eq=False, slots=True)
class FootPath:
    """A foot in the world, frame by frame.

    pivot : (F, 3) m, the toe joint, or the ankle on a rig without toes; turn : (F, 4) world_from_foot
    """

    pivot: Array
    turn: Array


@dataclass(frozen=True, slots=True)
class Setting:
    """What is the same for both feet of a window.

    bounded : whether frames come before the window and after it, which shall stay as they are
    leg : m; blend : frames in which an offset dies away
    """

    cluster: Cluster
    bounded: tuple[bool, bool]
    fps: float
    leg: float
    blend: float

    @property
    def hard(self) -> tuple[int, ...]:
        """Frames of the window before which there is a hard cut."""
        places = zip(self.cluster.seams, self.cluster.local_frames, strict=True)
        return tuple(frame for seam, frame in places if seam.stiffness == 0)

    def known(self, stands: Mask) -> Mask:
        """The frames (n,) whose offset is known: those of the stances, and those beside which the window ends."""
        known = stands.copy()
        first, last = (
            max(2, held) if bounded else 0 for held, bounded in zip(self.cluster.held, self.bounded, strict=True)
        )
        known[:first] = True
        known[len(known) - last :] = True
        return known


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
    """Two pieces on the two sides of a seam that become one.

    yaw, shift : by how much the later one lies off the earlier; rolls : the share of what they differ by besides that
    the earlier one takes: all where only its heel is up, so that no heel that stands is rolled
    """

    left: _Piece
    right: _Piece
    yaw: float
    shift: Array
    rolls: float


@dataclass(frozen=True, eq=False, slots=True)
class Stances:
    """Where a foot stands if nothing speaks against it; made by :func:`settled` only.

    path : the foot, right in the frames in which it stands; pieces, links : of which the stances are made
    pause : frames that may lie between two stances that became one
    """

    path: FootPath
    pieces: tuple[_Piece, ...]
    links: tuple[_Link, ...]
    pause: int

    def evened(self, values: Array) -> Array:
        """Values (n, C) whose step where two stances became one is shared out to both sides."""
        out = values.copy()
        for link in self.links:
            frames, shares = _shares(link, self.pause)
            out[frames] += shares * (values[link.right.start] - values[link.left.stop - 1])
        return out


def settled(placed: FootPath, held: Mask, flat: Mask, setting: Setting, *, apart: Collection[int] = ()) -> Stances:
    """The stances of a window, those made one that can be.

    placed : the foot in the placed sources; held, flat : (n,) frames in which it stands in them, and its heel does
    apart : first frames of contacts that are not to become one with the one before
    """
    pause = max(2, round(_PAUSE * setting.fps))
    pieces = _pieces(held, setting, pause)
    links = _links(placed, pieces, flat, setting, pause, apart)
    _settle(pieces, links)
    path = FootPath(placed.pivot.copy(), placed.turn.copy())
    for piece in pieces:
        here = slice(piece.start, piece.stop)
        path.pivot[here, GROUND] += piece.shift
        path.turn[here] = quat_multiply(quat_about_axis(1, piece.yaw), path.turn[here])
    for link in links:
        a, b = link.left.stop - 1, link.right.start
        frames, shares = _shares(link, pause)
        roll = quat_to_rotvec(quat_multiply(path.turn[b], quat_conjugate(path.turn[a])))
        path.pivot[frames] += shares * (path.pivot[b] - path.pivot[a])
        path.turn[frames] = quat_multiply(rotvec_to_quat(shares * roll), path.turn[frames])
    return Stances(path, tuple(pieces), tuple(links), pause)


def wanted_stances(
    placed: FootPath, solved: FootPath, held: tuple[Mask, Mask], far: Callable[[FootPath], Mask], setting: Setting
) -> tuple[Stances, Mask]:
    """The stances of a window and the frames (n,) in which the foot stands.

    placed, solved : the foot in the placed sources, and in the result
    held : (n,) frames in which it stands in the sources, and in which its heel does
    far : in which frames (n,) a foot that stood on a path would be out of its leg's reach

    Two contacts stay apart where the foot then stands for longer, by more than it takes to see.
    """

    def tried(apart: Collection[int]) -> tuple[Stances, Mask]:
        found = settled(placed, *held, setting, apart=apart)
        return found, released(found, found.path.pivot - solved.pivot, far(found.path), setting)

    apart: tuple[int, ...] = ()
    best = tried(apart)
    for link in best[0].links:
        other = tried((*apart, link.right.start))
        if other[1].sum() > best[1].sum() + _LONGER * setting.fps:
            best, apart = other, (*apart, link.right.start)
    return best


def _pieces(held: Mask, setting: Setting, pause: int) -> list[_Piece]:
    """The contacts, cut at seams; those that last beyond the window, or nearly, are fixed."""
    first, last = (pause if bounded else 0 for bounded in setting.bounded)
    pieces = []
    for start, stop in runs(held):
        bounds = [start, *(m for m in setting.cluster.local_frames if start < m < stop), stop]
        for a, b in pairwise(bounds):
            pieces.append(_Piece(a, b, a < first or b > len(held) - last, 0.0, np.zeros(2)))
    return pieces


def _links(
    placed: FootPath, pieces: Sequence[_Piece], flat: Mask, setting: Setting, pause: int, apart: Collection[int]
) -> list[_Link]:
    """The neighbours over a seam that can become one stance."""
    links: list[_Link] = []
    seams = set(setting.cluster.local_frames) - set(setting.hard)
    tied = False  # whether the chain so far holds a piece that cannot be moved
    for left, right in pairwise(pieces):
        a, b = left.stop - 1, right.start
        tied = tied or left.fixed
        gap = placed.pivot[b] - placed.pivot[a]
        yaw = _yaw(quat_multiply(placed.turn[b], quat_conjugate(placed.turn[a])))
        near = (
            any(a < m <= b for m in seams)
            and b not in apart
            and b - a <= pause
            and np.hypot(*gap[list(GROUND)]) < _APART * setting.leg
            and abs(gap[1]) < _UNEVEN * setting.leg
            and abs(yaw) < _TURNED
            and not (tied and right.fixed)
        )
        tied = tied and near
        if near:
            links.append(_Link(left, right, yaw, gap[list(GROUND)], (1.0 + flat[b] - flat[a]) / 2))
    return links


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


def _shares(link: _Link, pause: int) -> tuple[NDArray[np.intp], Array]:
    """The frames near a link's seam, and how much of what its pieces differ by is added there, (n, 1): before the seam
    with the sign of the difference, after it with the other.
    """
    a, b = link.left.stop - 1, link.right.start
    spans = [max(1, round(2 * part * pause)) for part in (link.rolls, 1 - link.rolls)]
    before = np.arange(max(link.left.start, a - spans[0] + 1), a + 1)
    after = np.arange(b, min(link.right.stop, b + spans[1]))
    rise, fall = _ease(1 - (a - before) / spans[0]), _ease(1 - (after - b) / spans[1])
    shares = np.concatenate([link.rolls * rise, (link.rolls - 1) * fall])
    return np.concatenate([before, after]), shares[:, None]


def _ease(share: Array) -> Array:
    """0 to 1 without a step in value or slope."""
    s = np.clip(share, 0.0, 1.0)
    return s * s * (3 - 2 * s)


def released(stances: Stances, offsets: Array, far: Mask, setting: Setting) -> Mask:
    """The frames (n,) in which a foot stands, once every stance has given way where it asks too much (Eq. 26).

    offsets : (n, 3) m from the solved way to the stances; far : (n,) frames in which they are out of the leg's reach

    A stance does not begin or end out of reach, and holding it does not throw the foot too hard before or after it.
    """
    pieces = [replace(piece) for piece in stances.pieces]
    renewed = {id(old): new for old, new in zip(stances.pieces, pieces, strict=True)}
    joined = {(id(renewed[id(link.left)]), id(renewed[id(link.right)])) for link in stances.links}
    linked = {piece for pair in joined for piece in pair}
    least = [_least(piece, id(piece) in linked, len(offsets), setting.fps) for piece in pieces]
    for piece in pieces:
        _come_near(piece, far, joined)
    hardest, frames = _HARDEST * setting.leg / setting.fps**2, max(1, round(setting.fps / 60))
    while True:
        alive = [piece for piece, shortest in zip(pieces, least, strict=True) if piece.stop - piece.start >= shortest]
        stands = np.zeros(len(offsets), dtype=bool)
        for piece in alive:
            stands[piece.start : piece.stop] = True
        known = setting.known(stands)
        carried = carry_over(np.where(stands[:, None], offsets, 0.0), known, setting.blend, breaks=setting.hard)
        strength = np.linalg.norm(second_difference(carried), axis=1)
        moved = False
        for left, right in pairwise([None, *alive, None]):
            if (id(left), id(right)) not in joined:
                moved |= _give_way(left, right, strength, hardest, frames)
        if not moved:
            return stands


def _come_near(piece: _Piece, far: Mask, joined: Set[tuple[int, int]]) -> None:
    """Shorten a stance, in place, as long as it begins or ends out of reach; not where it goes on over a seam."""
    if not any(id(piece) == left for left, _ in joined):
        while piece.stop > piece.start and far[piece.stop - 1]:
            piece.stop -= 1
    if not any(id(piece) == right for _, right in joined):
        while piece.start < piece.stop and far[piece.start]:
            piece.start += 1


def _least(piece: _Piece, linked: bool, count: int, fps: float) -> int:
    """Frames below which what is left of a contact is no stance; one that a clip's end cuts short may be shorter."""
    shortest = max(1, round(SHORTEST * fps))
    if linked:
        return 1
    return min(shortest, piece.stop - piece.start) if piece.start == 0 or piece.stop == count else shortest


def _give_way(left: _Piece | None, right: _Piece | None, strength: Array, hardest: float, frames: int) -> bool:
    """Shorten, in place, the one of two neighbouring stances that is nearer to where a foot would be thrown too hard
    between them; whether there was such a place.
    """
    start = 0 if left is None else left.stop - 1
    stop = len(strength) if right is None else right.start + 1
    between = strength[start:stop]
    if (left is None and right is None) or between.max(initial=0.0) <= hardest:
        return False
    peaks = np.flatnonzero(between >= (1 - _ALIKE) * between.max())
    peak = start + (int(peaks[0]) + int(peaks[-1])) / 2
    nearer = 0.0 if left is None else 1.0 if right is None else (right.start - peak) - (peak - start)
    if left is not None and (right is None or nearer >= -_TIE):
        left.stop -= frames
    if right is not None and (left is None or nearer <= _TIE):
        right.start += frames
    return True
