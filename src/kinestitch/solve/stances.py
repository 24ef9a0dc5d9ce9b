"""Where feet have to be around seams: the stances of the placed sources, and what becomes of those that a seam cuts.

A stance of a source stays where it was placed. Where one source stands until the seam and the other from it on, and not
far off, both stances become one: it stands between the two places, nearer to the one it stands on longer. Where holding
a foot would throw it harder than a leg can, it is released earlier, or put down later: so it gets the time for a step.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
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
from kinestitch.solve.contacts import Mask, runs
from kinestitch.solve.seam import Cluster
from kinestitch.solve.swings import GROUND, ease

_APART, _UNEVEN, _TURNED = 0.35, 0.1, np.radians(50.0)  # leg lengths and rad within which two stances can become one
_PAUSE = 0.15  # s that may lie between them


@dataclass(frozen=True, eq=False, slots=True)
class FootStep:
    """What a foot does between two frames: (3,) m by which its pivot moves, (4,) by which it turns in the world."""

    shift: Array
    turn: Array


REST = FootStep(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))


@dataclass(frozen=True, eq=False, slots=True)
class FootPath:
    """A foot in the world, frame by frame.

    pivot : (F, 3) m, the toe joint, or the ankle on a rig without toes; turn : (F, 4) world_from_foot
    beside : by the frame m after a seam, where the left and the right source have the foot on frames m − n to
    m + n − 1, were there no seam; n is the frames that may lie between two stances that become one
    """

    pivot: Array
    turn: Array
    beside: Mapping[int, tuple[FootPath, FootPath]] = field(default_factory=dict)

    def step(self, start: int, stop: int) -> FootStep:
        """What the foot does from one frame to another."""
        turn = quat_multiply(self.turn[stop], quat_conjugate(self.turn[start]))
        return FootStep(self.pivot[stop] - self.pivot[start], turn)

    def own_step(self, start: int, stop: int, seams: Sequence[int]) -> FootStep:
        """What the sources do by themselves between two frames on the two sides of some seams, the less of both: one
        may lift there what stands in the other.
        """
        if not any(m in self.beside for m in seams):
            return REST
        sides = zip((seams[0], seams[-1]), (0, 1), strict=True)
        found = [(self.beside[m][side], m - len(self.beside[m][side].pivot) // 2) for m, side in sides]
        left, right = (path.step(start - first, stop - first) for path, first in found)
        calm = left if np.linalg.norm(left.shift) <= np.linalg.norm(right.shift) else right
        still = left if abs(left.turn[3]) >= abs(right.turn[3]) else right
        return FootStep(calm.shift, still.turn)

    def jump(self, start: int, stop: int, seams: Sequence[int]) -> FootStep:
        """What the path does between two frames on the two sides of some seams besides what its sources do."""
        step, own = self.step(start, stop), self.own_step(start, stop, seams)
        return FootStep(step.shift - own.shift, quat_multiply(step.turn, quat_conjugate(own.turn)))


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
    def pause(self) -> int:
        """Frames that may lie between two stances that become one."""
        return max(2, round(_PAUSE * self.fps))

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
class Piece:
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
class Link:
    """Two pieces on the two sides of a seam that become one.

    jump : by how much the later one lies off the earlier; rolls : the share of what they differ by besides yaw and
    shift that the earlier one takes: all where only its heel is up, so that no heel that stands is rolled
    """

    left: Piece
    right: Piece
    jump: FootStep
    rolls: float

    @property
    def offset(self) -> Array:
        """Yaw in rad and shift on the ground in m, (3,)."""
        return np.array([_yaw(self.jump.turn), *self.jump.shift[list(GROUND)]])

    @property
    def left_over(self) -> tuple[Array, Array]:
        """Shift (3,) m and turn (3,) rad that remain once both pieces are turned and shifted."""
        shift = self.jump.shift.copy()
        shift[list(GROUND)] += self.right.shift - self.left.shift
        before, after = (quat_about_axis(1, yaw) for yaw in (-self.left.yaw, self.right.yaw))
        return shift, quat_to_rotvec(quat_multiply(after, quat_multiply(self.jump.turn, before)))


@dataclass(frozen=True, eq=False, slots=True)
class Stances:
    """Where a foot stands if nothing speaks against it; made by :func:`settled` only.

    path : the foot, right in the frames in which it stands; pieces, links : of which the stances are made
    pause : frames that may lie between two stances that became one
    """

    path: FootPath
    pieces: tuple[Piece, ...]
    links: tuple[Link, ...]
    pause: int

    def evened(self, values: Array) -> Array:
        """Values (n, C) whose step where two stances became one is shared out to both sides."""
        out = values.copy()
        for link in self.links:
            frames, shares = shares_of(link, self.pause)
            out[frames] += shares * (values[link.right.start] - values[link.left.stop - 1])
        return out


def settled(placed: FootPath, held: Mask, flat: Mask, setting: Setting, *, apart: Collection[int] = ()) -> Stances:
    """The stances of a window, those made one that can be.

    placed : the foot in the placed sources; held, flat : (n,) frames in which it stands in them, and its heel does
    apart : first frames of contacts that are not to become one with the one before
    """
    pause = setting.pause
    pieces = _pieces(held, setting, pause)
    links = _links(placed, pieces, flat, setting, pause, apart)
    _settle(pieces, links)
    path = FootPath(placed.pivot.copy(), placed.turn.copy(), placed.beside)
    for piece in pieces:
        here = slice(piece.start, piece.stop)
        path.pivot[here, GROUND] += piece.shift
        path.turn[here] = quat_multiply(quat_about_axis(1, piece.yaw), path.turn[here])
    for link in links:
        frames, shares = shares_of(link, pause)
        shift, roll = link.left_over
        path.pivot[frames] += shares * shift
        path.turn[frames] = quat_multiply(rotvec_to_quat(shares * roll), path.turn[frames])
    return Stances(path, tuple(pieces), tuple(links), pause)


def _pieces(held: Mask, setting: Setting, pause: int) -> list[Piece]:
    """The contacts, cut at seams; those that last beyond the window, or nearly, are fixed."""
    first, last = (pause if bounded else 0 for bounded in setting.bounded)
    pieces = []
    for start, stop in runs(held):
        bounds = [start, *(m for m in setting.cluster.local_frames if start < m < stop), stop]
        for a, b in pairwise(bounds):
            pieces.append(Piece(a, b, a < first or b > len(held) - last, 0.0, np.zeros(2)))
    return pieces


def _links(
    placed: FootPath, pieces: Sequence[Piece], flat: Mask, setting: Setting, pause: int, apart: Collection[int]
) -> list[Link]:
    """The neighbours over a seam that can become one stance."""
    links: list[Link] = []
    seams = [m for m in setting.cluster.local_frames if m not in setting.hard]
    tied = False  # whether the chain so far holds a piece that cannot be moved
    for left, right in pairwise(pieces):
        a, b = left.stop - 1, right.start
        tied = tied or left.fixed
        between = [m for m in seams if a < m <= b]
        if not between or b in apart or b - a > pause:
            tied = False
            continue
        link = Link(left, right, placed.jump(a, b, between), (1.0 + flat[b] - flat[a]) / 2)
        near = (
            np.hypot(*link.offset[1:]) < _APART * setting.leg
            and abs(link.jump.shift[1]) < _UNEVEN * setting.leg
            and abs(link.offset[0]) < _TURNED
            and not (tied and right.fixed)
        )
        tied = tied and near
        if near:
            links.append(link)
    return links


def _yaw(turn: Array) -> float:
    """The turn about Y nearest to a rotation (4,), in [−π, π)."""
    angle = 2 * np.arctan2(turn[1], turn[3])
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def _settle(pieces: Sequence[Piece], links: Sequence[Link]) -> None:
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
            offsets.append(offsets[-1] + link.offset)
        mean = np.average(offsets, axis=0, weights=[piece.weight for piece in chain])
        for piece, offset in zip(chain, offsets, strict=True):
            if not piece.fixed:
                piece.yaw, piece.shift = float(mean[0] - offset[0]), mean[1:] - offset[1:]


def shares_of(link: Link, pause: int) -> tuple[NDArray[np.intp], Array]:
    """The frames near a link's seam, and how much of what its pieces differ by is added there, (n, 1): before the seam
    with the sign of the difference, after it with the other.
    """
    a, b = link.left.stop - 1, link.right.start
    spans = [max(1, round(4 * part * pause)) for part in (link.rolls, 1 - link.rolls)]
    before = np.arange(max(link.left.start, a - spans[0] + 1), a + 1)
    after = np.arange(b, min(link.right.stop, b + spans[1]))
    rise, fall = ease(1 - (a - before) / spans[0]), ease(1 - (after - b) / spans[1])
    shares = np.concatenate([link.rolls * rise, (link.rolls - 1) * fall])
    return np.concatenate([before, after]), shares[:, None]
