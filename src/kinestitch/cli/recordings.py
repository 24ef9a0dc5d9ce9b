"""What ``info`` tells of a laboratory's recording: markers and analog channels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from kinestitch.cli.console import console, fact_table
from kinestitch.cli.failures import warnings_as_lines


@dataclass(frozen=True, slots=True)
class RecordingFacts:
    """What is told of one recording.

    seen : share of marker-frames in which the marker was seen, 1 without markers; duration : s
    """

    file: str
    format: str
    markers: int
    marker_rate: float
    frames: int
    seen: float
    channels: int
    channel_rate: float
    samples: int
    duration: float
    marker_names: tuple[str, ...]
    channel_names: tuple[str, ...]
    channel_units: tuple[str, ...]
    warnings: tuple[str, ...]


def is_recording(path: str) -> bool:
    """Whether the suffix is one of a format that holds markers instead of a skeleton."""
    from kinestitch.files import FORMATS

    return any(Path(path).suffix.lower() in entry.suffixes for entry in FORMATS if entry.records)


def recording_facts(path: str) -> RecordingFacts:
    """Read a recording, in a child process, and count; raises what reading raises."""
    import numpy as np

    from kinestitch.files import format_of, read_recording

    oddities: list[str] = []
    keep: Callable[[str], None] = oddities.append
    with warnings_as_lines(keep):
        recording = read_recording(path, isolated=True)
    seen = ~np.isnan(recording.markers[..., 0])
    return RecordingFacts(
        file=path,
        format=format_of(path).name,
        markers=len(recording.marker_names),
        marker_rate=recording.rate,
        frames=recording.frames,
        seen=float(seen.mean()) if seen.size else 1.0,
        channels=len(recording.analog_names),
        channel_rate=recording.analog_rate,
        samples=recording.samples,
        duration=recording.duration,
        marker_names=recording.marker_names,
        channel_names=recording.analog_names,
        channel_units=recording.analog_units,
        warnings=tuple(oddities),
    )


def show_recording(told: RecordingFacts) -> None:
    """A block with one line a fact."""
    table = fact_table()
    units = zip(told.channel_names, told.channel_units, strict=True)
    rows = [
        ("file", told.file),
        ("format", told.format),
        ("duration", f"{told.duration:.3f} s"),
        ("markers", f"{told.markers}, {told.frames} frames at {told.marker_rate:g} a second, {told.seen:.1%} seen"),
        ("", ", ".join(told.marker_names)),
        ("channels", f"{told.channels}, {told.samples} samples at {told.channel_rate:g} a second"),
        ("", ", ".join(f"{name} ({unit})" if unit else name for name, unit in units)),
        *(("warning", oddity) for oddity in told.warnings),
    ]
    for name, value in rows:
        if value:
            table.add_row(name, value)
    console().print(table)
