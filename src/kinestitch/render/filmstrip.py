"""The filmstrip: posed figures over time, one row a motion, as in a paper's figure."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinestitch.core.atomic import replacing
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.errors import ParameterError, RangeError, UnsupportedFormatError
from kinestitch.render.mannequin import body_height, hull, mannequin, with_tips
from kinestitch.render.paint import GROUND, PASTED, SEAM, SHADOW, Stretch, body_positions, painted
from kinestitch.render.view import View, facing, view_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TALLEST = 2.4
"""Inches that a body height takes at most, however few poses there are."""
OUTLINED = 0.6
"""Inches of a body height from which outlines have their full width."""
SUFFIXES = (".png", ".svg", ".pdf")
GLYPH = 0.74 / 72
"""Inches that a letter takes a point of its font size, generously."""


@dataclass(frozen=True, eq=False, slots=True)
class _Row:
    motion: Motion
    frames: Array
    paper: Array
    ground: Array
    height: float
    label: str
    marks: tuple[int, ...]
    segments: tuple[Stretch, ...]


def filmstrip(motions: Motion | Sequence[Motion], path: str | os.PathLike[str], **options: Any) -> None:
    """Write the filmstrip of one motion or several to a PNG, SVG or PDF file; options as in :func:`filmstrip_figure`.

    Raises UnsupportedFormatError for another suffix, OutputError where the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        found = repr(suffix) if suffix else "no suffix"
        raise UnsupportedFormatError(f"Expected a picture that ends in {', '.join(SUFFIXES)}, got {found}. ({path})")
    figure = filmstrip_figure(motions, **options)
    with replacing(path) as stream:
        stream.write(_rendered(figure, suffix[1:]))


def _rendered(figure: Figure, kind: str) -> bytes:
    """The picture as bytes, the same every time: text stays text in SVG, and no date is written."""
    from matplotlib import rc_context

    memory = io.BytesIO()
    dates = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "kinestitch", "pdf.fonttype": 42}):
        figure.savefig(memory, format=kind, metadata=dates[kind], facecolor="white")
    return memory.getvalue()


def filmstrip_figure(
    motions: Motion | Sequence[Motion],
    *,
    poses: int | Sequence[int] = 9,
    labels: Sequence[str] | None = None,
    marks: Sequence[Sequence[int]] | None = None,
    segments: Sequence[Sequence[tuple[Any, ...] | Stretch]] | None = None,
    view: str | float = "three-quarter",
    travel: bool = False,
    title: str | None = None,
    width: float = 10.0,
    dpi: int = 160,
) -> Figure:
    """Draw posed figures from left to right with their frames beneath: left limbs blue, right limbs orange.

    motions : one row each, of any skeleton; all rows share one scale, counted in body heights
    poses : how many poses, evenly spaced from the first frame to the last, or the frames themselves
    labels : one a row; without them, the motions' names
    marks : frames a row where a dashed line shall stand (seams)
    segments : ``(start, stop[, label[, colour]])`` a row, half-open frames: where a stitched result shows another clip
    view : ``front``, ``side``, ``three-quarter``, ``back``, or the camera's azimuth in degrees (0 front, 90 side)
    travel : figures stand where they really are along the strip; otherwise each is taken back to its own place in a row
    width : inches; the height follows

    Raises ParameterError (no motion, poses < 1, unknown view, lists of another length than the rows) and RangeError (a
    pose, mark or segment outside its motion).
    """
    from matplotlib.figure import Figure

    rows = [motions] if isinstance(motions, Motion) else list(motions)
    if not rows:
        raise ParameterError("Expected at least one motion, got none.")
    for what, given in (("labels", labels), ("marks", marks), ("segments", segments)):
        if given is not None and len(given) != len(rows):
            raise ParameterError(f"Expected {what} for {len(rows)} rows, got {len(given)}.")
    drawn = [
        _row(
            motion,
            _pose_frames(motion, poses),
            view=view,
            label=motion.name if labels is None else labels[i],
            marks=() if marks is None else marks[i],
            segments=() if segments is None else segments[i],
        )
        for i, motion in enumerate(rows)
    ]
    layout = _layout(drawn, travel)
    top = 0.42 if title else 0.12
    unit = min((width - 0.5) / layout.width, TALLEST)
    layout = replace(layout, width=(width - 0.5) / unit)
    heights = [_above(row) * unit + 0.18 + _below(row) for row in drawn]
    figure = Figure(figsize=(width, sum(heights) + top), dpi=dpi)
    if title:
        words = _fitting(title, 12, width - 0.5)
        figure.text(0.25 / width, 1 - 0.14 / (sum(heights) + top), words, va="top", fontsize=12, fontweight="bold")
    base = sum(heights)
    for row, height in zip(drawn, heights, strict=True):
        base -= height
        total = sum(heights) + top
        axes = figure.add_axes((0, base / total, 1, height / total))
        _draw_row(axes, row, layout, unit, (width, height))
    return figure


def _below(row: _Row) -> float:
    """Room under the ground line in inches: frame numbers, and the words of segments if there are any."""
    return 0.42 if any(stretch.label for stretch in row.segments) else 0.24


@dataclass(frozen=True, slots=True)
class _Layout:
    """The strip in body heights: its width, and half a pose's room at either end."""

    width: float
    margin: float
    travel: bool


def _row(
    motion: Motion,
    frames: Array,
    *,
    view: str | float,
    label: str,
    marks: Sequence[int],
    segments: Sequence[tuple[Any, ...] | Stretch],
) -> _Row:
    stretches = tuple(s if isinstance(s, Stretch) else Stretch(*s) for s in segments)
    for frame in (*marks, *(s.start for s in stretches), *(s.stop for s in stretches)):
        if not 0 <= frame <= motion.frames:
            raise RangeError(f"Expected a frame in [0, {motion.frames}], got {frame}. ({label or motion.name})")
    positions = body_positions(motion)
    camera: View = view_of(facing(with_tips(motion.skeleton), positions), view)
    ground = positions[frames].copy()
    ground[..., 1] = min(0.0, float(positions[..., 1].min()))
    height = body_height(positions)
    paper, floor = camera.project(positions[frames]) / height, camera.project(ground) / height
    return _Row(motion, frames, paper, floor, height, label, tuple(marks), stretches)


def _pose_frames(motion: Motion, poses: int | Sequence[int]) -> Array:
    if isinstance(poses, int):
        if poses < 1:
            raise ParameterError(f"Expected at least one pose, got {poses}.")
        count = min(poses, motion.frames)
        return np.unique(np.rint(np.linspace(0, motion.frames - 1, count)).astype(int))
    frames = np.array(sorted(set(poses)), dtype=int)
    if frames.size == 0:
        raise ParameterError("Expected at least one pose, got an empty list.")
    for frame in frames:
        if not 0 <= frame < motion.frames:
            raise RangeError(f"Expected poses in [0, {motion.frames}), got {frame}. ({motion.name})")
    return frames


def _layout(rows: list[_Row], travel: bool) -> _Layout:
    half = max(float(np.abs(row.paper[..., 0] - row.paper[:, :1, 0]).max()) for row in rows) + 0.06
    half = float(np.clip(half, 0.2, 3.0))
    if travel:
        span = max(float(np.ptp(row.paper[:, 0, 0])) for row in rows)
    else:
        span = max(len(row.frames) - 1 for row in rows) * float(np.clip(1.75 * half, 0.42, 1.5))
    return _Layout(max(span + 2 * half, 1.2), half, travel)


def _above(row: _Row) -> float:
    """Room above the ground line in body heights."""
    return max(float(np.ptp(_levelled(row)[..., 1])) + 0.16, 0.5)


def _levelled(row: _Row) -> Array:
    """Paper coordinates (P, J, 3) with the ground under each pose's root at height zero."""
    level = row.paper.copy()
    level[..., 1] -= row.ground[:, :1, 1]
    return level


def _places(row: _Row, layout: _Layout) -> Array:
    """Where along the strip each pose's root stands (P,), in body heights."""
    if layout.travel:
        across = row.paper[:, 0, 0]
        return across - across.min() + (layout.width - float(np.ptp(across))) / 2
    if len(row.frames) == 1:
        return np.array([layout.width / 2])
    return np.linspace(layout.margin, layout.width - layout.margin, len(row.frames))


def _fitting(words: str, points: float, inches: float) -> str:
    """The words, cut short in the middle if they are too long for a line of so many inches at a font size."""
    room = max(int(inches / (points * GLYPH)), 3)
    return words if len(words) <= room else f"{words[: room // 2]}…{words[len(words) - (room - room // 2 - 1) :]}"


def _draw_row(axes: Axes, row: _Row, layout: _Layout, unit: float, size: tuple[float, float]) -> None:
    width, height = size
    below = _below(row)
    axes.set_xlim(-0.25 / unit, (width - 0.25) / unit)
    axes.set_ylim(-below / unit - 0.05, (height - below) / unit - 0.05)
    axes.set_axis_off()
    axes.set_gid(f"row {row.label}")
    places = _places(row, layout)
    edge = (0.0, layout.width)
    axes.plot(edge, (0, 0), color=GROUND, linewidth=0.8, zorder=0)
    _draw_marks(axes, row, places, layout, unit)
    parts = mannequin(with_tips(row.motion.skeleton))
    numbered: list[float] = []
    for frame, place, pose, floor in zip(row.frames, places, _levelled(row), row.ground, strict=True):
        here = pose - np.array([pose[0, 0] - place, 0, 0])
        shadow = floor[..., :2] - floor[0, :2] + np.array([place, 0])
        _draw_shadow(axes, shadow)
        _draw_pose(axes, here, parts, frame, min(1.0, unit / OUTLINED))
        if np.abs(place - np.array(numbered)).min(initial=np.inf) > 0.24 / unit:  # no two numbers on each other
            numbered.append(place)
            axes.text(place, -0.06 / unit - 0.035, str(frame), ha="center", va="top", fontsize=7.5, color="#4a4f55")
    axes.text(
        0,
        (height - below) / unit - 0.07,
        _fitting(row.label, 9.5, width - 0.5),
        ha="left",
        va="top",
        fontsize=9.5,
        fontweight="bold",
        color="#222",
    )


def _draw_marks(axes: Axes, row: _Row, places: Array, layout: _Layout, unit: float) -> None:
    def at(frame: int) -> float:
        if len(row.frames) == 1:
            return float(places[0])
        return float(np.interp(frame, row.frames, places))

    top = _above(row) - 0.1
    labelled: list[tuple[float, float, str, str]] = []
    for number, stretch in enumerate(row.segments):
        colour = stretch.colour or PASTED[number % len(PASTED)]
        left, right = at(stretch.start), at(stretch.stop)
        axes.fill_between((left, right), -0.035, top, color=colour, alpha=0.13, linewidth=0, zorder=-2)
        axes.plot((left, right), (-0.035, -0.035), color=colour, linewidth=2.2, solid_capstyle="butt", zorder=1)
        labelled.append((left, right, stretch.label, colour))
    for frame in row.marks:
        axes.plot((at(frame),) * 2, (-0.035, top), color=SEAM, linewidth=1.0, linestyle=(0, (4, 3)), zorder=1)
    _draw_labels(axes, labelled, layout, unit)


def _draw_labels(axes: Axes, labelled: list[tuple[float, float, str, str]], layout: _Layout, unit: float) -> None:
    """The words of (left, right, words, colour) stretches; the longest come first, none is set on another."""
    taken: list[tuple[float, float]] = []
    for left, right, label, colour in sorted(labelled, key=lambda entry: -abs(entry[1] - entry[0])):
        words = _fitting(label, 7.5, layout.width * unit)
        half = len(words) * 7.5 * GLYPH / 2 / unit
        middle = min(max((left + right) / 2, half), layout.width - half)
        if words and all(middle + half < low or high < middle - half for low, high in taken):
            taken.append((middle - half, middle + half))
            axes.text(middle, -0.24 / unit - 0.035, words, ha="center", va="top", fontsize=7.5, color=colour)


def _draw_shadow(axes: Axes, points: Array) -> None:
    from matplotlib.patches import Polygon

    flat = hull(points)
    if len(flat) > 2 and np.ptp(flat[:, 1]) > 1e-6:
        axes.add_patch(Polygon(flat, closed=True, facecolor=SHADOW, edgecolor="none", zorder=-1))


def _draw_pose(axes: Axes, pose: Array, parts: Sequence[Any], frame: int, fineness: float) -> None:
    """One figure as one collection, far parts first; the far ones are paler.

    fineness : by which the outlines of a small figure are thinner, so that they do not cover it
    """
    from matplotlib.collections import PolyCollection

    body = painted(parts, pose)
    edges = np.where(body.fine, 0.12, 0.5) * fineness  # fingers stay visible
    figure = PolyCollection(
        list(body.shapes), facecolors=body.colours, edgecolors="white", linewidths=edges.tolist(), zorder=3
    )
    figure.set_gid(f"pose {frame}")
    axes.add_collection(figure, autolim=False)
