"""Time bent near the seams, so that the steps of both sides meet where the cut is.

The cut stays, and so does the length of the result. Within some time on either side of a seam both clips play a little
faster, or slower, than they are: the nearer to the seam the more, up to a bound, and without a jump of speed (Eq. 39).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.retime import time_map
from kinestitch.core.rotation import Array
from kinestitch.edit.speed import retimed_clip, with_segment
from kinestitch.edit.timeline import ClipInfo, Timeline
from kinestitch.errors import ParameterError
from kinestitch.search.align import phase_gaps, wrapped
from kinestitch.search.phase import Steps, find_steps
from kinestitch.solve.placed import place_timeline

BOUND, MOST = 0.2, 0.5
"""By how much speeds may differ from 1 when nothing else is said, and at most."""

SECONDS = 0.5
"""s on either side of a seam in which time is bent."""

_UNSEEN = 0.25  # least speed of what no longer fits between the bent stretch and an end of its clip
_OWN = 2  # frames beyond the seam that a clip still needs as they are: its own next ones, which the solve looks at
_STEPS = 60  # of the bisection


@dataclass(frozen=True, slots=True)
class Warped:
    """A timeline whose steps meet at its seams, as far as the bound allows; by :func:`warp_steps`.

    gaps_before, gaps_after : (S − 1,) rad, the right side's phase less the left one's, within half a turn; NaN where a
        side makes no steps
    speeds : (S − 1,) per seam how fast the left and the right clip play at it, against their pace before
    """

    timeline: Timeline
    gaps_before: tuple[float, ...]
    gaps_after: tuple[float, ...]
    speeds: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class _Bend:
    """Time bent on one side of a seam, which stands at `at` s of the clip: faster by `rate` there, by nothing `width` s
    away from it.
    """

    at: float
    width: float
    rate: float
    left: bool

    def shift(self, times: Array) -> Array:
        """By how many s the clip is ahead of itself: 0 inside its segment, from `width` away from the seam on."""
        u = np.clip((times - self.at) / self.width, -1.0, 1.0)
        done = (u + 1 + np.sin(np.pi * u) / np.pi) / 2
        return np.asarray(self.rate * self.width * (done if self.left else done - 1))


def warp_steps(
    timeline: Timeline, clips: Mapping[str, Motion], bound: float = BOUND, *, seconds: float = SECONDS
) -> Warped:
    """Bend time near every seam between steps, so that a left side at phase φ goes on at phase φ.

    ```
    before  |  A  ~  B  |            the legs jump by a part of a step
    after   |  A' ~  B' |            the same frames on both sides, shown a little earlier or later near the seam
    ```

    bound : speeds stay within 1 ± bound of what they were; 0 < bound ≤ 0.5
    seconds : how far from the seam time is bent; half of a segment at most where both its ends have seams

    Each side takes its share at one speed. Where the bound is reached first, or a clip has no more frames beyond its
    cut, a part of the gap stays. Hard cuts, and seams with a side that makes no steps, stay as they are.

    Raises ParameterError for a bound or a time outside, and what placing raises.
    """
    if not 0 < bound <= MOST:
        raise ParameterError(f"Expected a bound above 0 and up to {MOST:g}, got {bound}.")
    if not (np.isfinite(seconds) and seconds > 0):
        raise ParameterError(f"Expected a time above 0 s to bend, got {seconds}.")
    placed = place_timeline(timeline, clips)
    steps = find_steps(timeline, clips)
    before = phase_gaps(timeline, steps)
    bends: list[list[_Bend]] = [[] for _ in timeline.segments]
    speeds = [(1.0, 1.0)] * len(timeline.seams)
    for seam in placed.seams:
        if seam.stiffness > 0 and np.isfinite(before[seam.index]):
            pair = _bridged(timeline, seam.index, steps, bound, seconds)
            for index, bend in zip((seam.index, seam.index + 1), pair, strict=True):
                if bend.rate:
                    bends[index].append(bend)
            speeds[seam.index] = (1.0 + pair[0].rate, 1.0 + pair[1].rate)
    line = timeline
    for index, found in enumerate(bends):
        if found:
            line = _bent(line, index, found)
    return Warped(line, before, phase_gaps(line, steps), tuple(speeds))


def _bridged(timeline: Timeline, seam: int, steps: Steps, bound: float, seconds: float) -> tuple[_Bend, _Bend]:
    """The bends of both sides by which the phases meet at a seam, or come as near as the bound allows."""
    start = _gap(timeline, seam, steps, _pair(timeline, seam, seconds, 0.0))
    turns = start - float(wrapped(np.array(start)))
    sign = -1.0 if start < turns else 1.0
    low, high = 0.0, bound

    def bridged(rate: float) -> bool:
        gap = sign * (_gap(timeline, seam, steps, _pair(timeline, seam, seconds, sign * rate)) - turns)
        return not gap > 0.0  # where steps end there is nothing to come nearer to

    if not bridged(high):
        return _pair(timeline, seam, seconds, sign * bound)
    for _ in range(_STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if bridged(middle) else (middle, high)
    return _pair(timeline, seam, seconds, sign * low)


def _gap(timeline: Timeline, seam: int, steps: Steps, pair: tuple[_Bend, _Bend]) -> float:
    """By how much the right side's phase is ahead of the left one's at a seam whose sides are bent, in rad."""
    total = 0.0
    for sign, bend, segment in zip((-1.0, 1.0), pair, timeline.segments[seam : seam + 2], strict=True):
        times = bend.at + np.array([-0.5, 0.5]) / timeline.fps
        phases = steps.at(timeline.clip(segment.clip), times + bend.shift(times), 1.0 / timeline.fps)
        total += sign * float(phases.mean())
    return total


def _pair(timeline: Timeline, seam: int, seconds: float, rate: float) -> tuple[_Bend, _Bend]:
    """The bends left and right of a seam at this rate, or at the most that the clips' ends leave room for."""
    left, right = timeline.segments[seam : seam + 2]
    fps = timeline.fps
    whole = (seam == 0, seam == len(timeline.seams) - 1)
    widths = [min(seconds, len(side) / fps * (1.0 if w else 0.5)) for side, w in zip((left, right), whole, strict=True)]
    first = _Bend((left.range.stop - 0.5) / fps, widths[0], 1.0, True)
    second = _Bend((right.range.start - 0.5) / fps, widths[1], 1.0, False)
    end = _end(timeline.clip(left.clip), fps)
    last = (left.range.stop - 1 + _OWN) / fps
    before = (right.range.start - _OWN) / fps
    most = [_most(first, last, end - last), _most(second, before, before)]
    return tuple(  # type: ignore[return-value]
        _Bend(bend.at, bend.width, min(rate, room), bend.left) for bend, room in zip((first, second), most, strict=True)
    )


def _most(bend: _Bend, time: float, room: float) -> float:
    """The greatest rate at which `time`, the last that has to be shown as it is, leaves enough of the room (s) that is
    between it and the clip's end.
    """
    return max(0.0, room) * (1 - _UNSEEN) / max(abs(float(bend.shift(np.array(time)))), 1e-12)


def _end(info: ClipInfo, fps: float) -> float:
    """s; when a clip ends."""
    return (info.frames - 1) / info.fps if info.retiming is None else info.retiming.knots[-1][0]


def _bent(timeline: Timeline, index: int, bends: list[_Bend]) -> Timeline:
    """The timeline with one segment's clip bent; its frames keep their numbers."""
    segment = timeline.segments[index]
    info = timeline.clip(segment.clip)
    source = timeline.clip(info.source)
    own = ((0.0, 0.0), (_end(info, timeline.fps),) * 2) if info.retiming is None else info.retiming.knots
    end = own[-1][0]
    frame = 1.0 / timeline.fps
    times = {0.0, end, *(time for time, _ in own)}
    for bend in bends:
        first, last = (np.floor((bend.at + way * bend.width) / frame + way) for way in (-1, 1))
        times |= {float(k) * frame for k in np.arange(first - 1, last + 2)}
    t = np.array(sorted(time for time in times if 0.0 <= time <= end))
    shown = np.clip(t + sum(bend.shift(t) for bend in bends), 0.0, end)
    kept = (shown >= _UNSEEN * t) & (end - shown >= _UNSEEN * (end - t))
    kept[[0, -1]] = True
    t, shown = t[kept], shown[kept]
    apart = np.concatenate([[True], np.diff(t) > 1e-3 * frame])
    knots = zip(t[apart].tolist(), time_map(own, shown[apart]).tolist(), strict=True)
    name = info.key if info.key.endswith(" warped") else f"{info.key} warped"
    return with_segment(timeline, index, retimed_clip(timeline, source, tuple(knots), name), segment.range)
