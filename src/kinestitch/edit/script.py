"""Several edits at once, as they stand on a command line: all frames are those of the timeline before any of them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

from kinestitch.edit.operations import check_place, check_range
from kinestitch.edit.pieces import Piece, clip_piece, cut_piece, join_pieces
from kinestitch.edit.timeline import Seam, Timeline
from kinestitch.errors import ParameterError, RangeError

Kind = Literal["replace", "insert", "append", "delete"]


@dataclass(frozen=True, slots=True)
class Edit:
    """One edit of a script.

    kind : ``replace`` and ``delete`` take a range start:stop, ``insert`` a place start, ``append`` neither
    start, stop : frames of the unedited timeline
    clip, clip_start, clip_stop : what is pasted, in the clip's own frames; left out, its first frame and its end

    Raises ParameterError where something is missing or too much.
    """

    kind: Kind
    start: int | None = None
    stop: int | None = None
    clip: str | None = None
    clip_start: int | None = None
    clip_stop: int | None = None

    def __post_init__(self) -> None:
        if self.kind not in get_args(Kind):
            raise ParameterError(f"Expected one of {', '.join(get_args(Kind))}, got {self.kind!r}.")
        wanted = {"start": self.kind != "append", "stop": self.kind in {"replace", "delete"}, "clip": self.pastes}
        for name, needed in wanted.items():
            given = getattr(self, name) is not None
            if given != needed:
                told = "none" if needed else repr(getattr(self, name))
                raise ParameterError(f"Expected {'a' if needed else 'no'} {name} for {self.kind}, got {told}.")
        if not self.pastes and (self.clip_start, self.clip_stop) != (None, None):
            raise ParameterError(f"Expected no range of a clip for delete, got {self.clip_start}:{self.clip_stop}.")

    @property
    def pastes(self) -> bool:
        """Whether it brings frames of a clip in."""
        return self.kind != "delete"

    def __str__(self) -> str:
        place = {"append": ""}.get(self.kind, f" {self.start}" + ("" if self.stop is None else f":{self.stop}"))
        return self.kind + place + ("" if self.clip is None else f" {self.clip}")


@dataclass(frozen=True, slots=True)
class _Placed:
    """An edit with its range on the unedited timeline; an empty one for insert and append."""

    edit: Edit
    start: int
    stop: int


def apply_edits(timeline: Timeline, edits: Iterable[Edit], *, seam: Seam | None = None) -> Timeline:
    """The timeline after a list of edits whose frames are all those of the timeline **before** any of them.

    So nobody has to reckon what the first edit moved before writing down the second:

    ```
    before  |          A          |          replace 20:30 B, insert 60 C, delete 80:90
    after   | A |  B  |  A  | C | A | A |    every edit ripples
    ```

    Edits at the same place keep the order of the list: an insert at 60 listed before a replacement of 60:80 comes
    before the pasted piece, listed after it, it comes after that piece. Appends come last, in their order.

    seam : settings of all new seams

    Raises RangeError for overlapping edits (naming both), for an insert strictly inside a replaced or deleted range,
    for ranges that are empty or outside, and where no frame would stay.

    >>> from kinestitch.edit.timeline import ClipInfo, timeline
    >>> walk = timeline([ClipInfo("walk", 120, 30.0), ClipInfo("kick", 50, 30.0)], "walk")
    >>> line = apply_edits(walk, [Edit("insert", 60, clip="kick"), Edit("delete", 20, 40)])
    >>> " ".join(str(segment) for segment in line.segments)
    'walk@0:20 walk@40:60 kick@0:50 walk@60:120'
    """
    placed = [_place(timeline, edit) for edit in edits]
    _refuse_overlaps(placed)
    if not placed:
        return timeline
    pieces: list[Piece] = []
    done = 0
    for entry in _in_time(placed):
        if entry.start > done:
            pieces.append(cut_piece(timeline, done, entry.start))
        done = max(done, entry.stop)
        if entry.edit.clip is not None:
            pieces.append(clip_piece(timeline, entry.edit.clip, entry.edit.clip_start, entry.edit.clip_stop))
    pieces.append(cut_piece(timeline, done, timeline.frames))
    return join_pieces(timeline, pieces, seam)


def _place(timeline: Timeline, edit: Edit) -> _Placed:
    if edit.start is None:
        return _Placed(edit, timeline.frames, timeline.frames)
    if edit.stop is None:
        at = check_place(timeline, edit.start)
        return _Placed(edit, at, at)
    span = check_range(timeline, edit.start, edit.stop)
    return _Placed(edit, span.start, span.stop)


def _refuse_overlaps(placed: list[_Placed]) -> None:
    furthest: _Placed | None = None
    # Inserts come before ranges of the same start, so that whatever starts before the furthest stop lies inside.
    for entry in sorted(placed, key=lambda entry: (entry.start, entry.stop)):
        if furthest is not None and entry.start < furthest.stop:
            raise RangeError(
                f"Expected edits of separate frames, got '{furthest.edit}' and '{entry.edit}'. "
                "All frames are those of the unedited timeline; shorten or move one of them."
            )
        if furthest is None or entry.stop > furthest.stop:
            furthest = entry


def _in_time(placed: list[_Placed]) -> list[_Placed]:
    """In the order of the result: by place, at one place by the list, appends last."""
    return sorted(placed, key=lambda entry: (entry.edit.kind == "append", entry.start))


def parse_range(text: str) -> tuple[int | None, int | None]:
    """The two frame numbers of ``60:110``, None for an end that is left out; raises ParameterError for anything else.

    >>> parse_range("60:110"), parse_range("60:")
    ((60, 110), (60, None))
    """
    match = re.fullmatch(r"\s*([0-9]{0,18}):([0-9]{0,18})\s*", text)
    if match is None:
        raise ParameterError(f"Expected a range START:STOP such as 60:110, got {text!r}.")
    return int(match[1]) if match[1] else None, int(match[2]) if match[2] else None


def parse_source(text: str) -> tuple[str, int | None, int | None]:
    """Path, start and stop of ``PATH@START:STOP``; either end, or the whole ``@…``, may be left out.

    Only a trailing ``@a:b`` counts, since file names contain ``@``. Raises ParameterError where no path is left.

    >>> parse_source("walk@2.fbx@20:75"), parse_source("walk@2.fbx"), parse_source("walk.bvh@:75")
    (('walk@2.fbx', 20, 75), ('walk@2.fbx', None, None), ('walk.bvh', None, 75))
    """
    match = re.fullmatch(r"(.*)@([0-9]{0,18}):([0-9]{0,18})", text, re.DOTALL)
    path, start, stop = (match[1], match[2], match[3]) if match else (text, "", "")
    if not path:
        raise ParameterError(f"Expected PATH@START:STOP such as kick.fbx@20:75, got {text!r}.")
    return path, int(start) if start else None, int(stop) if stop else None
