"""Another frame rate for the same movement."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_slerp
from kinestitch.errors import ParameterError

RATE_TOLERANCE = 5e-4
"""Rates within this share of each other count as equal: BVH's 0.0333333 s is 30 fps."""


MOST_POSES = 50_000_000
"""Frames times joints that a resampled clip may have: some gigabytes, or two hours of 65 joints at 100 fps."""


def same_rate(fps: float, other: float) -> bool:
    """Whether two frame rates count as equal."""
    return abs(fps - other) <= RATE_TOLERANCE * max(fps, other)


def resampled_frames(frames: int, fps: float, new_fps: float) -> int:
    """Number of frames a clip of `frames` at `fps` has at `new_fps`: all that fall on or before its last frame."""
    if same_rate(fps, new_fps):
        return frames
    return math.floor((frames - 1) * new_fps / fps + 1e-6) + 1


def resampled_bound(bound: int, frames: int, fps: float, new_fps: float) -> int:
    """Where the range bound `bound` of a clip lies at `new_fps`: the nearest frame (halves go up), inside the new
    clip.
    """
    if same_rate(fps, new_fps):
        return bound
    return min(math.floor(bound * new_fps / fps + 0.5), resampled_frames(frames, fps, new_fps))


def resample(motion: Motion, fps: float) -> Motion:
    """The motion at another frame rate: rotations by slerp, translations linearly.

    Frame 0 stays; frame k of the result is the pose at time k / fps. Where the rates are equal (to 0.05 %) no frame is
    touched. Raises ParameterError for fps ≤ 0.
    """
    if not (math.isfinite(fps) and fps > 0):
        raise ParameterError(f"Expected fps > 0, got {fps}. Give frames a second, such as 30.")
    if same_rate(motion.fps, fps):
        return motion if motion.fps == fps else replace(motion, fps=fps)
    values = resampled_frames(motion.frames, motion.fps, fps) * motion.skeleton.joint_count
    if values > MOST_POSES:
        raise ParameterError(
            f"Expected a rate that leaves at most {MOST_POSES:,} joint poses, got {fps:g} fps, which makes {values:,}."
        )
    position = np.arange(resampled_frames(motion.frames, motion.fps, fps)) * (motion.fps / fps)
    nearest = np.rint(position)
    position = np.where(np.abs(position - nearest) < 1e-6, nearest, position)
    left = np.minimum(position.astype(np.intp), motion.frames - 1)
    right = np.minimum(left + 1, motion.frames - 1)
    share = position - left
    rotations = quat_slerp(motion.rotations[left], motion.rotations[right], share[:, None])
    rotations[share == 0] = motion.rotations[left[share == 0]]
    start = motion.translations[left]
    translations = start + share[:, None, None] * (motion.translations[right] - start)
    return replace(motion, translations=translations, rotations=rotations, fps=fps)
