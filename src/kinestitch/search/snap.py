"""Seams moved to the cheapest place near by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.pieces import with_bounds
from kinestitch.edit.timeline import FrameRange, Segment, Timeline
from kinestitch.errors import ParameterError
from kinestitch.search.features import column_scales, place_features
from kinestitch.search.price import Places, check_weights, squared_distances
from kinestitch.solve.energy import joint_price
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.seam import SeamPlace

_LEAST_JUMP = 0.5  # of a jump within one clip; the cheapest place of all would be none


@dataclass(frozen=True, slots=True)
class Snapped:
    """A timeline whose seams were moved; by :func:`snap`.

    moves : (S − 1,) per seam by how many frames the end left of it and the start right of it have moved
    before, after : E* in rad² of all seams together (Eq. 17)
    """

    timeline: Timeline
    moves: tuple[tuple[int, int], ...]
    before: float
    after: float


def snap(
    timeline: Timeline, clips: Mapping[str, Motion], seconds: float, *, weights: ArrayLike | str | None = None
) -> Snapped:
    """Move both sides of every seam to the cheapest pair of places within `seconds`.

    A segment with seams at both ends gives at most half its frames to each, so that none is lost, and a jump within
    one clip keeps its direction and at least half its size, so that no deletion is undone. Hard cuts stay. Every frame
    that a side moves makes the result one frame longer or shorter.

    weights : as for :func:`price_map`. Raises ParameterError for a negative time, and what placing raises.
    """
    if not (np.isfinite(seconds) and seconds >= 0):
        raise ParameterError(f"Expected a reach in seconds ≥ 0, got {seconds}.")
    placed = place_timeline(timeline, clips)
    chosen = check_weights(placed.skeleton, weights)
    scales = column_scales(placed.skeleton, chosen)
    moves = [(0, 0)] * len(timeline.seams)
    for seam in placed.seams:
        if seam.stiffness > 0:
            found = within_reach(placed, seam, round(seconds * timeline.fps), scales)
            moves[seam.index] = cheapest(placed, seam, found)
    moved = moved_seams(timeline, moves)
    after = joint_price(place_timeline(moved, clips))
    return Snapped(moved, tuple(moves), joint_price(placed), after)


@dataclass(frozen=True, eq=False, slots=True)
class Reach:
    """Where the two sides of a seam may go, and what that costs; by :func:`within_reach`.

    outs, intos : first and last place of the left clip's end and of the right clip's start
    costs : one row a place of the left, one column a place of the right; infinite where that may not be
    """

    outs: Places
    intos: Places
    costs: Array


def within_reach(placed: Placed, seam: SeamPlace, reach: int, scales: Array) -> Reach:
    """What a seam costs wherever its sides may go within `reach` frames."""
    left, right = placed.timeline.segments[seam.index : seam.index + 2]
    a, b = placed.sources[left.clip], placed.sources[right.clip]
    first, last = seam.index == 0, seam.index == len(placed.timeline.seams) - 1
    spare = len(left) - 1 if first else (len(left) - 1) // 2
    outs = (left.range.stop - min(reach, spare), min(left.range.stop + reach, a.frames))
    spare = len(right) - 1 if last else (len(right) - 1) // 2
    intos = (max(right.range.start - reach, 0), right.range.start + min(reach, spare))
    skip = (min(outs[0], 1), min(intos[0], 1))  # the frame before the first place is there but at a clip's start
    features = place_features([_around(a, outs), _around(b, intos)], seam.stiffness)
    p = features[0][skip[0] : skip[0] + outs[1] - outs[0] + 1]
    q = features[1][skip[1] : skip[1] + intos[1] - intos[0] + 1]
    costs = squared_distances(p * scales, q * scales)
    if left.clip == right.clip:
        jump = right.range.start - left.range.stop
        there = np.arange(intos[0], intos[1] + 1) - np.arange(outs[0], outs[1] + 1)[:, None]
        costs = np.where(there * np.sign(jump) >= _LEAST_JUMP * abs(jump), costs, np.inf)
    return Reach(outs, intos, costs)


def cheapest(placed: Placed, seam: SeamPlace, found: Reach) -> tuple[int, int]:
    """By how many frames the two sides of a seam have to move to the least cost there is."""
    left, right = placed.timeline.segments[seam.index : seam.index + 2]
    i, j = (int(k) for k in np.unravel_index(np.argmin(found.costs), found.costs.shape))
    return found.outs[0] + i - left.range.stop, found.intos[0] + j - right.range.start


def _around(motion: Motion, places: Places) -> Motion:
    """The frames that stand before and after these places."""
    here = slice(max(places[0] - 1, 0), places[1] + 1)
    return replace(motion, rotations=motion.rotations[here], translations=motion.translations[here])


def moved_seams(timeline: Timeline, moves: Sequence[tuple[int, int]]) -> Timeline:
    """The timeline with both sides of each seam moved by this many frames."""
    starts = [0, *(into for _, into in moves)]
    stops = [*(out for out, _ in moves), 0]
    segments = tuple(
        Segment(segment.clip, FrameRange(segment.range.start + start, segment.range.stop + stop))
        for segment, start, stop in zip(timeline.segments, starts, stops, strict=True)
    )
    return with_bounds(timeline, segments)
