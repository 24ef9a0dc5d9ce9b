"""Animation curves: keys with constant, linear and cubic interpolation, sampled at any times."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError
from kinestitch.files.fbx.extrapolation import HELD, SLOPE, Beyond, folded, read_beyond
from kinestitch.files.fbx.nodes import Node
from kinestitch.files.fbx.tangents import CUBIC, cubic_slopes

Ticks = NDArray[np.int64]
TICKS = 46186158000  # FBX time units in a second
_CONSTANT = 0x2
_SAME = 10_000  # ticks; 0.2 µs, what rounding may move a key off its frame


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """K keys in the order of time.

    times : (K,) FBX ticks
    values : (K,) the file's units (degrees, its own length unit)
    flags : (K,) how the stretch after each key runs
    data : (K, 3) what the file says about slopes there (see :mod:`kinestitch.files.fbx.tangents`)
    weights : (K, 2) length of the two handles of that stretch as shares of it
    beyond : how the curve goes on before its first and after its last key
    """

    times: Ticks
    values: Array
    flags: NDArray[np.int64]
    data: Array
    weights: Array
    beyond: tuple[Beyond, Beyond] = HELD


def make_curve(times: Ticks, values: Array, flags: NDArray[np.int64], data: Array, weights: Array) -> Curve | None:
    """Check and sort the keys; None where there are none."""
    if len(times) == 0:
        return None
    if not np.isfinite(values).all():
        raise FormatError("Expected finite animation keys, got NaN or infinity. Export the clip again.")
    if (np.diff(times) <= 0).any():
        order = np.argsort(times, kind="stable")
        last = np.append(np.diff(times[order]) > 0, True)
        order = order[last]
        times, values, flags, data, weights = (a[order] for a in (times, values, flags, data, weights))
    return Curve(times, values, flags, np.nan_to_num(data, posinf=0, neginf=0), weights)


def read_curve(node: Node) -> Curve | None:
    """A 7.x AnimationCurve object; attributes are run-length coded over the keys."""
    time_node, value_node = node.child("KeyTime"), node.child("KeyValueFloat")
    if time_node is None or value_node is None:
        return None
    times, values = time_node.integers(), value_node.array()
    if len(times) != len(values):
        raise FormatError(
            f"Expected as many key values as key times ({len(times)}), got {len(values)}. Export it again."
        )
    flags, data = _attributes(node, len(times))
    words = np.ascontiguousarray(data[:, 2]).view(np.uint32).astype(np.int64)
    third = np.full(len(times), 1 / 3)
    weights = np.stack(
        [
            np.where(flags & 0x1000000, (words & 0xFFFF) * 1e-4, third),
            np.where(flags & 0x2000000, (words >> 16) * 1e-4, third),
        ],
        axis=-1,
    )
    curve = make_curve(times, values, flags, data[:, :3].astype(np.float64), weights)
    return None if curve is None else replace(curve, beyond=read_beyond(node))


def _attributes(node: Node, count: int) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Interpolation flags (count,) and data words (count, 4) of each key; linear where the file says nothing."""
    flag_node, data_node = node.child("KeyAttrFlags"), node.child("KeyAttrDataFloat")
    repeat_node = node.child("KeyAttrRefCount")
    if flag_node is None or data_node is None or repeat_node is None:
        return np.full(count, 0x4), np.zeros((count, 4), dtype=np.float32)
    flags, repeats, raw = flag_node.integers(), repeat_node.integers(), data_node.raw()
    # text files write the bit patterns of floats as integers
    data = raw.astype(np.uint32).view(np.float32) if raw.dtype.kind in "iu" else raw.astype(np.float32)
    runs = len(flags)
    if len(repeats) != runs or len(data) < 4 * runs or (repeats < 0).any() or repeats.sum() != count:
        return np.full(count, 0x4), np.zeros((count, 4), dtype=np.float32)
    return np.repeat(flags, repeats), np.repeat(data[: 4 * runs].reshape(runs, 4), repeats, axis=0)


def sample(curve: Curve, ticks: Ticks) -> Array:
    """Values (N,) of a curve at `ticks` (N,); on a key its own value, past the ends what the file asks for."""
    times, values = curve.times, curve.values
    if len(times) == 1:
        return np.full(len(ticks), values[0])
    if len(times) == len(ticks) and np.array_equal(times, ticks):
        return values
    shown, added = folded(ticks, (int(times[0]), int(times[-1])), float(values[-1] - values[0]), curve.beyond)
    return _between(curve, shown) + added + _straight_on(curve, ticks)


def _between(curve: Curve, ticks: Ticks) -> Array:
    """Values (N,) at times (N,) from the first to the last key."""
    times, values = curve.times, curve.values
    left = np.clip(np.searchsorted(times, ticks, side="right") - 1, 0, len(times) - 2)
    right = left + 1
    length = (times[right] - times[left]).astype(np.float64)
    share = np.clip((ticks - times[left]) / length, 0.0, 1.0)
    share = np.where(times[right] - ticks < np.minimum(_SAME, length / 4), 1.0, share)
    share = np.where(ticks - times[left] < np.minimum(_SAME, length / 4), 0.0, share)
    out = values[left] * (1 - share) + values[right] * share
    inside = (share > 0) & (share < 1)
    flags = curve.flags[left]
    steps = inside & (flags & _CONSTANT != 0)
    out[steps] = np.where(flags[steps] & 0x100, values[right[steps]], values[left[steps]])
    cubic = inside & (flags & CUBIC != 0) & ~steps
    if cubic.any():
        out[cubic] = _cubic(curve, left[cubic], share[cubic])
    return out


def _straight_on(curve: Curve, ticks: Ticks) -> Array:
    """What a curve that keeps its slope past its ends gains there (N,)."""
    out = np.zeros(len(ticks))
    ends = (curve.times[0] - ticks, ticks - curve.times[-1])
    for side, past, stretch in zip(curve.beyond, ends, (0, -2), strict=True):
        if side.kind == SLOPE and (past > 0).any():
            slope = _end_slope(curve, stretch)
            out += np.maximum(past, 0) / TICKS * (-slope if stretch == 0 else slope)
    return out


def _end_slope(curve: Curve, stretch: int) -> float:
    if curve.flags[stretch] & _CONSTANT:
        return 0.0
    if curve.flags[stretch] & CUBIC:
        return float(_slopes(curve)[stretch, 0 if stretch == 0 else 1])
    rise = np.diff(curve.values)[stretch if stretch == 0 else -1]
    return float(rise / np.diff(curve.times)[stretch if stretch == 0 else -1] * TICKS)


def _slopes(curve: Curve) -> Array:
    seconds = (curve.times - curve.times[0]) / TICKS
    return cubic_slopes(seconds, curve.values, curve.flags, curve.data, curve.weights)


def _cubic(curve: Curve, left: NDArray[np.intp], share: Array) -> Array:
    slopes = _slopes(curve)
    length = (curve.times[left + 1] - curve.times[left]) / TICKS
    leave, arrive = curve.weights[left, 0], curve.weights[left, 1]
    x1, x2 = np.clip(leave, 0, 1), np.clip(1 - arrive, 0, 1)
    t = _bezier_parameter(x1, x2, share)
    y0, y3 = curve.values[left], curve.values[left + 1]
    y1 = y0 + leave * length * slopes[left, 0]
    y2 = y3 - arrive * length * slopes[left, 1]
    u = 1 - t
    return u**3 * y0 + 3 * u * t * (u * y1 + t * y2) + t**3 * y3


def _bezier_parameter(x1: Array, x2: Array, x: Array) -> Array:
    """The parameter at which a Bézier curve through 0, x1, x2, 1 reaches x: bisection, the curve being monotonic."""
    low, high = np.zeros_like(x), np.ones_like(x)
    for _ in range(54):
        t = (low + high) / 2
        u = 1 - t
        below = 3 * u * t * (u * x1 + t * x2) + t**3 < x
        low, high = np.where(below, t, low), np.where(below, high, t)
    return (low + high) / 2
