"""The eight edits, as pure functions from a timeline to a new one; undo is keeping the old value.

Frames given are those of the timeline that is passed in. Every edit ripples: what follows moves in time.

One rule for seams: a seam stays, with its settings, where the two frames that meet at it still meet. Wherever an edit
makes other frames meet there is a new seam, with the settings given as ``seam``, or automatic ones (``DEFAULT_SEAM``).
"""

from __future__ import annotations

from dataclasses import replace as _with
from itertools import pairwise

from kinestitch.edit.pieces import clip_piece, cut_piece, join_pieces
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Timeline, range_hint, whole
from kinestitch.errors import RangeError


def check_range(timeline: Timeline, start: int, stop: int) -> FrameRange:
    """The range as a value; raises RangeError unless it is a non-empty one inside the timeline."""
    start, stop = whole(start, "a range's start"), whole(stop, "a range's stop")
    if not 0 <= start < stop <= timeline.frames:
        raise RangeError(
            f"Expected a range start:stop within 0:{timeline.frames} of the timeline, got {start}:{stop}. "
            + range_hint(start, stop, timeline.frames)
        )
    return FrameRange(start, stop)


def check_place(timeline: Timeline, at: int) -> int:
    """The place as an int; raises RangeError unless 0 ≤ at ≤ frames."""
    at = whole(at, "a place")
    if not 0 <= at <= timeline.frames:
        raise RangeError(f"Expected a place from 0 to {timeline.frames} on the timeline, got {at}.")
    return at


def add_clip(timeline: Timeline, info: ClipInfo) -> Timeline:
    """The timeline that knows one more clip; nothing on the line changes.

    Raises ParameterError if another clip has its key; a clip it already knows is fine.

    >>> from kinestitch.edit.timeline import timeline
    >>> line = add_clip(timeline([ClipInfo("walk", 120, 30.0)], "walk"), ClipInfo("kick", 50, 30.0))
    >>> [clip.key for clip in line.clips], line.frames
    (['walk', 'kick'], 120)
    """
    return timeline if info in timeline.clips else _with(timeline, clips=(*timeline.clips, info))


def replace(
    timeline: Timeline,
    start: int,
    stop: int,
    clip: str,
    clip_start: int | None = None,
    clip_stop: int | None = None,
    *,
    seam: Seam | None = None,
) -> Timeline:
    """Paste a range of a clip over the frames start:stop, as one pastes over selected text; lengths may differ.

    ```
    before  |      A      |          start = 60, stop = 80
    after   |  A  |  B  |  A  |      two new seams; the rest of A moves in time
    ```

    clip_start, clip_stop : the clip's own frames at its own rate; left out, its first frame and its end
    seam : settings of the new seams, automatic ones when left out

    Raises RangeError for ranges that are empty or outside, MissingClipError for an unknown clip.

    >>> from kinestitch.edit.timeline import timeline
    >>> walk = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 50, 30.0)], "walk")
    >>> line = replace(walk, 60, 80, "kick", 10, 40)
    >>> [str(segment) for segment in line.segments], line.frames
    (['walk@0:60', 'kick@10:40', 'walk@80:120'], 130)
    """
    span = check_range(timeline, start, stop)
    pasted = clip_piece(timeline, clip, clip_start, clip_stop)
    before, after = cut_piece(timeline, 0, span.start), cut_piece(timeline, span.stop, timeline.frames)
    return join_pieces(timeline, (before, pasted, after), seam)


def insert(
    timeline: Timeline,
    at: int,
    clip: str,
    clip_start: int | None = None,
    clip_stop: int | None = None,
    *,
    seam: Seam | None = None,
) -> Timeline:
    """Put a range of a clip in front of frame `at`; what stood there follows it.

    ```
    before  |     A     |            at = 60
    after   |  A  |  B  |  A  |      two new seams, one at either end of the line
    ```

    Parameters and errors as in ``replace``; `at` may be the timeline's end.

    >>> from kinestitch.edit.timeline import timeline
    >>> walk = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 100, 60.0)], "walk")
    >>> [str(segment) for segment in insert(walk, 60, "kick", 20, 80).segments]
    ['walk@0:60', 'kick@10:40', 'walk@60:120']
    """
    at = check_place(timeline, at)
    pasted = clip_piece(timeline, clip, clip_start, clip_stop)
    return join_pieces(timeline, (cut_piece(timeline, 0, at), pasted, cut_piece(timeline, at, timeline.frames)), seam)


def append(
    timeline: Timeline,
    clip: str,
    clip_start: int | None = None,
    clip_stop: int | None = None,
    *,
    seam: Seam | None = None,
) -> Timeline:
    """Put a range of a clip at the end.

    ```
    before  |     A     |
    after   |     A     |  B  |      one new seam
    ```

    Parameters and errors as in ``replace``.

    >>> from kinestitch.edit.timeline import timeline
    >>> walk = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 50, 30.0)], "walk")
    >>> append(walk, "kick").starts
    (0, 120, 170)
    """
    return insert(timeline, timeline.frames, clip, clip_start, clip_stop, seam=seam)


def delete(timeline: Timeline, start: int, stop: int, *, seam: Seam | None = None) -> Timeline:
    """Take the frames start:stop out; what follows closes up.

    ```
    before  |  A  |xxx|  A  |        start = 60, stop = 80
    after   |  A  |  A  |            one new seam
    ```

    Raises RangeError for a range that is empty or outside, and where no frame would stay.

    >>> from kinestitch.edit.timeline import timeline
    >>> line = delete(timeline([ClipInfo("walk", 120, 30.0)], "walk"), 60, 80)
    >>> [str(segment) for segment in line.segments], line.frames
    (['walk@0:60', 'walk@80:120'], 100)
    """
    span = check_range(timeline, start, stop)
    before, after = cut_piece(timeline, 0, span.start), cut_piece(timeline, span.stop, timeline.frames)
    return join_pieces(timeline, (before, after), seam)


def trim(timeline: Timeline, start: int, stop: int) -> Timeline:
    """Keep only the frames start:stop; seams inside stay as they are.

    ```
    before  |xx|    A    |  B  |xx|
    after      |    A    |  B  |
    ```

    Raises RangeError for a range that is empty or outside.

    >>> from kinestitch.edit.timeline import timeline
    >>> trim(timeline([ClipInfo("walk", 120, 30.0)], "walk"), 30, 90).segments[0]
    Segment(clip='walk', range=FrameRange(start=30, stop=90))
    """
    span = check_range(timeline, start, stop)
    return join_pieces(timeline, (cut_piece(timeline, span.start, span.stop),))


def split(timeline: Timeline, at: int, *, seam: Seam | None = None) -> Timeline:
    """Make a seam in front of frame `at` and change no frame: the handle for what comes next.

    ```
    before  |     A     |            at = 60
    after   |  A  |  A  |            the same frames
    ```

    Where a seam is already, nothing happens. Raises RangeError for the timeline's ends and outside.

    >>> from kinestitch.edit.timeline import timeline
    >>> line = split(timeline([ClipInfo("walk", 120, 30.0)], "walk"), 60)
    >>> line.starts, [line.segment_at(frame)[1] for frame in (59, 60)]
    ((0, 60, 120), [59, 60])
    """
    at = whole(at, "a place")
    if not 0 < at < timeline.frames:
        raise RangeError(f"Expected a place inside the timeline, from 1 to {timeline.frames - 1}, got {at}.")
    if at in timeline.starts:
        return timeline
    return join_pieces(timeline, (cut_piece(timeline, 0, at), cut_piece(timeline, at, timeline.frames)), seam)


def move(timeline: Timeline, start: int, stop: int, to: int, *, seam: Seam | None = None) -> Timeline:
    """Cut the frames start:stop out and put them in front of frame `to`, counted before the move.

    ```
    before  |  A  | M |  B  |  C  |      to = start of C
    after   |  A  |  B  | M |  C  |      three new seams; those inside M stay as they are
    ```

    `to` lies outside the range; at either end of it nothing moves. Raises RangeError for a range that is empty or
    outside, and for a `to` inside the range or outside the timeline.

    >>> from kinestitch.edit.timeline import timeline
    >>> walk = timeline([ClipInfo("walk", 120, 30.0)], "walk")
    >>> [str(segment) for segment in move(walk, 20, 40, 100).segments]
    ['walk@0:20', 'walk@40:100', 'walk@20:40', 'walk@100:120']
    """
    span, to = check_range(timeline, start, stop), check_place(timeline, to)
    if span.start < to < span.stop:
        raise RangeError(f"Expected a place outside the moved range {span}, got {to}.")
    if to in (span.start, span.stop):
        return timeline
    bounds = sorted({0, span.start, span.stop, to, timeline.frames})
    pieces = {low: cut_piece(timeline, low, high) for low, high in pairwise(bounds)}
    moved = pieces.pop(span.start)
    before = [piece for low, piece in pieces.items() if low < to]
    after = [piece for low, piece in pieces.items() if low >= to]
    return join_pieces(timeline, (*before, moved, *after), seam)


def set_seam(timeline: Timeline, index: int, seam: Seam) -> Timeline:
    """Other settings for the seam between segments `index` and `index` + 1.

    ```
    before  |  A  |  B  |
    after   |  A  ~  B  |            the same frames, another smoothing
    ```

    Raises RangeError where there is no such seam.

    >>> from kinestitch.edit.timeline import timeline
    >>> line = split(timeline([ClipInfo("walk", 120, 30.0)], "walk"), 60)
    >>> set_seam(line, 0, Seam(smoothing=0.2)).seams
    (Seam(stiffness=None, smoothing=0.2, automatic=False),)
    """
    index = whole(index, "a seam")
    if not 0 <= index < len(timeline.seams):
        raise RangeError(f"Expected one of the timeline's {len(timeline.seams)} seams, numbered from 0, got {index}.")
    return _with(timeline, seams=(*timeline.seams[:index], seam, *timeline.seams[index + 1 :]))
