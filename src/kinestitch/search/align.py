"""Seams moved to where the steps of both sides meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import Timeline
from kinestitch.errors import ParameterError
from kinestitch.search.features import column_scales
from kinestitch.search.phase import Steps, find_steps
from kinestitch.search.price import Places, check_weights
from kinestitch.search.snap import Reach, cheapest, feet_of, moved_seams, within_reach
from kinestitch.solve.energy import joint_price
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.seam import SeamPlace

TOLERANCE = np.radians(10.0)
"""rad by which the phases at a seam may differ where that makes it cheaper."""


@dataclass(frozen=True, slots=True)
class Aligned:
    """A timeline whose seams were moved; by :func:`align_phase`.

    moves : (S − 1,) per seam by how many frames the end left of it and the start right of it have moved
    gaps_before, gaps_after : (S − 1,) rad, the right side's phase less the left one's, within half a turn; NaN where a
        side makes no steps
    before, after : E* in rad² of all seams together (Eq. 17)
    separable : E* in rad² after, the sum of the seams, each as if it were alone (Eq. 18)
    """

    timeline: Timeline
    moves: tuple[tuple[int, int], ...]
    gaps_before: tuple[float, ...]
    gaps_after: tuple[float, ...]
    before: float
    after: float
    separable: float


def align_phase(
    timeline: Timeline,
    clips: Mapping[str, Motion],
    seconds: float,
    *,
    snap: float | None = None,
    tolerance: float = float(TOLERANCE),
    weights: ArrayLike | str | None = None,
    contacts: bool = True,
) -> Aligned:
    """Move both sides of every seam between steps to the cheapest pair of places within `seconds` whose phases meet.

    snap : s; seams with a side that makes no steps move to the cheapest pair within this reach, and aligned ones may
        move that far too; left out, the former stay
    tolerance : rad by which the phases of a pair may differ; where none is that near, the nearest pair counts
    weights, contacts : as for :func:`price_map`

    What :func:`snap` says of segments between two seams, of jumps within one clip and of hard cuts holds here too.

    Raises ParameterError for a negative time or tolerance, and what placing raises.
    """
    for name, value in (("reach in seconds", seconds), ("reach in seconds", snap or 0.0), ("tolerance", tolerance)):
        if not (np.isfinite(value) and value >= 0):
            raise ParameterError(f"Expected a {name} ≥ 0, got {value}.")
    placed = place_timeline(timeline, clips)
    steps = find_steps(timeline, clips)
    chosen = check_weights(placed.skeleton, weights)
    scales = column_scales(placed.skeleton, chosen)
    feet = feet_of(placed) if contacts and chosen is not None else {}
    before = phase_gaps(timeline, steps)
    reach = round(max(seconds, snap or 0.0) * timeline.fps)
    moves, separable = [(0, 0)] * len(timeline.seams), 0.0
    for seam in placed.seams:
        if seam.stiffness == 0:
            continue
        if np.isfinite(before[seam.index]):
            found = meeting(placed, seam, within_reach(placed, seam, reach, scales, feet), steps, tolerance)
        elif snap is not None:
            found = within_reach(placed, seam, round(snap * timeline.fps), scales, feet)
        else:
            found = within_reach(placed, seam, 0, scales)
        entry = cheapest(found)
        moves[seam.index] = found.moves(entry)
        separable += found.price(entry)
    moved = moved_seams(timeline, moves)
    after = joint_price(place_timeline(moved, clips))
    gaps = phase_gaps(moved, steps)
    return Aligned(moved, tuple(moves), before, gaps, joint_price(placed), after, separable)


def phase_gaps(timeline: Timeline, steps: Steps) -> tuple[float, ...]:
    """By how much the phase jumps at each seam (S − 1,), in rad within half a turn: what the right side has at the seam
    less what the left one has, both halfway between their two frames; NaN where a side makes no steps (Eq. 38).
    """
    gaps = []
    for left, right in zip(timeline.segments, timeline.segments[1:], strict=False):
        out = place_phases(timeline, left.clip, (left.range.stop, left.range.stop), steps)
        into = place_phases(timeline, right.clip, (right.range.start, right.range.start), steps)
        gaps.append(float(wrapped(into - out)[0]))
    return tuple(gaps)


def place_phases(timeline: Timeline, clip: str, places: Places, steps: Steps) -> Array:
    """The phase in rad at the places from the first to the last, each between the frame before it and its own."""
    frames = np.arange(places[0] - 1, places[1] + 1)
    phases = steps.at(timeline.clip(clip), frames / timeline.fps, 1.0 / timeline.fps)
    return np.asarray((phases[:-1] + phases[1:]) / 2)


def wrapped(angles: Array) -> Array:
    """Angles within half a turn."""
    return np.asarray((angles + np.pi) % (2 * np.pi) - np.pi)


def meeting(placed: Placed, seam: SeamPlace, found: Reach, steps: Steps, tolerance: float) -> Reach:
    """The reach of a seam without the pairs whose phases do not meet."""
    left, right = placed.timeline.segments[seam.index : seam.index + 2]
    out = place_phases(placed.timeline, left.clip, found.outs, steps)
    into = place_phases(placed.timeline, right.clip, found.intos, steps)
    apart = np.abs(wrapped(into - out[:, None]))
    apart = np.where(np.isfinite(apart) & np.isfinite(found.costs), apart, np.inf)
    bound = max(tolerance, float(apart.min()))
    return replace(found, costs=np.where(apart <= bound, found.costs, np.inf))
