"""A motion on a stage: where the camera follows it, and everything that is drawn around it in a frame of a video."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal, Protocol

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.render.canvas import Canvas
from kinestitch.render.mannequin import (
    Part,
    anchor,
    body_height,
    bones,
    feet,
    mannequin,
    outlines,
    soles,
    with_tips,
)
from kinestitch.render.paint import COLOURS, PASTED, SEAM, Stretch, body_positions, painted
from kinestitch.render.view import View, facing, view_of
from kinestitch.solve.contacts import Contacts

ELEVATION = 12.0
"""Degrees by which the camera looks down, so that the ground is seen."""
FOLLOWS, TRAIL, FLASH = 0.35, 0.8, 0.4
"""Seconds: over which the camera's path is smoothed, which a foot's trail shows, and which a seam glows."""
FLOOR, INK, CAST = "#f1f3f5", "#2b3440", 0.13
"""The ground; what lies on it, laid over any tint: its lines and, so strong, the body's shadow."""
_FADES = 6
_ROUND = np.stack([np.cos(np.arange(72) * np.pi / 36), np.sin(np.arange(72) * np.pi / 36)], axis=1)


Style = Literal["mannequin", "skeleton"]
STYLES: tuple[Style, ...] = ("mannequin", "skeleton")


class Body(Protocol):
    """Whatever can stand on a stage in the place of the mannequin."""

    def draw(self, canvas: Canvas, motion: Motion, frame: int, *, to_pixels: ToPixels) -> None:
        """Draw one pose."""


@dataclass(frozen=True, eq=False, slots=True)
class ToPixels:
    """From the world to a canvas: (point − centre) seen by the camera, `scale` pixels a metre, around `origin` (2,)."""

    camera: View
    centre: Array
    scale: float
    origin: Array

    def __call__(self, points: Array) -> Array:
        """Points (..., 3) m as (..., 3) pixels, the last one depth (larger is nearer)."""
        paper = self.camera.project(points - self.centre) * self.scale
        paper[..., :2] += self.origin
        return paper


@dataclass(frozen=True, eq=False)
class Actor:
    """A motion with the camera that follows it.

    positions : (F, J, 3) m as drawn; path : (F, 3) m, the place on the ground that the camera looks at
    height : of the body, m; seams : frames; segments : what came from other clips; body : drawn for the mannequin
    contacts : when its feet stand; style : what a motion without a body of its own looks like
    """

    motion: Motion
    positions: Array
    camera: View
    path: Array
    height: float
    label: str
    seams: tuple[int, ...]
    segments: tuple[Stretch, ...]
    body: Body | None = None
    contacts: Contacts | None = None
    style: Style = "mannequin"

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The figure's parts."""
        return (bones if self.style == "skeleton" else mannequin)(with_tips(self.motion.skeleton))

    @cached_property
    def _soles(self) -> list[list[int]]:
        return [] if self.contacts is None else [soles(self.parts, joint) for joint in self.contacts.joints]

    def standing(self, frame: int) -> list[int]:
        """Numbers of the parts that stand on the ground."""
        if self.contacts is None:
            return []
        return [
            part for held, sole in zip(self.contacts.held[frame], self._soles, strict=True) if held for part in sole
        ]

    @cached_property
    def feet(self) -> list[tuple[int, str]]:
        """Joints that leave a trail, and their sides."""
        return feet(with_tips(self.motion.skeleton))

    def extent(self) -> tuple[float, float]:
        """How far the body reaches to either side of the picture's middle and above the ground, in body heights."""
        paper = self.camera.project(self.positions - self.path[:, None])[..., :2] / self.height
        return float(np.abs(paper[..., 0]).max()) + 0.05, float(paper[..., 1].max()) + 0.08

    def segment_at(self, frame: int) -> tuple[Stretch, str] | None:
        """The pasted segment that a frame belongs to, and its colour."""
        for number, stretch in enumerate(self.segments):
            if stretch.start <= frame < stretch.stop:
                return stretch, stretch.colour or PASTED[number % len(PASTED)]
        return None

    def glow(self, frame: int) -> float:
        """How strongly a seam glows: 1 on its first frame, 0 when it is over."""
        ages = [(frame - seam) / self.motion.fps for seam in self.seams if frame >= seam]
        return max(0.0, 1.0 - min(ages, default=FLASH) / FLASH)


def cast(
    motions: Sequence[Motion],
    view: str | float,
    *,
    labels: Sequence[str],
    seams: Sequence[tuple[int, ...]],
    segments: Sequence[tuple[Stretch, ...]],
    bodies: Sequence[Body | None],
    contacts: Sequence[Contacts | None],
    style: Style,
) -> list[Actor]:
    """Put motions on stages. Those of one rig and length share one camera, so that what differs is the motion."""
    positions = [body_positions(motion) for motion in motions]
    forwards = [facing(with_tips(m.skeleton), p) for m, p in zip(motions, positions, strict=True)]
    paths = [_followed(m, p) for m, p in zip(motions, positions, strict=True)]
    heights = [body_height(p) for p in positions]
    if len({(motion.skeleton, motion.frames, motion.fps) for motion in motions}) == 1:
        paths = [np.mean(paths, axis=0)] * len(paths)
        forwards, heights = [forwards[0]] * len(forwards), [max(heights)] * len(heights)
    return [
        Actor(
            motion,
            positions[i],
            view_of(forwards[i], view, ELEVATION),
            paths[i],
            heights[i],
            labels[i],
            seams[i],
            segments[i],
            bodies[i],
            contacts[i],
            style,
        )
        for i, motion in enumerate(motions)
    ]


def _followed(motion: Motion, positions: Array) -> Array:
    """The body's smoothed place on the ground (F, 3) m."""
    path = positions[:, anchor(with_tips(motion.skeleton))].copy()
    path[:, 1] = min(0.0, float(positions[..., 1].min()))
    sigma = FOLLOWS * motion.fps
    reach = min(round(3 * sigma), motion.frames - 1)
    if reach < 1:
        return path
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    for axis in (0, 2):
        run_on = np.pad(path[:, axis], reach, mode="reflect", reflect_type="odd")
        path[:, axis] = np.convolve(run_on, weights / weights.sum(), mode="valid")
    return path


@dataclass(frozen=True, eq=False, slots=True)
class Panel:
    """An actor's part of the picture.

    left, width : pixels; origin : (2,) where the followed place stands; unit : pixels a body height
    floor : radius of the ground that is shown, pixels
    """

    actor: Actor
    left: float
    width: float
    origin: Array
    unit: float
    floor: float

    def draw(self, canvas: Canvas, frame: int) -> None:
        """One frame: ground, trails, shadow and body."""
        actor = self.actor
        canvas.clip(self.left, self.width)
        to_pixels = ToPixels(actor.camera, actor.path[frame], self.unit / actor.height, self.origin)
        self._draw_floor(canvas, frame, to_pixels)
        if actor.body is not None:
            self._draw_trails(canvas, frame, to_pixels)
            actor.body.draw(canvas, actor.motion, frame, to_pixels=to_pixels)
            return
        canvas.shapes(self._shadow(frame, to_pixels), INK, alpha=CAST)
        self._draw_trails(canvas, frame, to_pixels)
        self._draw_figure(canvas, to_pixels(actor.positions[frame]), actor.standing(frame))

    def _draw_figure(self, canvas: Canvas, pose: Array, standing: Sequence[int]) -> None:
        figure = painted(self.actor.parts, pose, self.unit, standing=standing)
        edge = self.unit / 320
        start = 0
        while start < len(figure.shapes):  # fingers of one colour are one stroke
            stop = start + 1
            while stop < len(figure.shapes) and _alike(figure.colours, figure.fine, start, stop):
                stop += 1
            fine = bool(figure.fine[start])
            canvas.shapes(
                figure.shapes[start:stop],
                figure.colours[start],
                edge=None if fine else "#ffffff",
                width=edge,
            )
            start = stop

    def _draw_floor(self, canvas: Canvas, frame: int, to_pixels: ToPixels) -> None:
        squash = np.array([1.0, self._tilt])
        rim = self.origin + self.floor * _ROUND * squash
        canvas.shapes(rim, FLOOR)
        here = self.actor.segment_at(frame)
        if here is not None:
            canvas.shapes(rim, here[1], alpha=0.13)
        canvas.lines(self._grid(to_pixels), INK, width=max(1.0, self.unit / 330), alpha=0.22)
        glow = self.actor.glow(frame)
        if glow > 0:
            closed = np.concatenate([rim, rim[:1]])
            canvas.lines(closed, SEAM, width=1 + 3.5 * glow * self.unit / 330, alpha=0.9 * glow)

    @property
    def _tilt(self) -> float:
        return float(np.hypot(*self.actor.camera.up[[0, 2]]))

    def _grid(self, to_pixels: ToPixels) -> Array:
        """Lines (N, 2, 2) of a grid that stays on the ground while the camera passes over it, cut off at the rim."""
        centre, radius = to_pixels.centre, self.floor / to_pixels.scale
        step = grid_step(self.actor.height)
        ends = []
        for axis, other in ((0, 2), (2, 0)):
            first, last = np.ceil((centre[axis] - radius) / step), np.floor((centre[axis] + radius) / step)
            places = np.arange(first, last + 1) * step
            half = np.sqrt(np.maximum(radius**2 - (places - centre[axis]) ** 2, 0.0))
            line = np.empty((len(places), 2, 3))
            line[..., axis] = places[:, None]
            line[..., other] = centre[other] + half[:, None] * [-1.0, 1.0]
            line[..., 1] = centre[1]
            ends.append(line)
        return to_pixels(np.concatenate(ends))[..., :2]

    def _shadow(self, frame: int, to_pixels: ToPixels) -> Array:
        """The body straight down on the ground: outlines (P, K, 2) as seen from above, laid flat."""
        camera = self.actor.camera
        level = camera.up * [1.0, 0.0, 1.0] / self._tilt
        flat = (self.actor.positions[frame] - to_pixels.centre) @ np.stack([camera.right, level], axis=1)
        shapes = outlines(self.actor.parts, flat * to_pixels.scale, self.unit)
        return self.origin + shapes * [1.0, self._tilt]

    def _draw_trails(self, canvas: Canvas, frame: int, to_pixels: ToPixels) -> None:
        first = max(0, frame - round(TRAIL * self.actor.motion.fps))
        bounds = np.linspace(first, frame, _FADES + 1).round().astype(int)
        for joint, side in self.actor.feet:
            track = to_pixels(self.actor.positions[first : frame + 1, joint])[:, :2]
            for fade, (start, stop) in enumerate(pairwise(bounds)):
                if stop > start:
                    piece = track[start - first : stop - first + 1]
                    canvas.lines(piece, COLOURS[side], width=self.unit / 130, alpha=0.65 * (fade + 1) / _FADES)


def _alike(colours: Array, fine: Array, start: int, stop: int) -> bool:
    return bool(fine[start] and fine[stop] and np.abs(colours[start] - colours[stop]).max() < 0.02)


def grid_step(height: float) -> float:
    """Metres between the ground's lines: 1, 2 or 5 times a power of ten, near a third of a body's height."""
    power = 10.0 ** np.floor(np.log10(height / 2.2))
    return float(max(factor * power for factor in (1, 2, 5) if factor * power <= height / 2.2))


def panels(actors: Sequence[Actor], size: tuple[int, int], *, above: float, below: float) -> list[Panel]:
    """Stages side by side, all of one scale in body heights; `above` and `below` are left free, in pixels."""
    width, height = size[0] / len(actors), size[1]
    extents = [actor.extent() for actor in actors]
    floor = min(0.46 * width, 0.62 * height)
    base = below + floor * np.sin(np.radians(ELEVATION)) + 0.01 * height
    unit = min(0.48 * width / max(side for side, _ in extents), (height - above - base) / max(up for _, up in extents))
    return [
        Panel(actor, i * width, width, np.array([(i + 0.5) * width, base]), float(unit), floor)
        for i, actor in enumerate(actors)
    ]
