"""From a document's strips to a timeline: ours come back exactly, another program's as far as they go."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Any

from kinestitch.core.resample import same_rate
from kinestitch.edit.locations import from_url
from kinestitch.edit.pins import Pin
from kinestitch.edit.schema import Own, checked, clip_from, known_fields, number, pin_from, seam_from, upgraded
from kinestitch.edit.timeline import DEFAULT_SEAM, MAX_FRAMES, ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.errors import DocumentError

Probe = Callable[[str], tuple[int, float]]
"""Tells the frames and the rate of a clip's file."""


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of time: start and length in frames of `rate` a second. Raises DocumentError for NaN and rates ≤ 0."""

    start: float
    length: float
    rate: float

    def __post_init__(self) -> None:
        values = (self.start, self.length, self.rate)
        if not (all(math.isfinite(value) for value in values) and self.rate > 0 and self.length >= 0):
            raise DocumentError(
                f"Expected a time range, got start {values[0]}, duration {values[1]}, rate {values[2]}."
            )

    def at(self, fps: float) -> tuple[int, int]:
        """Start and stop at another rate, to the nearest frame, halves up."""
        scale = 1.0 if same_rate(self.rate, fps) else fps / self.rate
        return _nearest(self.start * scale), _nearest((self.start + self.length) * scale)


def _nearest(value: float) -> int:
    if not abs(value) <= MAX_FRAMES:
        raise DocumentError(f"Expected a frame number, got {value:g}.")
    return int(value) if value.is_integer() else math.floor(value + 0.5)


@dataclass(frozen=True, slots=True)
class Strip:
    """One clip on a document's track, as plain data.

    url : where its file lies, if it says so
    source : what is shown of it; None is all of it
    available : what there is of it; it may start at a time code that is not 0
    own : our settings
    """

    name: str
    url: str | None
    source: Span | None
    available: Span | None
    own: dict[str, Any]


@dataclass(slots=True)
class _Clips:
    """The clips found so far: what is known of each, and where it lies as seen from the document's folder."""

    folder: Path
    probe: Probe | None
    infos: dict[str, ClipInfo] = field(default_factory=dict)
    urls: dict[str, str] = field(default_factory=dict)

    def add(self, info: ClipInfo, url: str | None) -> None:
        if info.key in self.infos:
            raise DocumentError(f"Expected every clip once, got {info.key!r} twice.")
        self.infos[info.key] = info
        if url is not None:
            self.urls[info.key] = url

    def ours(self, key: str, strip: Strip) -> str:
        """The key of one of our clips; another program may have told it a new place."""
        if key not in self.infos:
            raise DocumentError(f"Expected one of the document's clips, got {key!r}.")
        if strip.url is not None:
            self.urls[self.infos[key].source] = strip.url
        return key

    def other(self, strip: Strip) -> str:
        """The key of another program's clip: one for each file, or for each name where no file is told."""
        if strip.url is not None and strip.url in self.urls.values():
            return next(key for key, url in self.urls.items() if url == strip.url)
        name = strip.name or PurePath(strip.url or "clip").stem
        if strip.url is None and name in self.infos and name not in self.urls:
            return name
        count, key = 1, name
        while key in self.infos:
            count += 1
            key = f"{name} {count}"
        self.add(self.measured(key, strip), strip.url)
        return key

    def measured(self, key: str, strip: Strip) -> ClipInfo:
        if strip.available is not None:
            start, stop = strip.available.at(strip.available.rate)
            return ClipInfo(key, stop - start, strip.available.rate)
        if self.probe is None or strip.url is None:
            raise DocumentError(f"Expected clip {key!r} to say how long its file is (available_range), got nothing.")
        return ClipInfo(key, *self.probe(from_url(strip.url, self.folder)))


def assemble(
    own: Own | None, strips: list[Strip], folder: Path, probe: Probe | None, ignored: Counter[str]
) -> tuple[Timeline, dict[str, str]]:
    """The timeline of a document and its clips' sources (absolute paths or URLs); `ignored` counts what is left out."""
    if not strips:
        raise DocumentError("Expected at least one clip on the track, got none.")
    clips = _Clips(folder, probe)
    if own is None:
        fps, foot_lock = _rate_of(strips[0], clips), True
    else:
        own = upgraded(own)
        table = known_fields(own.timeline, {"schema", "written_by", "fps", "clips", "foot_lock"}, ignored)
        foot_lock = table.get("foot_lock", True)
        fps = number(table.get("fps"), "the timeline's fps")
        for entry in checked(table.get("clips"), list, "the clips"):
            clips.add(*clip_from(entry, ignored))
    segments: list[Segment] = []
    seams: list[Seam] = []
    pins: list[Pin] = []
    for index, strip in enumerate(strips):
        data = known_fields(own.segments[index] if own else {}, {"clip", "seam", "pins"}, ignored)
        seams.append(seam_from(data["seam"], ignored) if "seam" in data else DEFAULT_SEAM)
        if "clip" in data:
            key, offset = clips.ours(checked(data["clip"], str, "a segment's clip"), strip), 0
        else:
            key, offset = clips.other(strip), 0 if strip.available is None else strip.available.at(fps)[0]
        segment = Segment(key, _range_of(strip, clips.infos[key], fps, offset))
        pins.extend(_pins_of(data.get("pins", []), segment, sum(map(len, segments)), ignored))
        segments.append(segment)
    timeline = Timeline(tuple(clips.infos.values()), tuple(segments), tuple(seams[1:]), fps, tuple(pins), foot_lock)
    return timeline, {key: from_url(url, folder) for key, url in clips.urls.items()}


def _pins_of(data: object, segment: Segment, start: int, ignored: Counter[str]) -> Iterator[Pin]:
    """The pins of a segment that starts at a frame of the result; another program may have cut their frames off."""
    for entry in checked(data, list, "a segment's pins"):
        pin = pin_from(entry, ignored)
        if segment.range.start <= pin.frame < segment.range.stop:
            yield replace(pin, frame=pin.frame - segment.range.start + start)
        else:
            ignored["pin on a frame that is not shown"] += 1


def _rate_of(strip: Strip, clips: _Clips) -> float:
    span = strip.source or strip.available
    return clips.measured(strip.name, strip).fps if span is None else span.rate


def _range_of(strip: Strip, info: ClipInfo, fps: float, offset: int) -> FrameRange:
    frames = info.frames_at(fps)
    if strip.source is None:
        return FrameRange(0, frames)
    start, stop = (bound - offset for bound in strip.source.at(fps))
    # Another program's rounding may be off by one at the end of a clip of another rate.
    return FrameRange(start, frames if stop == frames + 1 and not same_rate(info.fps, fps) else stop)
