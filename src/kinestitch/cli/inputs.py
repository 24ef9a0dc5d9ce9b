"""Clips and edits as they are named on a command line: every file is read once, whatever it is called by."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinestitch.cli.failures import tell, warnings_as_lines
from kinestitch.cli.outputs import DOCUMENT
from kinestitch.errors import DocumentError, RangeError

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.edit import Timeline


@dataclass(frozen=True, slots=True)
class Opened:
    """An edit whose clips are read.

    timeline : the edit; clips : key → motion; sources : key → path
    """

    timeline: Timeline
    clips: dict[str, Motion]
    sources: dict[str, str]


def is_document(path: str) -> bool:
    """Whether a path names an edit document rather than a clip."""
    return Path(path).suffix.lower() == DOCUMENT


def read_clip(path: str, warn: Callable[[str], None] | None = None, **options: Any) -> Motion:
    """Read a clip; each warning is told with the file's name, on stderr unless `warn` takes it."""
    from kinestitch.files import read

    def show(text: str) -> None:
        named = text if path in text else f"{text} ({path})"
        if warn is None:
            tell("warning", named)
        else:
            warn(text)

    with warnings_as_lines(show):
        return read(path, **options)


class Library:
    """The clips of one call, by key: a file's stem, numbered where two files share it."""

    def __init__(self, step: Callable[[str], None]) -> None:
        self.clips: dict[str, Motion] = {}
        self.sources: dict[str, str] = {}
        self._keys: dict[str, str] = {}
        self._taken: set[str] = set()
        self._read: dict[str, Motion] = {}
        self._step = step

    def add(self, path: str) -> str:
        """The key of a file, which is read if it is new."""
        place = os.path.realpath(path)
        motion = self._motion(path)
        if place not in self._keys:
            self._name(self._free_key(Path(path).stem), path)
        key = self._keys[place]
        self.clips[key] = motion
        return key

    def open(self, path: str, take: str | None = None) -> Opened:
        """A clip as a timeline that shows all of it, or an edit document with the clips it shows.

        take : which one of the clip's file; the file stands for this take wherever it is used

        Raises what reading raises, DocumentError for a clip whose file is not told, RangeError for one that is no
        longer as the document says.
        """
        from kinestitch.edit.timeline import timeline

        if is_document(path):
            return Opened(self._document(path), self.clips, self.sources)
        self._motion(path, take)
        key = self.add(path)
        return Opened(timeline(self.clips, key), self.clips, self.sources)

    def _motion(self, path: str, take: str | None = None) -> Motion:
        place = os.path.realpath(path)
        if place not in self._read:
            self._step(f"reading {Path(path).name}")
            self._read[place] = read_clip(path) if take is None else read_clip(path, take=take)
        return self._read[place]

    def _free_key(self, stem: str) -> str:
        count, key = 1, stem
        while key in self._taken:
            count += 1
            key = f"{stem} {count}"
        return key

    def _name(self, key: str, path: str) -> None:
        self._taken.add(key)
        self.sources[key] = path
        self._keys.setdefault(os.path.realpath(path), key)

    def _probe(self, path: str) -> tuple[int, float]:
        motion = self._motion(path)
        return motion.frames, motion.fps

    def _document(self, path: str) -> Timeline:
        from kinestitch.edit import load_document

        document = load_document(path, probe=self._probe)
        self._taken.update(info.key for info in document.timeline.clips)
        for key, source in document.sources.items():
            self._name(key, source)
        line = document.timeline
        for key in dict.fromkeys(line.clip(segment.clip).source for segment in line.segments):
            source = document.sources.get(key, "")
            if not source or "://" in source:
                told = f"got {source}" if source else "got none"
                raise DocumentError(f"Expected a file for clip {key!r}, {told}. Save the edit with it. ({path})")
            self.clips[key] = self._motion(source)
            self._compare(line, key, path)
        return line

    def _compare(self, timeline: Timeline, key: str, path: str) -> None:
        from kinestitch.core.resample import same_rate

        info, motion = timeline.clip(key), self.clips[key]
        if info.frames != motion.frames or not same_rate(info.fps, motion.fps):
            raise RangeError(
                f"Expected {info.frames} frames at {info.fps:g} fps in clip {key!r}, as {Path(path).name} says, "
                f"got {motion.frames} at {motion.fps:g} fps. Save the edit anew. ({self.sources[key]})"
            )
