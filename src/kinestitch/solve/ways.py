"""The way of the body over the ground, stretch by stretch: bent, moved sideways, and brought back.

A stretch ends with its last pin; behind it everything rides along rigidly. A return begins a stretch of its own.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.edit.pins import Pin
from kinestitch.errors import KinestitchWarning, ParameterError
from kinestitch.solve.bend import Aim, Complex, bend, bent_path, between
from kinestitch.solve.laplacian import check_smoothing
from kinestitch.solve.pinned import nearest, path_rows, pinned_path

BENDING, SHIFTING = 0.3, 0.25
"""s over which a path's turning changes, and over which its speed does, where a pin says nothing else."""

LEAST, MOST = 0.7, 1.3
"""Mean length of the steps before a waypoint, as a share of their own, outside which a warning is given."""

SHORTER, LONGER = 0.5, 1.5
"""Length of the way to a root pin, as a share of its own, outside which a warning is given; feet stand in between."""

_MOVED, _DRIFT = 0.5, 0.2  # m, and m/s: what the way to a root pin may be longer or shorter without a word
_BEYOND = 3.0  # times the way that the body travels, from which a waypoint is no bend any more
_FREE = 0.1  # m that a way back may be longer or shorter without a word
_BACK = 6.0  # a way back changes its direction and speed over this share of its time at most


@dataclass(frozen=True, eq=False, slots=True)
class Way:
    """The hips over the ground: `place` (F,) m as z + ix, and by how much the body is turned, `yaw` (F,) rad."""

    place: Complex
    yaw: Array

    def moved(self, start: int, place: Complex, yaw: Array) -> Way:
        """New places and further turns of the frames from `start` on; what follows them rides along rigidly."""
        stop = start + len(place)
        turn = np.exp(1j * yaw[-1])
        after = place[-1] + turn * (self.place[stop:] - self.place[stop - 1])
        return Way(
            np.concatenate([self.place[:start], place, after]),
            np.concatenate([self.yaw[:start], self.yaw[start:stop] + yaw, self.yaw[stop:] + yaw[-1]]),
        )


@dataclass(frozen=True, slots=True)
class Home:
    """Where a clip was before the edit: all of a frame `frame` turned by `yaw` rad more, with the hips at `place`."""

    frame: int
    place: complex
    yaw: float
    seconds: float


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of the way that begins in frame `start`, its pins, and maybe where it has to come back to."""

    start: int
    pins: tuple[Pin, ...]
    home: Home | None = None


def stretches(pins: Sequence[Pin], homes: Sequence[Home], fps: float) -> list[Stretch]:
    """The parts of the way, in time; pins and homes in the order of their frames."""
    found, start, rest = [], 0, list(pins)
    for home in homes:
        zone = max(start, home.frame - max(1, round(home.seconds * fps)))
        early = tuple(pin for pin in rest if pin.frame <= zone)
        inside = tuple(pin for pin in rest if zone < pin.frame <= home.frame)
        found += [Stretch(start, early)] if early else []
        found.append(Stretch(zone, inside, home))
        start, rest = home.frame, [pin for pin in rest if pin.frame > home.frame]
    return found + ([Stretch(start, tuple(rest))] if rest else [])


def pinned_way(way: Way, stretch: Stretch, headings: dict[int, float], fps: float) -> Way:
    """The way with the pins of one stretch.

    headings : rad, how the body heads in the frames of the stretch's heading pins before anything has turned it

    Raises ParameterError for a waypoint that no bend reaches; a KinestitchWarning tells of steps and ways back that
    become much longer or shorter.
    """
    before = way
    way = _set_off(way, [pin for pin in stretch.pins if pin.frame == stretch.start], headings)
    later = [pin for pin in stretch.pins if pin.frame > stretch.start]
    way = _bent(way, stretch, [pin for pin in later if pin.kind in ("heading", "waypoint")], headings, fps)
    way = _shifted(way, stretch, [pin for pin in later if pin.kind == "root"], fps)
    if stretch.home is not None:
        _tell_way_back(before, way, slice(stretch.start, stretch.home.frame + 1), fps)
    return way


def _set_off(way: Way, pins: Sequence[Pin], headings: dict[int, float]) -> Way:
    """Pins of the very first frame turn and move the whole clip."""
    for pin in sorted(pins, key=lambda pin: pin.kind != "heading"):
        share = 1.0 if pin.exact else pin.weight / (pin.weight + 1)
        if pin.kind == "heading":
            turn = share * _nearest_turn(pin.target[0] - headings[pin.frame] - way.yaw[0])
            way = way.moved(0, way.place[:1], np.array([turn]))
        else:
            way = way.moved(0, way.place[:1] + share * (_goal(pin) - way.place[0]), np.zeros(1))
    return way


def _goal(pin: Pin) -> complex:
    """Where a place pin wants the hips, as z + ix."""
    return complex(pin.target[-1], pin.target[0])


def _nearest_turn(angle: float, near: float = 0.0) -> float:
    """The same turn in the branch around `near`."""
    return near + math.remainder(angle - near, 2 * math.pi)


def _bent(way: Way, stretch: Stretch, pins: list[Pin], headings: dict[int, float], fps: float) -> Way:
    start, home = stretch.start, stretch.home
    if not pins and home is None:
        return way
    stop = max(pin.frame for pin in pins) if home is None else home.frame
    path = way.place[start : stop + 1]
    smoothing = _smoothing(len(path), start, pins, BENDING if home is None else min(BENDING, home.seconds / _BACK), fps)

    def bent(aims: list[Aim]) -> Complex | None:
        return bend(path, aims, fps, smoothing, started=start > 0)

    waypoints = [pin for pin in pins if pin.kind == "waypoint"]
    _check_travel(path, start, waypoints)
    aims = [Aim(pin.frame - start, _goal(pin), pin.weight) for pin in waypoints]
    turning = [pin for pin in pins if pin.kind == "heading"]
    first = bent(aims) if aims and turning else None
    guess = 0.0
    for pin in turning:
        guess = guess if first is None else float(first[pin.frame - start].imag)
        guess = _nearest_turn(pin.target[0] - headings[pin.frame] - way.yaw[pin.frame], guess)
        aims.append(Aim(pin.frame - start, guess, pin.weight, is_heading=True))
    zeta = None
    if home is not None:
        aims.append(Aim(stop - start, _nearest_turn(home.yaw - way.yaw[stop]), math.inf, is_heading=True))
        zeta = bent([*aims, Aim(stop - start, home.place, math.inf)])
        if zeta is not None and not LEAST <= _steps(path, zeta) <= MOST:
            zeta = None  # too far for a bend: the rest of the way is gone sideways
    zeta = bent(aims) if zeta is None else zeta
    if zeta is None:
        raise ParameterError(
            f"Expected pins that a walk can be bent through, got {', '.join(map(str, pins))}. "
            "Put them further apart, or use root pins, which move the body without bending its path."
        )
    _tell_steps(path, zeta, start, waypoints)
    return way.moved(start, bent_path(path, zeta), zeta.imag)


def _smoothing(count: int, start: int, pins: Sequence[Pin], own: float, fps: float) -> Array:
    """τ (count,) s of each frame: that of the pin next to it."""
    if not pins:
        return np.full(count, own)
    times = np.array([own if pin.smoothing is None else pin.smoothing for pin in pins])
    check_smoothing(float(times.max()), fps)
    return nearest(count, np.array([pin.frame - start for pin in pins]), times)


def _check_travel(path: Complex, start: int, pins: Sequence[Pin]) -> None:
    frame, place = 0, path[0]
    for pin in pins:
        travel = float(np.abs(np.diff(path[frame : pin.frame - start + 1])).sum())
        wanted = abs(_goal(pin) - place)
        if wanted > _BEYOND * travel + 1e-3:
            raise ParameterError(
                f"Expected a body that travels {wanted:.3g} m or nearly as much before {pin}, got one that goes "
                f"{travel:.3g} m. Use a root pin, which moves it without steps of its own."
            )
        if pin.exact:
            frame, place = pin.frame - start, _goal(pin)


def _steps(path: Complex, zeta: Complex) -> float:
    """The length of a bent path as a share of its own."""
    own = np.abs(np.diff(path))
    return float((np.exp(between(zeta).real) * own).sum() / max(own.sum(), 1e-12))


def _tell_steps(path: Complex, zeta: Complex, start: int, pins: Sequence[Pin]) -> None:
    frame = 0
    for pin in pins:
        here = slice(frame, pin.frame - start + 1)
        share = _steps(path[here], zeta[here])
        if not LEAST <= share <= MOST:
            warnings.warn(
                KinestitchWarning(
                    f"Steps before {pin} become {share:.2f} times as long. Move the waypoint, or give it another frame."
                ),
                stacklevel=2,
            )
        frame = pin.frame - start


def _tell_way_back(before: Way, after: Way, frames: slice, fps: float) -> None:
    own, new = (float(np.abs(np.diff(way.place[frames])).sum()) for way in (before, after))
    if abs(new - own) > _FREE and not LEAST * own <= new <= MOST * own:
        seconds = (frames.stop - frames.start - 1) / fps
        warnings.warn(
            KinestitchWarning(
                f"The way back to the original path is {new:.2f} m in {seconds:.3g} s, where the clip itself goes "
                f"{own:.2f} m. Give it more time."
            ),
            stacklevel=2,
        )


def _shifted(way: Way, stretch: Stretch, pins: list[Pin], fps: float) -> Way:
    start, home = stretch.start, stretch.home
    frames, goals, weights = [pin.frame for pin in pins], [_goal(pin) for pin in pins], [pin.weight for pin in pins]
    own = SHIFTING
    if home is not None:
        frames, goals, weights = [*frames, home.frame], [*goals, home.place], [*weights, math.inf]
        own = min(SHIFTING, home.seconds / _BACK)
    if not frames:
        return way
    at = np.array(frames)
    gaps = np.array(goals) - way.place[at]
    rows = (_smoothing(frames[-1] - start, start, pins, own, fps) * fps) ** 4
    bands = path_rows(rows, started=start > 0)
    change = pinned_path(bands, at - start, np.stack([gaps.real, gaps.imag], axis=1), np.array(weights))
    place = way.place[start : frames[-1] + 1] + change[:, 0] + 1j * change[:, 1]
    _tell_moved(way.place[start : frames[-1] + 1], place, start, pins, fps)
    return way.moved(start, place, np.zeros(len(place)))


def _tell_moved(before: Complex, after: Complex, start: int, pins: Sequence[Pin], fps: float) -> None:
    frame = 0
    for pin in pins:
        here = slice(frame, pin.frame - start + 1)
        own, new = (float(np.abs(np.diff(path[here])).sum()) for path in (before, after))
        seconds = (here.stop - frame - 1) / fps
        if abs(new - own) > min(_MOVED, _DRIFT * seconds) and not SHORTER * own <= new <= LONGER * own:
            warnings.warn(
                KinestitchWarning(
                    f"The way to {pin} is {new:.3g} m in {seconds:.3g} s, where the body itself goes {own:.3g} m. Move "
                    "the pin, or give it another frame."
                ),
                stacklevel=2,
            )
        frame = here.stop - 1
