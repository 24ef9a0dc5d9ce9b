"""The same movement at another pace: where in time it is shown, and what lies between its frames.

Slowed down, straight lines between frames stutter: the speed of every joint would jump at each frame of the source.
Here it does not. Each joint passes through its frames with the mean of both neighbours' velocities, and in between
moves on a cubic, on rotation vectors about the middle of the two frames (Eq. 37).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.motion import Motion
from kinestitch.core.resample import MOST_POSES, same_rate
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_to_rotvec, rotvec_to_quat
from kinestitch.errors import ParameterError

Knots = Sequence[tuple[float, float]]

_ON_FRAME = 1e-6  # frames; what is nearer to one shows it unchanged


def time_map(knots: Knots, times: ArrayLike) -> Array:
    """Which time in s of a source is shown at `times` in s: rises monotonely through all knots (Eq. 36).

    knots : pairs (time, time of the source), both rising. Between them the speed changes without jumps; beyond the
    first and the last it stays as it is there.

    >>> time_map([(0.0, 1.0), (2.0, 5.0)], [0.0, 0.5, 3.0])
    array([1., 2., 7.])
    """
    x, y = np.asarray(knots, dtype=np.float64).T
    times = np.asarray(times, dtype=np.float64)
    if len(x) == 2:
        return np.asarray(y[0] + (times - x[0]) * ((y[1] - y[0]) / (x[1] - x[0])))
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(x, y)
    inside = np.clip(times, x[0], x[-1])
    speeds = curve.derivative()(np.where(times < x[0], x[0], x[-1]))
    return np.asarray(curve(inside) + (times - inside) * speeds)


def retime(motion: Motion, knots: Knots, frames: int, fps: float) -> Motion:
    """The first `frames` frames, at rate `fps`, of the motion as the knots show it; one interpolation does both.

    Where a moment falls on a frame of the source, its pose is that frame's, unchanged. Raises ParameterError for
    fps ≤ 0 and for more poses than fit into memory.
    """
    if not (np.isfinite(fps) and fps > 0):
        raise ParameterError(f"Expected fps > 0, got {fps}.")
    if frames * motion.skeleton.joint_count > MOST_POSES:
        raise ParameterError(
            f"Expected a retimed clip of at most {MOST_POSES:,} joint poses, got {frames:,} frames "
            f"of {motion.skeleton.joint_count} joints. Raise its speed."
        )
    step = motion.fps if same_rate(motion.fps, fps) else fps
    positions = time_map(knots, np.arange(frames) / step) * motion.fps
    return replace(poses_at(motion, positions), fps=fps)


def poses_at(motion: Motion, positions: ArrayLike) -> Motion:
    """The poses at these places (N,), counted in frames of the motion, which may lie between two (Eq. 37).

    Places before the first frame and after the last show that frame. A motion of constant angular and linear velocity
    is told exactly; the velocity of any other is without jumps.
    """
    positions = np.clip(np.asarray(positions, dtype=np.float64), 0.0, motion.frames - 1.0)
    nearest = np.rint(positions)
    positions = np.where(np.abs(positions - nearest) < _ON_FRAME, nearest, positions)
    left = np.minimum(positions.astype(np.intp), max(motion.frames - 2, 0))
    share = positions - left
    rotations = motion.rotations[np.rint(positions).astype(np.intp)].copy()
    translations = motion.translations[np.rint(positions).astype(np.intp)].copy()
    between = np.flatnonzero((share > 0) & (share < 1))
    if len(between):
        places = left[between], share[between][:, None, None]
        rotations[between] = _turned(motion.rotations, *places)
        translations[between] = _shifted(motion.translations, *places)
    return replace(motion, rotations=rotations, translations=translations)


def _cubic(first: Array, last: Array, leaving: Array, arriving: Array, share: Array) -> Array:
    """The cubic from `first` to `last` that leaves and arrives with these velocities, at `share` of its way."""
    gap = last - first
    bend = leaving + arriving - 2 * gap
    return first + share * (leaving + share * ((gap - leaving - bend) + share * bend))


def _rates(steps: Array, left: np.ndarray) -> tuple[Array, Array]:
    """The velocities a frame at both ends of the intervals `left`, from steps (F − 1, J, 3): the mean of those before
    and after a frame, and at a clip's ends its only neighbour's.
    """
    last = len(steps) - 1
    here = steps[left]
    return (steps[np.maximum(left - 1, 0)] + here) / 2, (here + steps[np.minimum(left + 1, last)]) / 2


def _shifted(translations: Array, left: np.ndarray, share: Array) -> Array:
    first = max(int(left.min()) - 1, 0)
    near = translations[first : int(left.max()) + 3]
    leaving, arriving = _rates(np.diff(near, axis=0), left - first)
    start = translations[left]
    return start + _cubic(np.zeros_like(start), translations[left + 1] - start, leaving, arriving, share)


def _turned(rotations: Array, left: np.ndarray, share: Array) -> Array:
    first = max(int(left.min()) - 1, 0)
    near = rotations[first : int(left.max()) + 3]
    steps = quat_to_rotvec(quat_multiply(quat_conjugate(near[:-1]), near[1:]))
    leaving, arriving = _rates(steps, left - first)
    half = steps[left - first] / 2
    middle = quat_multiply(rotations[left], rotvec_to_quat(half))
    path = _cubic(-half, half, _vector_rate(-half, leaving), _vector_rate(half, arriving), share)
    return quat_multiply(middle, rotvec_to_quat(path))


def _vector_rate(vector: Array, velocity: Array) -> Array:
    """How a rotation vector (..., 3) of up to half a turn changes under an angular velocity in the turned axes."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    small = angle < 1e-2
    safe = np.where(small, 1.0, angle)
    factor = np.where(small, 1 / 12 + angle**2 / 720, (1 - safe / 2 / np.tan(safe / 2)) / safe**2)
    once = np.cross(vector, velocity)
    return np.asarray(velocity + once / 2 + factor * np.cross(vector, once))
