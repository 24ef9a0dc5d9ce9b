"""The edits of pins, as pure functions from a timeline to a new one."""

from __future__ import annotations

from dataclasses import replace
from typing import SupportsIndex

from kinestitch.edit.pins import Pin
from kinestitch.edit.timeline import Timeline, whole
from kinestitch.errors import ParameterError, RangeError


def add_pin(timeline: Timeline, pin: Pin) -> Timeline:
    """One more thing that a frame of the result has to show.

    ```
    before  |     A     |
    after   |     A  !  |            the same frames, one of them pinned
    ```

    The pin then stays with its frame: later edits move it in time, or take it out together with the frame. Raises
    RangeError for a frame outside the timeline, ParameterError where another pin decides the same in this frame.

    >>> from kinestitch.edit.timeline import ClipInfo, timeline
    >>> from kinestitch.edit.operations import insert
    >>> walk = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 50, 30.0)], "walk")
    >>> line = add_pin(walk, Pin("waypoint", 100, (1.0, 4.0)))
    >>> [str(pin) for pin in insert(line, 60, "kick").pins]
    ['waypoint@150=1,4']
    """
    return replace(timeline, pins=(*timeline.pins, pin))


def remove_pin(timeline: Timeline, index: SupportsIndex) -> Timeline:
    """The timeline without its pin number `index`, counted from 0 in the order of ``timeline.pins``.

    ```
    before  |     A  !  |
    after   |     A     |            the same frames, one pin fewer
    ```

    Raises RangeError where there is no such pin.
    """
    at = whole(index, "a pin")
    if not 0 <= at < len(timeline.pins):
        raise RangeError(f"Expected one of the timeline's {len(timeline.pins)} pins, numbered from 0, got {at}.")
    return replace(timeline, pins=(*timeline.pins[:at], *timeline.pins[at + 1 :]))


def come_back(timeline: Timeline, seconds: float) -> Timeline:
    """Let the body meet its original path again within `seconds` of the last seam.

    ```
    before  |  A  |  B  |     A     |      what follows B rides along
    after   |  A  |  B  |  ~  A     |      from the end of ~ on, A is where it was before the edit
    ```

    It is a pin ``return`` on a frame of the last segment. Raises RangeError if that segment ends sooner, ParameterError
    for a time that is not positive, a timeline without a seam, or one that does not end with the original.

    >>> from kinestitch.edit.timeline import ClipInfo, timeline
    >>> from kinestitch.edit.operations import insert
    >>> walk = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 50, 30.0)], "walk")
    >>> [str(pin) for pin in come_back(insert(walk, 60, "kick"), 1.0).pins]
    ['return@140']
    """
    if not timeline.seams:
        raise ParameterError("Expected an edit to come back from, got a clip as it was.")
    if timeline.clip(timeline.segments[-1].clip).source != timeline.clips[0].source:
        raise ParameterError(
            f"Expected a piece of {timeline.clips[0].key!r} behind the last seam to come back to, "
            f"got {timeline.segments[-1].clip!r}."
        )
    last = timeline.starts[-2]
    pin = Pin("return", last, smoothing=seconds)
    frame = last + max(1, round(seconds * timeline.fps))
    if frame >= timeline.frames:
        rest = (timeline.frames - 1 - last) / timeline.fps
        raise RangeError(f"Expected a way back of at most {rest:.3g} s, all of the last segment, got {seconds:g} s.")
    return add_pin(timeline, replace(pin, frame=frame))
