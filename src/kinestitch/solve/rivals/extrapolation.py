"""Dead blending: let the left source run on by itself, slower and slower, and fade over to the right one."""

from __future__ import annotations

import math

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_continuous, quat_log, quat_multiply, rotvec_to_quat
from kinestitch.solve.placed import Placed, Straddling, straddling, target_window
from kinestitch.solve.rivals.gap import check_halflife, check_width, gap_between, spans
from kinestitch.solve.solved import as_motion

_LONGEST, _SHORTEST = 1.0, 0.05  # s, between which the half-life of each axis is chosen


def dead_blend(placed: Placed, width: int, *, halflife: float | None = None) -> Motion:
    """Dead blending: from the last frame before a seam the left source goes on at a velocity that decays, and the
    result fades from there to the right source within `width` frames.

        extrapolated(t) = exp(ω (1 − exp(−y t)) / y) a(m−1) ,   y = ln 2 / halflife
        result(t) = slerp(extrapolated(t), b(t), s²(3 − 2s)) ,   s = t / width

    width : frames after m−1, at least 1, no more than the segment has; frame m−1 + width is the right source's again
    halflife : s, of the velocity; None lets every axis of every joint have its own, the time in which it would reach
    the right source at its present speed, between 0.05 and 1 s, and 0.05 s where it moves away

    ω and the translations' velocity are the left source's own from m−1 to m. The way to fade over is the shorter one at
    the seam and is followed continuously. Frames before the seam are the left source's.

    Source: D. Holden, *Dead Blending* and *Dead Blending Node in Unreal Engine* (theorangeduck.com, 2023), the latter
    for the half-lives.

    Raises ParameterError for width < 1 or a half-life that is not positive.
    """
    check_width(width)
    if halflife is not None:
        check_halflife(halflife)
    rotations, translations = target_window(placed, 0, placed.frames)
    for seam, end in spans(placed):
        length = max(1, min(width, end - seam.frame))
        here = slice(seam.frame, seam.frame + length)
        around = straddling(placed, seam)
        time = np.arange(length + 1.0)
        turned, moved = _run_on(around, time, halflife, placed.timeline.fps)
        share = time / length
        share = (share**2 * (3 - 2 * share))[:, None, None]
        right = np.concatenate([around.rotations[2:3], rotations[here]])
        relative = quat_multiply(quat_conjugate(turned), right)
        relative[0] *= np.where(relative[0, :, 3:] < 0, -1.0, 1.0)
        way = quat_log(quat_continuous(relative))
        rotations[here] = quat_multiply(turned, rotvec_to_quat(share * way))[1:]
        translations[here] = moved[1:] + share[1:] * (translations[here] - moved[1:])
    return as_motion(placed, rotations, translations)


def _run_on(around: Straddling, time: Array, halflife: float | None, fps: float) -> tuple[Array, Array]:
    """The left source beyond frame m−1: rotations (n, J, 4) and translations (n, J, 3); time : (n,) frames."""
    a, places = around.rotations, around.translations
    step = quat_multiply(a[1], quat_conjugate(a[0]))
    turn = quat_log(np.where(step[:, 3:] < 0, -step, step))
    speed = np.concatenate([turn, places[1] - places[0]], axis=-1)
    x, _ = gap_between(a, places).start
    lives = _half_lives(-x, speed, fps) if halflife is None else np.full(speed.shape, halflife * fps)
    y = math.log(2) / lives
    way = speed * (-np.expm1(-y * time[:, None, None]) / y)
    return quat_multiply(rotvec_to_quat(way[..., :3]), a[0]), places[0] + way[..., 3:]


def _half_lives(gap: Array, speed: Array, fps: float) -> Array:
    """In frames, for each axis (J, 6): as long as it would take to close the gap, within bounds."""
    away = np.abs(speed) < 1e-12
    frames = gap / np.where(away, 1.0, speed)
    return np.clip(np.where(away, np.inf, frames), _SHORTEST * fps, _LONGEST * fps)
