"""Clips that are joined whole and share the joining pose: the pose is shown once, not twice.

|  walk …, pose  |  pose, walk …  |   →   |  walk …, pose  |  walk …  |
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from kinestitch.core.motion import Motion
    from kinestitch.edit import Timeline
    from kinestitch.solve.placed import Placed

SAME_TURN = 1e-6
"""rad: what local rotations of equal poses may differ by."""

SAME_PLACE = 1e-5
"""m: what local translations of equal poses, and the height of the body, may differ by."""


def drop_repeated_poses(timeline: Timeline, clips: Mapping[str, Motion], appended: int) -> tuple[Timeline, list[str]]:
    """The timeline without the first frame of every appended whole clip that only repeats the frame before it.

    appended : how many of the last segments were appended

    Poses are compared after placement: the body's heading and its place on the ground do not count. Returns a sentence
    for every frame dropped.
    """
    from kinestitch.edit import FrameRange, Segment
    from kinestitch.edit.pieces import with_bounds
    from kinestitch.solve.placed import place_timeline

    seams = [s for s in range(max(0, len(timeline.seams) - appended), len(timeline.seams)) if _whole(timeline, s)]
    if not seams:
        return timeline, []
    placed = place_timeline(timeline, clips)
    segments, notes = list(timeline.segments), []
    for seam in seams:
        left, right = timeline.segments[seam], timeline.segments[seam + 1]
        if len(right) > 1 and _same_pose(placed, seam):
            segments[seam + 1] = Segment(right.clip, FrameRange(1, right.range.stop))
            notes.append(f"{right.clip} starts with the last pose of {left.clip}; that frame is kept once.")
    return with_bounds(timeline, segments), notes


def _whole(timeline: Timeline, seam: int) -> bool:
    """Whether a seam joins the last frame of one clip to the first of another that is shown to its end."""
    left, right = timeline.segments[seam], timeline.segments[seam + 1]
    last, frames = (timeline.clip(segment.clip).frames_at(timeline.fps) for segment in (left, right))
    return left.range.stop == last and (right.range.start, right.range.stop) == (0, frames)


def _same_pose(placed: Placed, seam: int) -> bool:
    from kinestitch.core.rotation import quat_conjugate, quat_distance, quat_multiply

    left, right = placed.timeline.segments[seam], placed.timeline.segments[seam + 1]
    a, b = placed.sources[left.clip], placed.sources[right.clip]
    before, after = a.rotations[left.range.stop - 1], b.rotations[right.range.start]
    turns = quat_distance(before, after)
    between = quat_multiply(before[placed.carrier], quat_conjugate(after[placed.carrier]))
    turns[placed.carrier] = 2 * np.arcsin(min(1.0, float(np.hypot(between[0], between[2]))))  # all but the yaw
    moves = np.abs(a.translations[left.range.stop - 1] - b.translations[right.range.start])
    moves[placed.carrier, [0, 2]] = 0.0
    return bool(turns.max() <= SAME_TURN and moves.max() <= SAME_PLACE)
