"""Edits as ``.otio`` files, which other editorial programs open.

Clips are external references, and all settings of ours stand under one metadata key. The one door to OpenTimelineIO,
which is imported only when a document is saved or loaded.
"""

from __future__ import annotations

import os
import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinestitch.core.atomic import replacing
from kinestitch.edit.foreign import Probe, Span, Strip, assemble
from kinestitch.edit.locations import to_url
from kinestitch.edit.schema import SCHEMA, Own, checked, clip_data, pin_data, seam_data
from kinestitch.edit.sieve import KEY, opened, sieved_text
from kinestitch.edit.timeline import ClipInfo, Timeline
from kinestitch.errors import DocumentError, KinestitchError, KinestitchWarning, MissingClipError, ParameterError


@dataclass(frozen=True, slots=True)
class Document:
    """What a document holds.

    timeline : the edit
    sources : clip key → absolute path or URL, for the clips whose place is known
    """

    timeline: Timeline
    sources: Mapping[str, str]


def save_document(
    timeline: Timeline,
    path: str | os.PathLike[str],
    *,
    sources: Mapping[str, str | os.PathLike[str]] | None = None,
    base: str | os.PathLike[str] | None = None,
) -> None:
    """Save an edit as an ``.otio`` document; an existing one is replaced only by a complete new one.

    sources : clip key → path or URL; a clip without one is saved as a missing reference, a retimed one has its source's
    base : the folder from which relative paths in `sources` count, by default the current one

    Paths are written relative to the document where that is possible, so that a folder can be moved as a whole.
    Raises MissingClipError for a source of an unknown clip, OutputError where the file cannot be written.
    """
    import opentimelineio as otio

    target = Path(path)
    keys = {info.key for info in timeline.clips}
    for key in sources or {}:
        if key not in keys:
            raise MissingClipError(
                f"Expected sources of the timeline's clips, got one for {key!r}. Add the clip first."
            )
        if timeline.clip(key).source != key:
            raise ParameterError(
                f"Expected no source for the retimed clip {key!r}. Name the one of {timeline.clip(key).source!r}."
            )
    for key in keys:
        if not _is_text(key):
            raise ParameterError(f"Expected clip keys of proper letters, got {key!r}. Choose another key.")
    root = Path.cwd() if base is None else Path.cwd() / base
    urls = {key: to_url(source, target.parent, root) for key, source in (sources or {}).items()}
    text = _to_otio(otio, timeline, urls, target.stem if _is_text(target.stem) else "").to_json_string()
    with replacing(target) as stream:
        stream.write(text.encode())
        stream.write(b"\n")


def _is_text(key: str) -> bool:
    return not any(letter == "\0" or "\ud800" <= letter <= "\udfff" for letter in key)


def _to_otio(otio: Any, timeline: Timeline, urls: Mapping[str, str], name: str) -> Any:
    from kinestitch import __version__

    own = {
        "schema": SCHEMA,
        "written_by": f"kinestitch {__version__}",
        "fps": timeline.fps,
        "clips": [clip_data(info, urls.get(info.key)) for info in timeline.clips],
    }
    if not timeline.foot_lock:
        own["foot_lock"] = False
    line = otio.schema.Timeline(name, metadata={KEY: own})
    # A track's kind may be any text, but other programs ask for Video or Audio and pass over the rest.
    track = otio.schema.Track("motion", kind=otio.schema.TrackKind.Video, metadata={KEY: {"kind": "motion"}})
    line.tracks.append(track)
    starts = timeline.starts
    for index, segment in enumerate(timeline.segments):
        info = timeline.clip(segment.clip)
        own = {"clip": info.key}
        if index:
            # The seam in front of a segment travels with it when another program moves, adds or removes segments, and
            # so do its pins.
            own["seam"] = seam_data(timeline.seams[index - 1])
        start = starts[index]
        pins = [pin for pin in timeline.pins if start <= pin.frame < start + len(segment)]
        if pins:
            own["pins"] = [pin_data(pin, segment.range.start - start) for pin in pins]
        used = _otio_range(otio, segment.range.start, len(segment), timeline.fps)
        media = _otio_media(otio, info, urls.get(info.source))
        track.append(otio.schema.Clip(info.key, media, used, metadata={KEY: own}))
    return line


def _otio_range(otio: Any, start: int, length: int, rate: float) -> Any:
    return otio.opentime.TimeRange(otio.opentime.RationalTime(start, rate), otio.opentime.RationalTime(length, rate))


def _otio_media(otio: Any, info: ClipInfo, url: str | None) -> Any:
    available = _otio_range(otio, 0, info.frames, info.fps)
    if url is None:
        return otio.schema.MissingReference(available_range=available)
    return otio.schema.ExternalReference(target_url=url, available_range=available)


def load_document(path: str | os.PathLike[str], *, probe: Probe | None = None) -> Document:
    """Load an edit from an ``.otio`` document, ours or another program's.

    probe : tells (frames, fps) of a file; asked about clips of other programs that do not say how long they are

    A document without our settings gets default seams; gaps close up, and transitions, effects, disabled clips, tracks
    of other kinds and settings that this version does not know are left out, with one KinestitchWarning that counts
    them. Raises DocumentError for a damaged document, one of a newer version, nested or several tracks;
    FileNotFoundError.
    """
    source = Path(path)
    ignored: Counter[str] = Counter()
    try:
        own, strips = _from_otio(_parse(sieved_text(source)), ignored)
        timeline, sources = assemble(own, strips, source.parent, probe, ignored)
    except OSError:
        raise
    except Exception as error:  # whatever a damaged document provokes, in here or inside OpenTimelineIO
        told = str(error) if isinstance(error, KinestitchError) else f"Expected a sound document, got {error!r}."
        raise DocumentError(f"{' '.join(told.split())} ({source})") from error
    counts = ", ".join(f"{count} × {what}" for what, count in sorted(ignored.items()) if count)
    if counts:
        warnings.warn(f"Left out of the document: {counts}. ({source})", KinestitchWarning, stacklevel=2)
    return Document(timeline, sources)


def _parse(text: str) -> Any:
    import opentimelineio as otio

    try:
        root = otio.adapters.read_from_string(text, "otio_json")
    except Exception as error:
        raise DocumentError(f"Expected an OpenTimelineIO document, got one it refuses: {error}") from error
    if isinstance(root, otio.schema.SerializableCollection) and len(root) == 1:
        root = root[0]
    if not isinstance(root, otio.schema.Timeline) or root.tracks is None:
        raise DocumentError(f"Expected an OpenTimelineIO timeline, got {type(root).__name__}.")
    return root


def _from_otio(line: Any, ignored: Counter[str]) -> tuple[Own | None, list[Strip]]:
    import opentimelineio as otio

    tracks = []
    for track in line.tracks:
        if not isinstance(track, otio.schema.Track):
            raise DocumentError(f"Expected tracks, got a nested {type(track).__name__}. Flatten it first.")
        if track.kind == otio.schema.TrackKind.Video:
            tracks.append(track)
        else:
            ignored[f"{track.kind.lower() or 'nameless'} track"] += len(track) > 0
    tracks = [track for track in tracks if len(track) > 0]
    if len(tracks) != 1:
        raise DocumentError(f"Expected one video track with clips, got {len(tracks)}. Merge them into one first.")
    _check_untrimmed(tracks[0])
    strips = [strip for item in tracks[0] if (strip := _strip(otio, item, ignored)) is not None]
    if KEY not in line.metadata:
        return None, strips
    return Own(_own(line), [strip.own for strip in strips]), strips


def _own(item: Any) -> dict[str, Any]:
    return checked(opened(item.metadata.get(KEY)), dict, "the metadata 'kinestitch'")


def _check_untrimmed(track: Any) -> None:
    if track.source_range is not None:
        shown, there = _span(track.source_range), _span(track.available_range())
        frames = there.length * shown.rate / there.rate
        if abs(shown.start) > 0.5 or shown.length < frames - 0.5:
            raise DocumentError("Expected a whole track, got one that shows only a part of it. Trim its clips instead.")


def _strip(otio: Any, item: Any, ignored: Counter[str]) -> Strip | None:
    """One clip of the track, or None where there is nothing to show."""
    if isinstance(item, otio.schema.Gap):
        ignored["gap"] += item.duration().value > 0
        return None
    if isinstance(item, otio.schema.Transition):
        ignored["transition"] += 1
        return None
    if not isinstance(item, otio.schema.Clip):
        raise DocumentError(f"Expected clips, got a nested {type(item).__name__} {item.name!r}. Flatten it first.")
    if not item.enabled:
        ignored["disabled clip"] += 1
        return None
    ignored["effect"] += len(item.effects)
    media = item.media_reference
    return Strip(
        item.name,
        media.target_url if isinstance(media, otio.schema.ExternalReference) else None,
        None if item.source_range is None else _span(item.source_range),
        None if media is None or media.available_range is None else _span(media.available_range),
        _own(item),
    )


def _span(time_range: Any) -> Span:
    start, length = time_range.start_time, time_range.duration
    return Span(
        start.rescaled_to(length.rate).value if start.rate != length.rate else start.value, length.value, length.rate
    )
