"""Slopes of cubic keys: told by the file, or worked out from the neighbours (automatic; tension, continuity, bias)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array

CUBIC, AUTO, TCB, USER, SPLIT = 0x8, 0x100, 0x200, 0x400, 0x800
_CLAMP, _TIME_INDEPENDENT, _PROGRESSIVE = 0x1000, 0x2000, 0x4000
_LEVEL = 1e-3  # a clamped key whose neighbour is this near in value runs level


def cubic_slopes(times: Array, values: Array, flags: NDArray[np.int64], data: Array, weights: Array) -> Array:
    """Slopes (K, 2) of the stretch after each key, units per second: leaving it, arriving at the next key.

    times : (K,) s
    data : (K, 3) two slopes; for automatic keys two biases; for TCB keys tension, continuity and bias
    weights : (K, 2) lengths of the handles as shares of the stretch
    """
    slopes = data[:, :2].copy()
    before, after = secants(times, values)
    tcb = flags & (CUBIC | TCB) == CUBIC | TCB
    auto = (flags & (CUBIC | AUTO) == CUBIC | AUTO) & ~tcb & (flags & USER == 0)
    told_before = -np.append(0.0, data[:-1, 1])
    last = np.arange(len(times)) == len(times) - 1
    left_bias = np.where((flags & SPLIT != 0) | last, told_before, data[:, 0])
    leaving = _automatic(times, values, flags, data[:, 0], weights)
    arriving = _automatic(times, values, flags, left_bias, weights)
    tension, continuity, bias = data.T
    half = np.full(len(times), 0.5)
    half[[0, -1]] = 1.0  # a key at an end has one neighbour to go by
    near, far = (1 - tension) * (1 + bias) * half * before, (1 - tension) * (1 - bias) * half * after
    leaving = np.where(tcb, (1 + continuity) * near + (1 - continuity) * far, leaving)
    arriving = np.where(tcb, (1 - continuity) * near + (1 + continuity) * far, arriving)
    ours = tcb | auto
    slopes[:, 0] = np.where(ours, leaving, slopes[:, 0])
    slopes[:-1, 1] = np.where(ours[1:], arriving[1:], slopes[:-1, 1])
    return slopes


def secants(times: Array, values: Array) -> tuple[Array, Array]:
    """Slope of the straight line to the key before and to the key after, each (K,); 0 past the ends."""
    steps = np.diff(values) / np.diff(times)
    return np.append(0.0, steps), np.append(steps, 0.0)


def _automatic(times: Array, values: Array, flags: NDArray[np.int64], bias: Array, weights: Array) -> Array:
    """Slopes (K,) through keys that ask for a smooth path; the first and the last point at their neighbour."""
    before, after = secants(times, values)
    span = np.diff(times)
    left, right = np.append(1.0, span), np.append(span, 1.0)
    share = left / (left + right)
    straight = before * share + after * (1 - share)
    turned = before * (1 - share) + after * share
    slope = np.where(flags & _TIME_INDEPENDENT, straight, (straight + turned) / 2)
    slope[0], slope[-1] = after[0], before[-1]
    slope = _biased(slope, np.where(bias > 0, after, before), bias, flags)
    steps = np.diff(values)
    level = np.minimum(np.abs(np.append(np.inf, steps)), np.abs(np.append(steps, np.inf))) <= _LEVEL
    slope = np.where((flags & _CLAMP != 0) & level, 0.0, slope)
    reach = np.append(1 / 3, weights[:-1, 1]) * left, weights[:, 0] * right
    return np.where(flags & _PROGRESSIVE, _held_back(slope, steps, *reach), slope)


def _biased(slope: Array, target: Array, bias: Array, flags: NDArray[np.int64]) -> Array:
    """Lean towards one neighbour by percents; beyond 500 the bias adds 40 times its excess in hundreds, squared."""
    weight = np.abs(bias) / 100
    edge = np.zeros(len(slope), dtype=bool)
    edge[[0, -1]] = True
    leaned = np.where(edge, slope, slope + weight * (target - slope))
    excess = np.maximum(weight - 5, 0) ** 2 * 40
    moved = np.where(np.abs(target - slope) > 1e-9, np.sign(target - slope), np.sign(bias))
    out = leaned + excess * np.where(edge, np.sign(bias), moved)
    return np.where(flags & _TIME_INDEPENDENT, slope, out)


def _held_back(slope: Array, steps: Array, reach_left: Array, reach_right: Array) -> Array:
    """The slope cut down until neither handle overshoots the neighbour on its side; the first and last run level."""
    sign = np.where(slope < 0, -1.0, 1.0)
    left = sign * np.append(0.0, steps) / np.where(reach_left > 0, reach_left, np.inf)
    right = sign * np.append(steps, 0.0) / np.where(reach_right > 0, reach_right, np.inf)
    return sign * np.minimum(np.abs(slope), np.maximum(np.minimum(left, right), 0.0))
