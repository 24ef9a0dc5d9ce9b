"""The video: motions side by side on a ground that passes under them, with trails of the feet and a glow at seams."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.motion import Motion
from kinestitch.errors import ParameterError, RangeError, UnsupportedFormatError
from kinestitch.render.canvas import Canvas
from kinestitch.render.encoder import encoder_library, encoding
from kinestitch.render.paint import GROUND, PASTED, SEAM, STANDS, Stretch
from kinestitch.render.stage import STYLES, Actor, Body, Panel, Style, cast, grid_step, panels
from kinestitch.solve.contacts import Contacts

FASTEST = 60.0
"""Pictures a second at most, unless more are asked for."""
_INK, _GREY = "#222222", "#6b7178"


@dataclass(frozen=True, eq=False, slots=True)
class Film:
    """A video before it is drawn: its panels, size, number of pictures, and how much time lies between them.

    step : seconds of the motions between two pictures; fps : pictures a second
    """

    panels: tuple[Panel, ...]
    size: tuple[int, int]
    count: int
    step: float
    fps: float


def video(
    motions: Motion | Sequence[Motion],
    path: str | os.PathLike[str],
    *,
    progress: Callable[[int, int], None] | None = None,
    **options: Any,
) -> None:
    """Write an MP4 (H.264) of one motion or several side by side; options as in :func:`film`.

    progress : called with the number of pictures done and of all, after each

    Raises UnsupportedFormatError for another suffix, MissingExtraError without the extra ``video``, OutputError where
    the file cannot be written, and what :func:`film` raises.
    """
    suffix = Path(path).suffix
    if suffix.lower() != ".mp4":
        found = repr(suffix) if suffix else "no suffix"
        raise UnsupportedFormatError(f"Expected a video that ends in .mp4, got {found}. ({path})")
    encoder_library()
    made = film(motions, **options)
    with encoding(path, made.size, made.fps) as take:
        for number, picture in enumerate(pictures(made)):
            take(picture)
            if progress is not None:
                progress(number + 1, made.count)


def film(
    motions: Motion | Sequence[Motion],
    *,
    labels: Sequence[str] | None = None,
    seams: Sequence[int] | Sequence[Sequence[int]] = (),
    segments: Sequence[Sequence[tuple[Any, ...] | Stretch]] | None = None,
    view: str | float = "three-quarter",
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    speed: float = 1.0,
    bodies: Sequence[Body | None] | None = None,
    contacts: Sequence[Contacts | None] | None = None,
    style: Style = "mannequin",
) -> Film:
    """Lay a video out: left limbs blue, right limbs orange, all motions from their first frame on.

    motions : of any skeleton; those of one skeleton and length share one camera, others are followed each by its own
    labels : one a motion; without them, the motions' names
    seams : frames at which the ground glows, for all motions, or one list a motion
    segments : ``(start, stop[, label[, colour]])`` a motion, half-open frames: where a result shows another clip
    view : ``front``, ``side``, ``three-quarter``, ``back``, or the camera's azimuth in degrees (0 front, 90 side)
    size : width and height in pixels, even numbers of at least 64; without it 540 high and 480 wide for each motion
    fps : pictures a second; without it those of the fastest motion, 60 at most. Pictures show the frame that is nearest
        in time, nothing between frames; a motion that ends holds its last pose
    speed : 0.25 shows everything four times as slowly
    bodies : a :class:`kinestitch.render.skinned.Character` instead of the mannequin, or None, one a motion
    contacts : when the feet stand, as :func:`kinestitch.solve.contacts.find_contacts` tells it, or None, one a motion:
        what stands is drawn in green
    style : ``mannequin``, or ``skeleton`` for bare bones and joints

    Raises ParameterError (no motion, unknown view or style, a size, fps or speed outside its domain, lists of another
    length than the motions, contacts of another length than theirs) and RangeError (a seam or segment outside its
    motion).
    """
    rows = [motions] if isinstance(motions, Motion) else list(motions)
    if not rows:
        raise ParameterError("Expected at least one motion, got none.")
    width, height = _checked_size((max(720, 480 * len(rows)), 540) if size is None else size)
    rate = _positive("fps", min(max(motion.fps for motion in rows), FASTEST) if fps is None else fps)
    step = _positive("speed", speed) / rate
    marks = _each_its_own(seams, len(rows))
    stretches = [()] * len(rows) if segments is None else segments
    lists = {"labels": labels, "seams": marks, "segments": stretches, "bodies": bodies, "contacts": contacts}
    for what, given in lists.items():
        if given is not None and len(given) != len(rows):
            raise ParameterError(f"Expected {what} for {len(rows)} motions, got {len(given)}.")
    if style not in STYLES:
        raise ParameterError(f"Expected a style out of {', '.join(STYLES)}, got {style!r}.")
    actors = cast(
        rows,
        view,
        labels=[motion.name for motion in rows] if labels is None else labels,
        seams=[tuple(sorted(row)) for row in marks],
        segments=[tuple(s if isinstance(s, Stretch) else Stretch(*s) for s in row) for row in stretches],
        bodies=[None] * len(rows) if bodies is None else bodies,
        contacts=[None] * len(rows) if contacts is None else contacts,
        style=style,
    )
    for actor in actors:
        _check_frames(actor)
    text = _text_size(width / len(rows), height)
    placed = panels(actors, (width, height), above=3.2 * text, below=3.4 * text)
    seconds = max(motion.frames / motion.fps for motion in rows)
    return Film(tuple(placed), (width, height), max(1, math.ceil(seconds / step - 1e-6)), step, rate)


def pictures(made: Film) -> Iterator[NDArray[np.uint8]]:
    """The pictures of a film, (height, width, 4) RGBA each; one array, which the next picture overwrites."""
    canvas = Canvas(*made.size)
    _draw_background(canvas, made)
    canvas.keep()
    for number in range(made.count):
        canvas.restore()
        for panel in made.panels:
            motion = panel.actor.motion
            frame = min(int(number * made.step * motion.fps + 0.5 + 1e-9), motion.frames - 1)
            panel.draw(canvas, frame)
            _draw_words(canvas, made, panel, frame)
        yield canvas.pixels()


def _each_its_own(seams: Sequence[Any], count: int) -> list[Sequence[int]]:
    flat = all(isinstance(seam, int | np.integer) for seam in seams)
    return [list(seams)] * count if flat else [list(row) for row in seams]


def _positive(what: str, value: float) -> float:
    if not (math.isfinite(value) and value > 0):
        raise ParameterError(f"Expected {what} > 0, got {value}.")
    return float(value)


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    width, height = (int(side) for side in size)
    if min(width, height) < 64 or max(width, height) > 8192 or width % 2 or height % 2:
        raise ParameterError(f"Expected a size of even numbers from 64 to 8192, got {width}x{height}.")
    return width, height


def _check_frames(actor: Actor) -> None:
    stretched = [frame for stretch in actor.segments for frame in (stretch.start, stretch.stop)]
    for frame in (*actor.seams, *stretched):
        if not 0 <= frame <= actor.motion.frames:
            raise RangeError(f"Expected a frame in [0, {actor.motion.frames}], got {frame}. ({actor.label})")
    held = actor.motion.frames if actor.contacts is None else len(actor.contacts.held)
    if held != actor.motion.frames:
        raise ParameterError(f"Expected contacts for {actor.motion.frames} frames, got {held}. ({actor.label})")


def _text_size(width: float, height: float) -> float:
    """Pixels of a label's letters."""
    return max(min(height / 30, width / 22), 7.0)


def _bar(made: Film, panel: Panel) -> tuple[float, float, float]:
    """The time line under a panel: its left and right end and its height above the picture's lower edge."""
    text = _text_size(panel.width, made.size[1])
    return panel.left + 1.2 * text, panel.left + panel.width - 1.2 * text, 1.1 * text


def _draw_background(canvas: Canvas, made: Film) -> None:
    """What stays the same in all pictures: labels and time lines."""
    for number, panel in enumerate(made.panels):
        actor, text = panel.actor, _text_size(panel.width, made.size[1])
        left, right, y = _bar(made, panel)
        if number:
            edge = np.array([[panel.left, 0.06 * canvas.height], [panel.left, 0.94 * canvas.height]])
            canvas.lines(edge, "#e3e6ea", width=1)
        words = canvas.fitting(actor.label, right - left, size=text, bold=True)
        canvas.text(left, canvas.height - 1.9 * text, words, size=text, colour=_INK, bold=True)
        scale = f"grid {grid_step(actor.height):g} m"
        small = 0.62 * text
        canvas.text(right - canvas.text_width(scale, size=small), y + 0.75 * text, scale, size=small, colour=_GREY)
        if actor.contacts is not None and actor.body is None:
            middle, words = (left + right) / 2, "stands"
            canvas.shapes(np.array([middle - 0.6 * small, y + 1.0 * text]) + 0.4 * small * _DOT, STANDS)
            canvas.text(middle, y + 0.75 * text, words, size=small, colour=_GREY)
        canvas.lines(np.array([[left, y], [right, y]]), GROUND, width=0.16 * text)
        for index, stretch in enumerate(actor.segments):
            ends = np.array([[_at(panel, made, stretch.start), y], [_at(panel, made, stretch.stop), y]])
            canvas.lines(ends, stretch.colour or PASTED[index % len(PASTED)], width=0.3 * text)
        for seam in actor.seams:
            x = _at(panel, made, seam)
            canvas.lines(np.array([[x, y - 0.35 * text], [x, y + 0.35 * text]]), SEAM, width=0.1 * text)


def _at(panel: Panel, made: Film, frame: float) -> float:
    """Where a frame stands on the time line."""
    left, right, _ = _bar(made, panel)
    return left + (right - left) * frame / max(panel.actor.motion.frames - 1, 1)


def _draw_words(canvas: Canvas, made: Film, panel: Panel, frame: int) -> None:
    actor, text = panel.actor, _text_size(panel.width, made.size[1])
    left, right, y = _bar(made, panel)
    x = _at(panel, made, frame)
    canvas.shapes(np.array([x, y]) + 0.26 * text * _DOT, _INK)
    canvas.text(left, y + 0.75 * text, f"frame {frame}", size=0.72 * text, colour=_GREY)
    here = actor.segment_at(frame)
    under = canvas.height - 3.0 * text
    if here is not None and here[0].label:
        words = canvas.fitting(here[0].label, right - left - 4 * text, size=0.8 * text)
        canvas.text(left, under, words, size=0.8 * text, colour=here[1])
    glow = actor.glow(frame)
    if glow > 0:
        words = "seam"
        place = right - canvas.text_width(words, size=0.8 * text, bold=True)
        canvas.text(place, under, words, size=0.8 * text, colour=SEAM, bold=True, alpha=glow)


_DOT = np.stack([np.cos(np.arange(16) * np.pi / 8), np.sin(np.arange(16) * np.pi / 8)], axis=1)
