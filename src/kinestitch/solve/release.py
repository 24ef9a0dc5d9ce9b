"""How long a foot stands: stances give way, from their ends, where holding them would throw a leg too hard."""

from __future__ import annotations

from collections.abc import Callable, Collection, Set
from dataclasses import replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.solve.contacts import SHORTEST, Mask
from kinestitch.solve.stances import FootPath, Link, Piece, Setting, Stances, settled, shares_of

_LONGER = 0.1  # s that a foot has to stand longer if they do not
_ALIKE = 1e-9  # share by which two peaks may differ and still count as equally high
_TIE = 2  # frames by which the peak may be nearer to one stance than to the other, and both still give way


End = tuple[int, int]  # a piece's identity, and 0 for its start or 1 for its stop
Joined = dict[tuple[int, int], Link]  # by the identities of the two pieces that became one


class Thrown(Protocol):
    """A leg whose foot can stand in some places."""

    def excess(self, stands: Mask) -> Array:
        """How hard the leg is thrown in each frame (n,) if the foot stands in some (n,): 1 is as hard as may be."""
        ...


def wanted_stances(
    placed: FootPath,
    on: Callable[[Stances], Thrown],
    held: tuple[Mask, Mask],
    far: Callable[[FootPath], Mask],
    setting: Setting,
) -> tuple[Stances, Mask]:
    """The stances of a window and the frames (n,) in which the foot stands.

    placed : the foot in the placed sources; on : what standing on some stances takes
    held : (n,) frames in which it stands in the sources, and in which its heel does
    far : in which frames (n,) a foot that stood on a path would be out of its leg's reach

    Two contacts stay apart where the foot then stands for longer, by more than it takes to see.
    """

    def tried(apart: Collection[int]) -> tuple[Stances, Mask]:
        found = settled(placed, *held, setting, apart=apart)
        return found, released(found, on(found), far(found.path), setting)

    apart: tuple[int, ...] = ()
    best = tried(apart)
    for link in best[0].links:
        other = tried((*apart, link.right.start))
        if other[1].sum() > best[1].sum() + _LONGER * setting.fps:
            best, apart = other, (*apart, link.right.start)
    return best


def released(stances: Stances, leg: Thrown, far: Mask, setting: Setting) -> Mask:
    """The frames (n,) in which a foot stands, once every stance has given way where it asks too much (Eq. 26).

    far : (n,) frames in which the stances are out of the leg's reach

    A stance does not begin or end out of reach, and holding it does not throw the leg too hard before or after it. Two
    that became one part again where the way from one to the other would.
    """
    pieces = [replace(piece) for piece in stances.pieces]
    renewed = {id(old): new for old, new in zip(stances.pieces, pieces, strict=True)}
    joined = {(id(renewed[id(link.left)]), id(renewed[id(link.right)])): link for link in stances.links}
    least = [_least(piece, len(far), setting.fps) for piece in pieces]
    frames = max(1, round(setting.fps / 60))
    while True:
        alive = _alive(pieces, least, far, joined)
        stands = np.zeros(len(far), dtype=bool)
        for piece in alive:
            stands[piece.start : piece.stop] = True
        ends = _giving_way(alive, joined, leg.excess(stands), stances.pause)
        if not ends:
            return stands
        for left, right in list(joined):
            if (left, 1) in ends or (right, 0) in ends:
                del joined[left, right]
        for piece in alive:
            piece.start += frames if (id(piece), 0) in ends else 0
            piece.stop -= frames if (id(piece), 1) in ends else 0


def _giving_way(alive: list[Piece], joined: Joined, strength: Array, pause: int) -> set[End]:
    """The ends of pieces that are to give way, so that a leg is thrown less hard."""
    ends: set[End] = set()
    for piece in alive:
        ends |= _within(piece, strength)
    for left, right in pairwise([None, *alive, None]):
        link = joined.get((id(left), id(right)))
        if link is None or left is None or right is None:
            ends |= _between(left, right, strength)
        elif _torn(link, left, right, strength, pause):
            ends |= {(id(left), 1), (id(right), 0)}
    return ends


def _alive(pieces: list[Piece], least: list[int], far: Mask, joined: Joined) -> list[Piece]:
    """The pieces that are still long enough, in reach at both ends and joined, in place, to none that is not."""
    while True:
        for piece in pieces:
            _come_near(piece, far, joined.keys())
        linked = {identity for pair in joined for identity in pair}
        alive = [
            piece
            for piece, shortest in zip(pieces, least, strict=True)
            if piece.stop - piece.start >= (1 if id(piece) in linked else shortest)
        ]
        lone = joined.keys() - set(pairwise(map(id, alive)))
        if not lone:
            return alive
        for pair in lone:
            del joined[pair]


def _torn(link: Link, left: Piece, right: Piece, strength: Array, pause: int) -> bool:
    """Whether the way from one piece to the other, over what may lie between them, throws the leg too hard."""
    frames = shares_of(link, pause)[0]
    return bool(strength[max(frames[0], left.start) : min(frames[-1] + 1, right.stop)].max() > 1.0)


def _within(piece: Piece, strength: Array) -> set[End]:
    """The nearer end of a stance within which a leg is thrown too hard."""
    inner = strength[piece.start + 1 : piece.stop - 1]
    if inner.max(initial=0.0) <= 1.0:
        return set()
    peak = piece.start + 1 + _middle_peak(inner)
    return _nearer((id(piece), 0), (id(piece), 1), (piece.stop - 1 - peak) - (peak - piece.start))


def _nearer(before: End, after: End, more: float) -> set[End]:
    """The end before or the one after a peak that is `more` frames nearer to the first; both where it is hardly."""
    return ({before} if more >= -_TIE else set()) | ({after} if more <= _TIE else set())


def _middle_peak(values: Array) -> float:
    """The place of the largest value; amid the first and the last of some that are alike."""
    peaks = np.flatnonzero(values >= (1 - _ALIKE) * values.max())
    return (int(peaks[0]) + int(peaks[-1])) / 2


def _come_near(piece: Piece, far: Mask, joined: Set[tuple[int, int]]) -> None:
    """Shorten a stance, in place, as long as it begins or ends out of reach; not where it goes on over a seam."""
    if not any(id(piece) == left for left, _ in joined):
        while piece.stop > piece.start and far[piece.stop - 1]:
            piece.stop -= 1
    if not any(id(piece) == right for _, right in joined):
        while piece.start < piece.stop and far[piece.start]:
            piece.start += 1


def _least(piece: Piece, count: int, fps: float) -> int:
    """Frames below which what is left of a contact is no stance; one that a clip's end cuts short may be shorter."""
    shortest = max(1, round(SHORTEST * fps))
    return min(shortest, piece.stop - piece.start) if piece.start == 0 or piece.stop == count else shortest


def _between(left: Piece | None, right: Piece | None, strength: Array) -> set[End]:
    """The one of two neighbouring stances' ends that is nearer to where a leg is thrown too hard between them."""
    start = 0 if left is None else left.stop - 1
    stop = len(strength) if right is None else right.start + 1
    between = strength[start:stop]
    if between.max(initial=0.0) <= 1.0:
        return set()
    if left is None or right is None:
        return ({(id(left), 1)} if left else set()) | ({(id(right), 0)} if right else set())
    peak = start + _middle_peak(between)
    return _nearer((id(left), 1), (id(right), 0), (right.start - peak) - (peak - start))
