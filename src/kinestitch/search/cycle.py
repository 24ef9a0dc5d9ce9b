"""Which frames of a clip make the best cycle: where its end costs least to go over into its beginning."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import FrameRange, Seam
from kinestitch.errors import ParameterError, RangeError
from kinestitch.search.features import column_scales, place_features
from kinestitch.search.price import check_weights, squared_distances
from kinestitch.search.standing import standing_columns, standing_feet
from kinestitch.solve.loop import SHORTEST, around_seam, repeats_first_pose
from kinestitch.solve.seam import stiffness_at

_ALIKE, _NOTHING = 1.3, 1e-3  # of the least cost, and in its unit: among cycles so much alike the longest is taken
_BLOCK = 512  # rows of the map of costs that are there at a time


@dataclass(frozen=True, slots=True)
class Cycle:
    """Frames start … stop − 1 of a clip, which are to follow themselves.

    cost : of going from the last to the first of them, what the search minimised (Eq. 18 with weighted joints, Eq. 23)
    """

    start: int
    stop: int
    cost: float

    @property
    def frames(self) -> int:
        """Number of frames N of the cycle."""
        return self.stop - self.start


def best_cycle(
    motion: Motion,
    *,
    shortest: float | None = None,
    longest: float | None = None,
    stiffness: float | None = None,
    smoothing: float | None = None,
    weights: ArrayLike | str | None = None,
    contacts: bool = True,
) -> Cycle:
    """The frames whose end goes over into their beginning most cheaply, both ends free; of many alike, the longest.

    shortest, longest : s, half of the clip and all of it when left out
    stiffness, smoothing, weights, contacts : as for :func:`kinestitch.search.price.price_map`

    Where the body is on the ground and where it looks does not count, how fast it moves does. Raises RangeError where
    the clip holds no cycle of such a length.

    >>> from kinestitch.samples import sample
    >>> walk = sample("walk")  # three strides of 10/9 s
    >>> best_cycle(walk).frames, best_cycle(walk, shortest=1.0, longest=1.9).frames
    (200, 67)
    """
    value = stiffness_at(Seam(stiffness, smoothing), motion.fps)
    fewest, most = _lengths(motion, shortest, longest)
    ends = _whole(motion)
    out, into, around = _features(motion, ends, value, weights, contacts)
    costs, starts = _cheapest_by_length(out, into, fewest, most)
    for span, cost in zip(ends, around, strict=True):
        if fewest <= len(span) <= most and cost <= costs[len(span)]:
            costs[len(span)], starts[len(span)] = cost, span.start
    least = costs.min()
    frames = int(np.flatnonzero(costs <= _ALIKE * least + _NOTHING)[-1])
    start = int(starts[frames])
    return Cycle(start, start + frames, float(costs[frames]))


def whole_cycle(
    motion: Motion,
    *,
    stiffness: float | None = None,
    smoothing: float | None = None,
    weights: ArrayLike | str | None = None,
    contacts: bool = True,
) -> Cycle:
    """All frames of a clip, or all but the last where that is the first one over again or costs less."""
    ends = _whole(motion)
    _, _, costs = _features(motion, ends, stiffness_at(Seam(stiffness, smoothing), motion.fps), weights, contacts)
    best = int(np.argmin(costs))
    return Cycle(ends[best].start, ends[best].stop, float(costs[best]))


def _lengths(motion: Motion, shortest: float | None, longest: float | None) -> tuple[int, int]:
    for seconds in (shortest, longest):
        if seconds is not None and not (math.isfinite(seconds) and seconds >= 0):
            raise ParameterError(f"Expected a length in seconds ≥ 0, got {seconds}.")
    if shortest is not None and longest is not None and shortest > longest:
        raise RangeError(
            f"Expected a shortest length of at most the longest, {longest:g} s, got {shortest:g} s. Swap them."
        )
    fewest = max(2, math.ceil((motion.frames if shortest is None else 2 * shortest * motion.fps) / 2))
    most = min(motion.frames, motion.frames if longest is None else math.floor(longest * motion.fps))
    if motion.frames < SHORTEST:
        raise RangeError(f"Expected a clip of at least {SHORTEST} frames to loop, got {motion.frames}.")
    if fewest > most:
        raise RangeError(
            f"Expected a clip that holds a cycle of {fewest} frames or more, got {motion.frames} frames"
            + (f" of which {most} may count." if most < motion.frames else ".")
            + (" Give a shortest length as well; it is half of the clip otherwise." if shortest is None else "")
        )
    return fewest, most


def _whole(motion: Motion) -> list[FrameRange]:
    """The clip as a cycle, without its last frame, which then belongs to the next one; and with it, unless that shows
    the first pose again.
    """
    if motion.frames < SHORTEST:
        raise RangeError(f"Expected a clip of at least {SHORTEST} frames to loop, got {motion.frames}.")
    both = [FrameRange(0, motion.frames - 1), FrameRange(0, motion.frames)]
    return both[:1] if repeats_first_pose(motion) else both


def _features(
    motion: Motion, spans: list[FrameRange], stiffness: float, weights: ArrayLike | str | None, contacts: bool
) -> tuple[Array, Array, list[float]]:
    """Weighted features (F + 1, C) of the clip's places as a cycle's end and as its start, the feet that stand among
    them; and what these spans cost with the neighbours that a loop gives them, feet only where a pose has to change.
    """
    chosen = check_weights(motion.skeleton, weights)
    scales = column_scales(motion.skeleton, chosen)
    found = place_features([motion, *(around_seam(motion, span) for span in spans)], stiffness)
    own, *ends = (features * scales for features in found)
    held = standing_feet(motion) if contacts and chosen is not None else None
    out, into = (np.empty((len(own), 0)),) * 2 if held is None else standing_columns(held, held, stiffness)
    feet = [float(((out[span.stop] - into[span.start]) ** 2).sum()) for span in spans]
    poses = [float(((end[3] - end[1]) ** 2).sum()) for end in ends]
    costs = [pose + (foot if pose > _NOTHING else 0.0) for pose, foot in zip(poses, feet, strict=True)]
    return np.concatenate([own, out], axis=1), np.concatenate([own, into], axis=1), costs


def _cheapest_by_length(out: Array, into: Array, fewest: int, most: int) -> tuple[Array, NDArray[np.intp]]:
    """For each number of frames the least cost of a cycle that has neighbours of its own at both ends, infinite where
    there is none, and its start: (F + 1,) each.
    """
    frames = len(out) - 1
    costs, starts = np.full(frames + 1, np.inf), np.zeros(frames + 1, dtype=np.intp)
    for first in range(1 + fewest, frames, _BLOCK):
        stops = np.arange(first, min(first + _BLOCK, frames))
        for stop, row in zip(range(first, frames), squared_distances(out[stops], into), strict=False):
            here = np.arange(max(1, stop - most), stop - fewest + 1)
            better = row[here] < costs[stop - here]
            costs[stop - here[better]], starts[stop - here[better]] = row[here[better]], here[better]
    return costs, starts
