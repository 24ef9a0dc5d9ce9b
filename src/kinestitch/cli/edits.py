"""What ``info`` tells of an edit document: its segments, its seams, and where its clips are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from kinestitch.cli.console import console, counted, fact_table
from kinestitch.cli.failures import warnings_as_lines

if TYPE_CHECKING:
    from kinestitch.edit import ClipInfo, Segment, Timeline


@dataclass(frozen=True, slots=True)
class SegmentFacts:
    """A stretch of one clip: `start` is its frame in the result, `first` and `stop` its frames in the clip.

    slowest, fastest : speed at which it shows the clip's source; 1 for a clip as it is
    """

    start: int
    clip: str
    first: int
    stop: int
    slowest: float
    fastest: float


@dataclass(frozen=True, slots=True)
class SeamFacts:
    """A seam before `frame` of the result; smoothing : s; stiffness : λ at the edit's rate; None where `automatic`."""

    frame: int
    smoothing: float | None
    stiffness: float | None
    automatic: bool


@dataclass(frozen=True, slots=True)
class SourceFacts:
    """A clip of the edit; file : empty where the document names none; found : whether the file is there.

    retimes : the clip that this one shows at another speed, empty for a clip as it is
    """

    clip: str
    file: str
    found: bool
    frames: int
    fps: float
    retimes: str


@dataclass(frozen=True, slots=True)
class ReturnFacts:
    """From `frame` of the result on, `clip` is where it was before the edit; seconds : how long the way there takes."""

    frame: int
    clip: str
    seconds: float


@dataclass(frozen=True, slots=True)
class EditFacts:
    """What is told of one edit document. duration : s from the first frame to the last; pins : as on a command line;
    returns : more of those pins that are one
    """

    file: str
    format: str
    fps: float
    frames: int
    duration: float
    segments: tuple[SegmentFacts, ...]
    seams: tuple[SeamFacts, ...]
    sources: tuple[SourceFacts, ...]
    pins: tuple[str, ...]
    returns: tuple[ReturnFacts, ...]
    foot_lock: bool
    warnings: tuple[str, ...]


def edit_facts(path: str) -> EditFacts:
    """Read a document, without its clips where it says how long they are; raises what loading raises."""
    from kinestitch.cli.inputs import read_clip
    from kinestitch.edit import load_document

    def probe(clip: str) -> tuple[int, float]:
        motion = read_clip(clip)
        return motion.frames, motion.fps

    oddities: list[str] = []
    with warnings_as_lines(oddities.append):
        document = load_document(path, probe=probe)
    line, starts = document.timeline, document.timeline.starts
    stiffness = [None if seam.automatic else seam.lambda_at(line.fps) for seam in line.seams]
    return EditFacts(
        file=path,
        format="edit (OpenTimelineIO)",
        fps=line.fps,
        frames=line.frames,
        duration=(line.frames - 1) / line.fps,
        segments=tuple(
            SegmentFacts(start, segment.clip, segment.range.start, segment.range.stop, *_speeds(line, segment))
            for start, segment in zip(starts, line.segments, strict=False)
        ),
        seams=tuple(
            SeamFacts(frame, None if value is None else value**0.25 / line.fps, value, value is None)
            for frame, value in zip(starts[1:-1], stiffness, strict=True)
        ),
        sources=tuple(_source_facts(clip, document.sources.get(clip.source, "")) for clip in line.clips),
        pins=tuple(map(str, line.pins)),
        returns=tuple(
            ReturnFacts(pin.frame, line.segments[line.segment_at(pin.frame)[0]].clip, pin.smoothing or 0.0)
            for pin in line.pins
            if pin.kind == "return"
        ),
        foot_lock=line.foot_lock,
        warnings=tuple(oddities),
    )


def _source_facts(clip: ClipInfo, file: str) -> SourceFacts:
    retimed = "" if clip.retiming is None else clip.source
    return SourceFacts(clip.key, file, Path(file).is_file(), clip.frames, clip.fps, retimed)


def show_edit_facts(told: EditFacts) -> None:
    """A block with one line a fact."""
    table = fact_table()
    rows = [
        ("file", told.file),
        ("format", told.format),
        ("frame rate", f"{told.fps:g} fps"),
        ("frames", f"{told.frames}, numbered 0 to {told.frames - 1}"),
        ("duration", f"{told.duration:.3f} s"),
        *((f"segment {number}", _segment(part)) for number, part in enumerate(told.segments, start=1)),
        *(
            (f"seam {number}", f"before {seam.frame}: {_smoothing(seam)}")
            for number, seam in enumerate(told.seams, start=1)
        ),
        *(("pin", _pin(pin, told.returns)) for pin in told.pins),
        *(() if told.foot_lock else (("feet", "not locked"),)),
        *(("clip", _source(source)) for source in told.sources),
        *(("warning", oddity) for oddity in told.warnings),
    ]
    for name, value in rows:
        table.add_row(name, value)
    console().print(table)


def _smoothing(seam: SeamFacts) -> str:
    if seam.smoothing is None:
        return "smoothing automatic"
    return f"smoothing {seam.smoothing:.3g} s (λ = {seam.stiffness:.4g})"


def _pin(text: str, returns: tuple[ReturnFacts, ...]) -> str:
    """A pin as on a command line; of a return, what it does."""
    for home in returns:
        if text == f"return@{home.frame}":
            where = f"{home.clip} is where it was before the edit"
            return f"{text}: from there on {where}, after a way back of {home.seconds:.3g} s"
    return text


def _speeds(line: Timeline, segment: Segment) -> tuple[float, float]:
    """The slowest and the fastest speed between two frames of a segment."""
    import numpy as np

    from kinestitch.core.retime import time_map

    retiming, shown = line.clip(segment.clip).retiming, segment.range
    if retiming is None or len(retiming.knots) == 2:
        return (1.0, 1.0) if retiming is None else retiming.speeds
    times = np.arange(shown.start, max(shown.stop, shown.start + 2)) / line.fps
    each = np.diff(time_map(retiming.knots, times)) * line.fps
    return float(each.min()), float(each.max())


def _segment(part: SegmentFacts) -> str:
    """Which frames of which clip a segment shows, and how fast."""
    text = f"from {part.start}: {part.clip} {part.first}:{part.stop}"
    slowest, fastest = f"{part.slowest:.3g}", f"{part.fastest:.3g}"
    if slowest == fastest:
        is_told = slowest == "1" or part.clip.endswith(f" ×{part.slowest:g}")
        return text if is_told else f"{text} at {slowest} × speed"
    return f"{text} at {slowest} to {fastest} × speed"


def _source(source: SourceFacts) -> str:
    size = f"{source.clip}: {counted(source.frames, 'frame')}, {source.fps:g} fps"
    if source.retimes:
        return f"{size}, {source.retimes} retimed"
    if not source.file:
        return f"{size}, no file named"
    return f"{size}, {source.file}" + ("" if source.found or "://" in source.file else " (not found)")
