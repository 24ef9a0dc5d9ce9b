"""What ``info`` tells of an edit document: its segments, its seams, and where its clips are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from kinestitch.cli.console import console, counted, fact_table
from kinestitch.cli.failures import warnings_as_lines


@dataclass(frozen=True, slots=True)
class SegmentFacts:
    """A stretch of one clip: `start` is its frame in the result, `first` and `stop` its frames in the clip."""

    start: int
    clip: str
    first: int
    stop: int


@dataclass(frozen=True, slots=True)
class SeamFacts:
    """A seam before `frame` of the result; smoothing : s; stiffness : λ at the edit's rate."""

    frame: int
    smoothing: float
    stiffness: float


@dataclass(frozen=True, slots=True)
class SourceFacts:
    """A clip of the edit; file : empty where the document names none; found : whether the file is there."""

    clip: str
    file: str
    found: bool
    frames: int
    fps: float


@dataclass(frozen=True, slots=True)
class EditFacts:
    """What is told of one edit document. duration : s from the first frame to the last; pins : as on a command line"""

    file: str
    format: str
    fps: float
    frames: int
    duration: float
    segments: tuple[SegmentFacts, ...]
    seams: tuple[SeamFacts, ...]
    sources: tuple[SourceFacts, ...]
    pins: tuple[str, ...]
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
    stiffness = [seam.lambda_at(line.fps) for seam in line.seams]
    files = {clip.key: document.sources.get(clip.key, "") for clip in line.clips}
    return EditFacts(
        file=path,
        format="edit (OpenTimelineIO)",
        fps=line.fps,
        frames=line.frames,
        duration=(line.frames - 1) / line.fps,
        segments=tuple(
            SegmentFacts(start, segment.clip, segment.range.start, segment.range.stop)
            for start, segment in zip(starts, line.segments, strict=False)
        ),
        seams=tuple(
            SeamFacts(frame, value**0.25 / line.fps, value)
            for frame, value in zip(starts[1:-1], stiffness, strict=True)
        ),
        sources=tuple(
            SourceFacts(clip.key, files[clip.key], Path(files[clip.key]).is_file(), clip.frames, clip.fps)
            for clip in line.clips
        ),
        pins=tuple(map(str, line.pins)),
        warnings=tuple(oddities),
    )


def show_edit_facts(told: EditFacts) -> None:
    """A block with one line a fact."""
    table = fact_table()
    rows = [
        ("file", told.file),
        ("format", told.format),
        ("frame rate", f"{told.fps:g} fps"),
        ("frames", f"{told.frames}, numbered 0 to {told.frames - 1}"),
        ("duration", f"{told.duration:.3f} s"),
        *(("segment", f"from {part.start}: {part.clip} {part.first}:{part.stop}") for part in told.segments),
        *(
            ("seam", f"before {seam.frame}: smoothing {seam.smoothing:.3g} s (λ = {seam.stiffness:.4g})")
            for seam in told.seams
        ),
        *(("pin", pin) for pin in told.pins),
        *(("clip", _source(source)) for source in told.sources),
        *(("warning", oddity) for oddity in told.warnings),
    ]
    for name, value in rows:
        table.add_row(name, value)
    console().print(table)


def _source(source: SourceFacts) -> str:
    size = f"{source.clip}: {counted(source.frames, 'frame')}, {source.fps:g} fps"
    if not source.file:
        return f"{size}, no file named"
    return f"{size}, {source.file}" + ("" if source.found or "://" in source.file else " (not found)")
