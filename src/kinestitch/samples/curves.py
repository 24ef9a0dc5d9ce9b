"""Curves through an animator's keys: functions of time in seconds, twice continuously differentiable."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.rotation import Array

Curve = Callable[[Array], Array]
"""Takes times (F,) in s, gives values (F, C)."""

_RATE = 480.0


def keyed(rows: Sequence[Sequence[float]], *, smooth: float = 0.04) -> Curve:
    """Curve through rows ``(time, value, …)`` that never swings past a key, its corners rounded over `smooth` s.

    At rest before the first key and after the last. `smooth` is the standard deviation of the rounding.
    """
    from scipy.interpolate import CubicSpline, PchipInterpolator
    from scipy.ndimage import gaussian_filter1d

    pad = 5 * smooth + 4 / _RATE
    table = np.array([rows[0], *rows, rows[-1]], dtype=np.float64)
    table[0, 0] -= pad
    table[-1, 0] += pad
    time = np.arange(np.ceil(table[0, 0] * _RATE), np.floor(table[-1, 0] * _RATE) + 1) / _RATE
    values = PchipInterpolator(table[:, 0], table[:, 1:], axis=0)(time)
    spline = CubicSpline(time, gaussian_filter1d(values, smooth * _RATE, axis=0, mode="nearest"), axis=0)
    return lambda t: np.asarray(spline(np.clip(t, time[0], time[-1])))


def cycle(period: float, *channels: Sequence[float]) -> Curve:
    """Periodic curve; each channel is ``(mean, amplitude, phase[, amplitude2, phase2, …])``.

    Harmonic k adds ``amplitude · cos(2π (k t / period − phase))``: it peaks where ``k t / period`` equals its phase.
    """

    def at(t: Array) -> Array:
        columns = []
        for channel in channels:
            value = np.full(t.shape, float(channel[0]))
            for k, (amplitude, phase) in enumerate(zip(channel[1::2], channel[2::2], strict=True), start=1):
                value = value + amplitude * np.cos(2 * np.pi * (k * t / period - phase))
            columns.append(value)
        return np.stack(columns, axis=-1)

    return at


def still(*values: float) -> Curve:
    """Curve that keeps the same values."""
    return lambda t: np.broadcast_to(np.array(values, dtype=np.float64), (len(t), len(values)))


def summed(*curves: Curve) -> Curve:
    """Sum of curves."""

    def at(t: Array) -> Array:
        return np.sum([curve(t) for curve in curves], axis=0)

    return at


def through(times: Sequence[float], points: ArrayLike, start: ArrayLike, end: ArrayLike) -> Curve:
    """Fifth-degree spline through `points` (N, C) at `times` (N,); velocity and acceleration (2, C) given at both ends.

    With two points it is the minimum-jerk path between two states.
    """
    from scipy.interpolate import make_interp_spline

    first, last = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    bounds = ([(1, first[0]), (2, first[1])], [(1, last[0]), (2, last[1])])
    spline = make_interp_spline(np.asarray(times, dtype=np.float64), np.asarray(points), k=5, bc_type=bounds)
    return lambda t: np.asarray(spline(np.clip(t, times[0], times[-1])))


def pieces(bounds: Sequence[float], curves: Sequence[Curve]) -> Curve:
    """Curves one after the other: `curves[i]` from `bounds[i]` to `bounds[i + 1]`; first and last reach on outwards."""

    def at(t: Array) -> Array:
        index = np.clip(np.searchsorted(bounds, t, side="right") - 1, 0, len(curves) - 1)
        values = [curve(t) for curve in curves]
        return np.stack(values)[index, np.arange(len(t))]

    return at


def ease(share: ArrayLike) -> Array:
    """Minimum-jerk step: 0 at 0, 1 at 1, at rest at both ends (velocity and acceleration zero)."""
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s * s * s * (10 - 15 * s + 6 * s * s))
