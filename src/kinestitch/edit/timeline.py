"""What the user wants: which frames of which clips follow each other, and how smoothly they meet.

A timeline holds no motion data, only keys, frame numbers and settings: it is cheap to copy, compare and keep for undo.
"""

from __future__ import annotations

import math
import operator
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, SupportsIndex

from kinestitch.core.resample import resampled_frames, same_rate
from kinestitch.edit.pins import Pin, check_pins, sorted_pins
from kinestitch.edit.retiming import Retiming
from kinestitch.errors import MissingClipError, ParameterError, RangeError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion

DEFAULT_SMOOTHING = 0.1
"""Smoothing time in seconds of ``Seam()``, which is not automatic: λ = 81 at 30 fps, 1,296 at 60 fps."""

MAX_FRAMES = 2**53
"""Documents keep frame numbers as doubles; above this they would no longer be exact."""


def whole(value: SupportsIndex, name: str) -> int:
    """A frame number as a plain int; raises ParameterError for 1.5 or None."""
    try:
        return operator.index(value)
    except TypeError as error:
        raise ParameterError(f"Expected a whole number for {name}, got {value!r}.") from error


def positive_rate(fps: float) -> float:
    """A frame rate as a plain float; raises ParameterError unless it is finite and above 0."""
    try:
        rate = float(fps)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"Expected fps > 0, got {fps!r}.") from error
    if not (math.isfinite(rate) and rate > 0):
        raise ParameterError(f"Expected fps > 0, got {rate}.")
    return rate


@dataclass(frozen=True, slots=True)
class FrameRange:
    """Frames start, start + 1, …, stop − 1: half-open, so that ``len`` is a difference and neighbours share a bound.

    Raises RangeError unless 0 ≤ start < stop.

    >>> len(FrameRange(60, 110))
    50
    """

    start: int
    stop: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", whole(self.start, "a range's start"))
        object.__setattr__(self, "stop", whole(self.stop, "a range's stop"))
        if not 0 <= self.start < self.stop <= MAX_FRAMES:
            raise RangeError(
                f"Expected a range start:stop with 0 ≤ start < stop, got {self}. {range_hint(self.start, self.stop)}"
            )

    def __len__(self) -> int:
        return self.stop - self.start

    def __str__(self) -> str:
        return f"{self.start}:{self.stop}"


def range_hint(start: int, stop: int, frames: int = MAX_FRAMES) -> str:
    """What to try instead of a range start:stop that is none of `frames` frames."""
    what = "Let its stop come after its start" if 0 <= start < frames and stop <= start else "Choose frames inside it"
    return f"{what}; the stop frame itself is not part of a range."


@dataclass(frozen=True, slots=True)
class ClipInfo:
    """What a timeline knows of a clip: the key it is called by, its number of frames F ≥ 1 and its own rate.

    retiming : for a clip that shows another one at another speed; its frames are those up to the last knot

    Raises RangeError for F < 1, ParameterError for fps ≤ 0 or a key that is no text.
    """

    key: str
    frames: int
    fps: float
    retiming: Retiming | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.key, str):
            raise ParameterError(f"Expected a clip's key to be text, got {self.key!r}.")
        object.__setattr__(self, "frames", whole(self.frames, f"the frames of clip {self.key!r}"))
        object.__setattr__(self, "fps", positive_rate(self.fps))
        if not 1 <= self.frames <= MAX_FRAMES:
            raise RangeError(f"Expected a clip of at least 1 frame, got {self.frames} in clip {self.key!r}.")
        if self.retiming is not None and self.frames != self.retiming.frames_at(self.fps):
            raise RangeError(
                f"Expected {self.retiming.frames_at(self.fps)} frames in the retimed clip {self.key!r}, as its last "
                f"knot says, got {self.frames}."
            )

    @property
    def source(self) -> str:
        """Key of the clip whose motion this one shows: its own, or its source's where it is retimed."""
        return self.key if self.retiming is None else self.retiming.clip

    def frames_at(self, fps: float) -> int:
        """Number of frames the clip has once it is resampled as a whole to `fps`.

        >>> ClipInfo("kick", 61, 60.0).frames_at(30.0)
        31
        """
        try:
            frames = resampled_frames(self.frames, self.fps, fps)
        except (OverflowError, ValueError):
            frames = MAX_FRAMES + 1
        if frames > MAX_FRAMES:
            raise RangeError(f"Expected a clip that can be resampled, got {self.fps} fps to {fps} fps ({self.key!r}).")
        return frames


@dataclass(frozen=True, slots=True)
class Seam:
    """How smoothly two segments meet: a stiffness λ ≥ 0, or a smoothing time τ ≥ 0 in seconds, or automatic; none of
    them is the default.

    λ is the published number and depends on the frame rate; τ means the same at every rate: λ = (τ · fps)⁴. Larger
    values spread the difference over more frames. An automatic seam takes as little time as what its clips do anyway
    allows. Raises ParameterError for more than one of them, for negative values, NaN, infinity.

    >>> Seam().lambda_at(30.0), Seam(smoothing=0.2).lambda_at(30.0), Seam(stiffness=100).lambda_at(30.0)
    (81.0, 1296.0, 100.0)
    """

    stiffness: float | None = None
    smoothing: float | None = None
    automatic: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.automatic, bool):
            raise ParameterError(f"Expected a seam's automatic to be True or False, got {self.automatic!r}.")
        for name in ("stiffness", "smoothing"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _not_negative(value, name))
        if self.stiffness is not None and self.smoothing is not None:
            raise ParameterError(
                f"Expected a stiffness or a smoothing time, got both ({self.stiffness} and {self.smoothing} s). "
                "Leave one out."
            )
        if self.automatic and (self.stiffness is not None or self.smoothing is not None):
            raise ParameterError(
                "Expected an automatic seam without a stiffness or a smoothing time, got "
                f"{self.stiffness if self.smoothing is None else self.smoothing}. Leave one out."
            )

    def lambda_at(self, fps: float) -> float:
        """The stiffness λ on a timeline of this rate; the default's where it is automatic, which takes the clips to
        tell.
        """
        if self.stiffness is not None:
            return self.stiffness
        width = (DEFAULT_SMOOTHING if self.smoothing is None else self.smoothing) * positive_rate(fps)
        stiffness = width * width * (width * width)
        if not math.isfinite(stiffness):
            raise ParameterError(f"Expected a smoothing time of some seconds, got {self.smoothing} s.")
        return stiffness


DEFAULT_SEAM = Seam(automatic=True)
"""Settings of the seams that an edit makes and says nothing about: as much time as each needs, and no more."""


def _not_negative(value: float, name: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"Expected a seam's {name} ≥ 0, got {value!r}.") from error
    if not (math.isfinite(number) and number >= 0):
        raise ParameterError(f"Expected a seam's {name} ≥ 0, got {number}.")
    return number + 0.0


@dataclass(frozen=True, slots=True)
class Segment:
    """Consecutive frames of one clip.

    clip : the clip's key
    range : frames of the clip **at the timeline's rate**; a clip of another rate is resampled as a whole first
    """

    clip: str
    range: FrameRange

    def __len__(self) -> int:
        return len(self.range)

    def __str__(self) -> str:
        return f"{self.clip}@{self.range}"


@dataclass(frozen=True, slots=True)
class Timeline:
    """S segments that follow each other, and the S − 1 seams between them; hashable, equal by value.

    clips : every clip that may be used, on the line or not
    segments : at least one
    seams : seam i lies between segments i and i + 1
    fps : the result's rate
    pins : what single frames of the result have to show, in the order of these frames
    foot_lock : whether feet near the seams are to be held where they stand in the clips

    Raises RangeError for no segment and for a segment outside its clip or a pin outside the result, MissingClipError
    for a segment of an unknown clip, ParameterError for keys that occur twice, a wrong number of seams, fps ≤ 0 or two
    pins that decide one thing in one frame.
    """

    clips: tuple[ClipInfo, ...]
    segments: tuple[Segment, ...]
    seams: tuple[Seam, ...]
    fps: float
    pins: tuple[Pin, ...] = ()
    foot_lock: bool = True

    def __post_init__(self) -> None:
        if not isinstance(self.foot_lock, bool):
            raise ParameterError(f"Expected a timeline's foot_lock to be True or False, got {self.foot_lock!r}.")
        for name in ("clips", "segments", "seams"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        object.__setattr__(self, "fps", positive_rate(self.fps))
        if not self.segments:
            raise RangeError("Expected a timeline of at least one segment, got none.")
        if len(self.seams) != len(self.segments) - 1:
            raise ParameterError(
                f"Expected one seam fewer than segments, got {len(self.seams)} seams and {len(self.segments)} segments."
            )
        self._check_segments()
        object.__setattr__(self, "pins", sorted_pins(self.pins))
        check_pins(self.pins, self.frames)

    def _check_segments(self) -> None:
        frames: dict[str, int] = {}
        for clip in self.clips:
            if clip.key in frames:
                raise ParameterError(f"Expected every clip once, got {clip.key!r} twice. Give one another key.")
            frames[clip.key] = clip.frames_at(self.fps)
        for clip in self.clips:
            if clip.retiming is not None:
                _check_retiming(clip, clip.retiming, self.clip(clip.source))
        for index, segment in enumerate(self.segments):
            if segment.clip not in frames:
                raise _missing(segment.clip, frames)
            if segment.range.stop > frames[segment.clip]:
                raise RangeError(
                    f"Expected frames within 0:{frames[segment.clip]} of clip {segment.clip!r} at {self.fps:g} fps, "
                    f"got {segment.range} in segment {index}."
                )

    @property
    def frames(self) -> int:
        """Number of frames of the result."""
        return sum(len(segment) for segment in self.segments)

    @property
    def starts(self) -> tuple[int, ...]:
        """(S + 1,) the frame at which each segment starts; the last entry is the number of frames."""
        return tuple(accumulate((len(segment) for segment in self.segments), initial=0))

    @property
    def original(self) -> str:
        """Key of the clip whose body the result has: the first clip's if it is shown, else the first one shown; of a
        retimed clip, its source's.
        """
        shown = [self.clip(segment.clip).source for segment in self.segments]
        return self.clips[0].source if self.clips[0].source in shown else shown[0]

    def clip(self, key: str) -> ClipInfo:
        """The clip of this key; raises MissingClipError that lists the known ones."""
        for info in self.clips:
            if info.key == key:
                return info
        raise _missing(key, [info.key for info in self.clips])

    def segment_at(self, frame: int) -> tuple[int, int]:
        """Which segment shows this frame of the result, and which frame of its clip (at the timeline's rate) that is.

        Raises RangeError outside the timeline.
        """
        starts = self.starts
        frame = whole(frame, "a frame")
        if not 0 <= frame < starts[-1]:
            raise RangeError(f"Expected a frame within 0:{starts[-1]} of the timeline, got {frame}.")
        index = bisect_right(starts, frame) - 1
        return index, self.segments[index].range.start + frame - starts[index]


def _check_retiming(clip: ClipInfo, retiming: Retiming, source: ClipInfo) -> None:
    if source.retiming is not None:
        raise ParameterError(
            f"Expected clip {clip.key!r} to retime a clip as it is, got {source.key!r}, itself retimed. "
            f"Retime {source.source!r} instead."
        )
    if not same_rate(clip.fps, source.fps):
        raise ParameterError(
            f"Expected the rate of {source.key!r} ({source.fps:g} fps) in its retimed clip {clip.key!r}, "
            f"got {clip.fps:g}."
        )
    last, end = retiming.knots[-1][1], (source.frames - 1) / source.fps
    if last > end + 1e-6 / source.fps:
        raise RangeError(
            f"Expected moments within 0 to {end:.6g} s of clip {source.key!r}, got {last:.6g} s in its retimed clip "
            f"{clip.key!r}."
        )


def _missing(key: str, known: Iterable[str]) -> MissingClipError:
    names = ", ".join(repr(name) for name in known) or "no clips"
    return MissingClipError(f"Expected a clip of the timeline ({names}), got {key!r}. Add it first.")


def timeline(clips: Mapping[str, Motion] | Iterable[ClipInfo], key: str) -> Timeline:
    """A timeline that shows one whole clip, at that clip's rate, and knows all the others.

    clips : the motions by key (only their frame counts and rates are kept), or what is known of them
    key : the clip to start from

    >>> line = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 90, 60.0)], "walk")
    >>> line.frames, line.fps, line.segment_at(20)
    (120, 30.0, (0, 20))
    """
    if isinstance(clips, Mapping):
        infos = tuple(ClipInfo(name, motion.frames, motion.fps) for name, motion in clips.items())
    else:
        infos = tuple(clips)
    for info in infos:
        if info.key == key:
            infos = (
                info,
                *(other for other in infos if other.key != key),
            )  # the original leads: its rig is the result's
            return Timeline(infos, (Segment(key, FrameRange(0, info.frames)),), (), info.fps)
    raise _missing(key, [info.key for info in infos])
