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
from kinestitch.search.features import ROOT_COLUMNS, column_scales, place_features
from kinestitch.search.price import Places, check_weights, squared_distances
from kinestitch.search.standing import standing_columns, standing_feet
from kinestitch.solve.contacts import Mask
from kinestitch.solve.energy import joint_price
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.seam import SeamPlace

_LEAST_JUMP = 0.5  # of a jump within one clip; the cheapest place of all would be none


@dataclass(frozen=True, slots=True)
class Snapped:
    """A timeline whose seams were moved; by :func:`snap`.

    moves : (S − 1,) per seam by how many frames the end left of it and the start right of it have moved
    before, after : E* in rad² of all seams together, as they will be solved (Eq. 17)
    separable : E* in rad² after, as the search saw it: the sum of the seams, each as if it were alone (Eq. 18)
    """

    timeline: Timeline
    moves: tuple[tuple[int, int], ...]
    before: float
    after: float
    separable: float

    @property
    def difference(self) -> float:
        """By which share the price of all seams together differs from the separable one."""
        return self.after / self.separable - 1.0 if self.separable > 0 else 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Reach:
    """Where the two sides of a seam may go, and what that costs; by :func:`within_reach`.

    now : where they are; outs, intos : first and last place of the left clip's end and of the right clip's start
    costs : one row a place of the left, one column a place of the right; infinite where that may not be
    first, second : features of these places, whose squared distance is the separable price in rad² (Eq. 18)
    """

    now: Places
    outs: Places
    intos: Places
    costs: Array
    first: Array
    second: Array

    def moves(self, entry: tuple[int, int]) -> tuple[int, int]:
        """By how many frames the two sides have to move to an entry [i, j] of the costs."""
        return self.outs[0] + entry[0] - self.now[0], self.intos[0] + entry[1] - self.now[1]

    def price(self, entry: tuple[int, int]) -> float:
        """The separable price E* in rad² of an entry."""
        gap = self.first[entry[0]] - self.second[entry[1]]
        return float(gap @ gap)


def snap(
    timeline: Timeline,
    clips: Mapping[str, Motion],
    seconds: float,
    *,
    weights: ArrayLike | str | None = None,
    contacts: bool = True,
    keep_length: bool = False,
) -> Snapped:
    """Move both sides of every seam to the cheapest pair of places within `seconds`.

    A segment with seams at both ends gives at most half its frames to each, so that none is lost, and a jump within
    one clip keeps its direction and at least half its size, so that no deletion is undone. Hard cuts stay. Every frame
    that a side moves makes the result one frame longer or shorter.

    weights, contacts : as for :func:`price_map`
    keep_length : choose the moves whose sum leaves the result as long as it was, the cheapest such choice of all

    Raises ParameterError for a negative time, and what placing raises.
    """
    if not (np.isfinite(seconds) and seconds >= 0):
        raise ParameterError(f"Expected a reach in seconds ≥ 0, got {seconds}.")
    placed = place_timeline(timeline, clips)
    chosen = check_weights(placed.skeleton, weights)
    scales = column_scales(placed.skeleton, chosen)
    feet = feet_of(placed) if contacts and chosen is not None else {}
    reach = round(seconds * timeline.fps)
    free = [seam for seam in placed.seams if seam.stiffness > 0]
    found = [within_reach(placed, seam, reach, scales, feet) for seam in free]
    entries = as_long_as_before(found) if keep_length else [cheapest(one) for one in found]
    moves = [(0, 0)] * len(timeline.seams)
    for seam, one, entry in zip(free, found, entries, strict=True):
        moves[seam.index] = one.moves(entry)
    moved = moved_seams(timeline, moves)
    after = joint_price(place_timeline(moved, clips))
    separable = sum(one.price(entry) for one, entry in zip(found, entries, strict=True))
    return Snapped(moved, tuple(moves), joint_price(placed), after, separable)


def feet_of(placed: Placed) -> dict[str, Mask | None]:
    """When the feet of each clip stand (F, 2), as of :func:`standing_feet`."""
    return {key: standing_feet(motion) for key, motion in placed.sources.items()}


def within_reach(
    placed: Placed, seam: SeamPlace, reach: int, scales: Array, feet: Mapping[str, Mask | None] | None = None
) -> Reach:
    """What a seam costs wherever its sides may go within `reach` frames.

    feet : :func:`feet_of` the timeline, where stances shall count
    """
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
    rows = [p * scales, q * scales]
    held = [(feet or {}).get(segment.clip) for segment in (left, right)]
    if held[0] is not None and held[1] is not None:
        columns = standing_columns(held[0], held[1], seam.stiffness)
        here = columns[0][outs[0] : outs[1] + 1], columns[1][intos[0] : intos[1] + 1]
        rows = [np.hstack(pair) for pair in zip(rows, here, strict=True)]
    costs = squared_distances(rows[0], rows[1])
    if left.clip == right.clip:
        jump = right.range.start - left.range.stop
        there = np.arange(intos[0], intos[1] + 1) - np.arange(outs[0], outs[1] + 1)[:, None]
        costs = np.where(there * np.sign(jump) >= _LEAST_JUMP * abs(jump), costs, np.inf)
    now = left.range.stop, right.range.start
    return Reach(now, outs, intos, costs, p[:, :-ROOT_COLUMNS], q[:, :-ROOT_COLUMNS])


def cheapest(found: Reach) -> tuple[int, int]:
    """The entry [i, j] of least cost."""
    i, j = divmod(int(np.argmin(found.costs)), found.costs.shape[1])
    return i, j


def as_long_as_before(found: Sequence[Reach]) -> list[tuple[int, int]]:
    """The entries of least cost in all whose changes of length add up to nothing, one for each seam.

    Seam by seam, for every change so far the least cost that leads to it; then back from no change (Eq. 24).
    """
    steps: list[tuple[list[tuple[int, int]], Array]] = []
    zero, least = 0, np.zeros(1)  # entry k: what a change of k − zero frames costs so far
    for one in found:
        entries = _least_by_change(one.costs)
        sums = np.full((len(least) + len(entries) - 1, len(entries)), np.inf)
        for change, entry in enumerate(entries):
            sums[change : change + len(least), change] = least + one.costs[entry]
        steps.append((entries, sums.argmin(axis=1)))
        out, into = one.moves(entries[0])
        zero, least = zero - (out - into), sums.min(axis=1)
    chosen = []
    for entries, changes in reversed(steps):
        change = int(changes[zero])
        chosen.append(entries[change])
        zero -= change
    return chosen[::-1]


def _least_by_change(costs: Array) -> list[tuple[int, int]]:
    """The entry [i, j] of least cost on each diagonal i − j, the lowest diagonal first."""
    rows, columns = costs.shape
    found = []
    for diagonal in range(1 - columns, rows):
        least = int(np.argmin(np.diagonal(costs, -diagonal)))
        found.append((least + max(diagonal, 0), least - min(diagonal, 0)))
    return found


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
