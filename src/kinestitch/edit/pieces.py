"""What a timeline falls into when it is cut, and how pieces become a timeline again."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from kinestitch.core.resample import resampled_bound
from kinestitch.edit.pins import Pin
from kinestitch.edit.timeline import DEFAULT_SEAM, FrameRange, Seam, Segment, Timeline, range_hint, whole
from kinestitch.errors import RangeError


@dataclass(frozen=True, slots=True)
class Piece:
    """Some consecutive segments, the seams between them, and the pins on their frames; may be empty.

    pins : their frames count from the piece's first
    """

    segments: tuple[Segment, ...] = ()
    seams: tuple[Seam, ...] = ()
    pins: tuple[Pin, ...] = ()

    @property
    def frames(self) -> int:
        """Number of frames."""
        return sum(len(segment) for segment in self.segments)


def cut_piece(timeline: Timeline, start: int, stop: int) -> Piece:
    """The frames start:stop of a timeline as a piece; an empty one where start = stop."""
    if start >= stop:
        return Piece()
    starts = timeline.starts
    first, last = bisect_right(starts, start) - 1, bisect_left(starts, stop) - 1
    segments = list(timeline.segments[first : last + 1])
    over = segments[-1].range.stop - (starts[last + 1] - stop)
    segments[-1] = Segment(segments[-1].clip, FrameRange(segments[-1].range.start, over))
    under = segments[0].range.start + (start - starts[first])
    segments[0] = Segment(segments[0].clip, FrameRange(under, segments[0].range.stop))
    pins = tuple(replace(pin, frame=pin.frame - start) for pin in timeline.pins if start <= pin.frame < stop)
    return Piece(tuple(segments), timeline.seams[first:last], pins)


def clip_piece(timeline: Timeline, clip: str, start: int | None = None, stop: int | None = None) -> Piece:
    """A range of a clip as a piece; start and stop count the clip's own frames, None is its first frame and its end.

    A clip of another rate is resampled as a whole, and bound n becomes round(n · fps / the clip's fps).
    """
    info = timeline.clip(clip)
    first = 0 if start is None else whole(start, "a clip's start")
    last = info.frames if stop is None else whole(stop, "a clip's stop")
    if not 0 <= first < last <= info.frames:
        raise RangeError(
            f"Expected a range within 0:{info.frames} of clip {clip!r}, got {first}:{last}. "
            + range_hint(first, last, info.frames)
        )
    new_start = resampled_bound(first, info.frames, info.fps, timeline.fps)
    new_stop = info.frames_at(timeline.fps)
    if stop is not None:
        new_stop = resampled_bound(last, info.frames, info.fps, timeline.fps)
    if new_start >= new_stop:
        raise RangeError(
            f"Expected a range that keeps a frame at {timeline.fps:g} fps, got {first}:{last} "
            f"of clip {clip!r} at {info.fps:g} fps. Take a longer range."
        )
    return Piece((Segment(clip, FrameRange(new_start, new_stop)),))


def join_pieces(timeline: Timeline, pieces: Iterable[Piece], seam: Seam | None = None) -> Timeline:
    """The timeline with other content: these pieces one after the other, with a new seam wherever two meet.

    Empty pieces count as absent; pins go where their frames go. Raises RangeError if nothing is left.
    """
    segments: list[Segment] = []
    seams: list[Seam] = []
    pins: list[Pin] = []
    start = 0
    for piece in pieces:
        if not piece.segments:
            continue
        pins.extend(replace(pin, frame=start + pin.frame) for pin in piece.pins)
        start += piece.frames
        if segments:
            seams.append(seam or DEFAULT_SEAM)
        segments.extend(piece.segments)
        seams.extend(piece.seams)
    if not segments:
        raise RangeError(f"Expected at least one frame to stay, got a deletion of all {timeline.frames} frames.")
    return replace(timeline, segments=tuple(segments), seams=tuple(seams), pins=tuple(pins))


def with_bounds(timeline: Timeline, segments: Sequence[Segment]) -> Timeline:
    """The timeline whose segments show more or less of their clips; pins stay on the frames that they are on, and go
    with those that are shown no more.

    segments : as many as before, each of the clip that it had
    """
    pins, start = [], 0
    for old, new, first in zip(timeline.segments, segments, timeline.starts, strict=False):
        shift = start - new.range.start - (first - old.range.start)
        for pin in timeline.pins:
            if first <= pin.frame < first + len(old) and start <= pin.frame + shift < start + len(new):
                pins.append(replace(pin, frame=pin.frame + shift))
        start += len(new)
    return replace(timeline, segments=tuple(segments), pins=tuple(pins))
