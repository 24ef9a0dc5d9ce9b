"""Segments at another speed, and what retimed clips a timeline needs for it."""

from __future__ import annotations

import math
from dataclasses import replace

from kinestitch.core.retime import time_map
from kinestitch.edit.pins import Pin
from kinestitch.edit.retiming import Knots, Retiming
from kinestitch.edit.timeline import ClipInfo, FrameRange, Segment, Timeline, whole
from kinestitch.errors import ParameterError, RangeError

SPEEDS = (0.1, 10.0)
"""Slowest and fastest speed that a segment may be given."""


def set_speed(timeline: Timeline, index: int, speed: float) -> Timeline:
    """Show the same stretch of a segment's clip at another speed; what follows moves in time.

    ```
    before  |  A  |   B   |  A  |        index = 1, speed = 2
    after   |  A  | B |  A  |            the same seams
    ```

    speed : against the clip as it is, whatever the segment's speed was before; 1 shows the clip itself again

    The stretch begins and ends at the nearest frames, so that either end lies up to half of `speed` frames of the clip
    off; where it went on to the clip's end, it still does. A segment that was slowed down is the same again at speed 1,
    but for a frame at its clip's end. Pins stay on what they are on.

    Raises RangeError where there is no such segment and for a clip of one frame, ParameterError for a speed outside
    0.1 to 10.

    >>> from kinestitch.edit.timeline import timeline
    >>> line = set_speed(timeline([ClipInfo("walk", 121, 30.0)], "walk"), 0, 0.5)
    >>> str(line.segments[0]), line.clips[1].retiming.knots
    ('walk ×0.5@0:241', ((0.0, 0.0), (8.0, 4.0)))
    >>> set_speed(line, 0, 1.0) == timeline([ClipInfo("walk", 121, 30.0)], "walk")
    True
    """
    index, speed = _checked(timeline, index, speed)
    segment = timeline.segments[index]
    source = timeline.clip(timeline.clip(segment.clip).source)
    new = source
    if speed != 1.0:
        if source.frames < 2:
            raise RangeError(f"Expected a clip of at least 2 frames to retime, got 1 in {source.key!r}.")
        end = (source.frames - 1) / source.fps
        new = retimed_clip(timeline, source, ((0.0, 0.0), (end / speed, end)), f"{source.key} ×{speed:g}")
    last = new.frames_at(timeline.fps)
    bounds = (segment.range.start, segment.range.stop)
    start, stop = (_nearest(source_frame(timeline, segment.clip, bound) / speed) for bound in bounds)
    if segment.range.stop == timeline.clip(segment.clip).frames_at(timeline.fps):
        stop = last
    start = max(min(start, last - 1), 0)
    return with_segment(timeline, index, new, FrameRange(start, max(min(stop, last), start + 1)))


def _checked(timeline: Timeline, index: int, speed: float) -> tuple[int, float]:
    index = whole(index, "a segment")
    if not 0 <= index < len(timeline.segments):
        raise RangeError(
            f"Expected one of the timeline's {len(timeline.segments)} segments, numbered from 0, got {index}."
        )
    try:
        value = float(speed)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"Expected a speed from {SPEEDS[0]:g} to {SPEEDS[1]:g}, got {speed!r}.") from error
    if not SPEEDS[0] <= value <= SPEEDS[1]:
        raise ParameterError(f"Expected a speed from {SPEEDS[0]:g} to {SPEEDS[1]:g}, got {value:g}.")
    return index, value


def _nearest(value: float) -> int:
    return math.floor(value + 0.5)


def source_frame(timeline: Timeline, clip: str, frame: float) -> float:
    """Which moment of a clip's source its `frame` shows, both counted in frames at the timeline's rate."""
    retiming = timeline.clip(clip).retiming
    if retiming is None:
        return frame
    return float(time_map(retiming.knots, frame / timeline.fps)) * timeline.fps


def retimed_clip(timeline: Timeline, source: ClipInfo, knots: Knots, name: str) -> ClipInfo:
    """The clip that retimes `source` by these knots: one that the timeline knows already, or a new one of a free key
    like `name`.
    """
    retiming = Retiming(source.key, knots)
    for known in timeline.clips:
        if known.retiming == retiming and known.fps == source.fps:
            return known
    keys = {clip.key for clip in timeline.clips}
    count, key = 1, name
    while key in keys:
        count += 1
        key = f"{name} {count}"
    return ClipInfo(key, retiming.frames_at(source.fps), source.fps, retiming)


def with_segment(timeline: Timeline, index: int, clip: ClipInfo, shown: FrameRange) -> Timeline:
    """The timeline with another clip and range in one segment's place; a retimed clip that nothing shows any more is
    dropped.
    """
    before = timeline.clip(timeline.segments[index].clip)
    segments = (*timeline.segments[:index], Segment(clip.key, shown), *timeline.segments[index + 1 :])
    clips = timeline.clips if clip in timeline.clips else (*timeline.clips, clip)
    if before.retiming is not None and all(segment.clip != before.key for segment in segments):
        clips = tuple(known for known in clips if known != before)
    return replace(timeline, clips=clips, segments=segments, pins=_kept_pins(timeline, index, len(shown)))


def _kept_pins(timeline: Timeline, index: int, length: int) -> tuple[Pin, ...]:
    """The pins where one segment has become this long: those on it move along with what it shows, and of several that
    then decide one thing in one frame the first stays.
    """
    start, before = timeline.starts[index], len(timeline.segments[index])
    kept: list[Pin] = []
    taken: set[tuple[int, tuple[str, str | None]]] = set()
    for pin in timeline.pins:
        frame = pin.frame
        if frame >= start + before:
            frame += length - before
        elif frame >= start:
            frame = start + min(_nearest((frame - start) * length / before), length - 1)
        decides = {(frame, what) for what in pin.fixes}
        if not decides & taken:
            kept.append(replace(pin, frame=frame))
            taken |= decides
    return tuple(kept)
