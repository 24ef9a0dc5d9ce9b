"""Dynamics kept in the chart, beside the same measured without one."""

from __future__ import annotations

import numpy as np
import pytest

from kinestitch.analysis.quality import dynamics_kept
from kinestitch.analysis.smoothness import added_acceleration
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_multiply, quat_normalize
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.rivals import crossfade, dead_blend, hermite, inertialize
from kinestitch.solve.seam import visible_reach
from kinestitch.solve.stitch import stitch

RIG = Skeleton(("Hips", "Arm"), (-1, 0), [[0, 1, 0], [0, 0.3, 0]])
TILTED = quat_normalize(np.array([0.2, -0.4, 0.3, 0.8]))


def arm(angles: np.ndarray, sign: float = 1.0) -> Motion:
    rotations = np.zeros((len(angles), 2, 4))
    rotations[..., 3] = 1.0
    rotations[:, 1] = sign * quat_multiply(TILTED, quat_about_axis(0, angles))
    return Motion(RIG, np.broadcast_to(RIG.offsets, (len(angles), 2, 3)), rotations, 30.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("gap", [0.3, 2.0, 2.9, 3.3])
def test_every_method_is_told_on_one_branch_across_the_seam(gap: float, sign: float):
    """A clip may hold q or −q for the same rotation, and the result whichever its method came to."""
    time = np.arange(120) / 30
    clips = {"a": arm(0.4 * np.sin(5 * time)), "b": arm(gap + 0.4 * np.sin(5 * time + 0.5), sign)}
    infos = tuple(ClipInfo(key, 120, 30.0) for key in clips)
    segments = (Segment("a", FrameRange(0, 60)), Segment("b", FrameRange(60, 120)))
    placed = place_timeline(Timeline(infos, segments, (Seam(stiffness=500.0),), 30.0), clips)
    (seam,) = placed.seams
    for motion in (
        stitch(placed.timeline, clips),
        crossfade(placed, 12),
        inertialize(placed, 0.2),
        dead_blend(placed, 12),
        hermite(placed, 12, sides="both"),
    ):
        free = added_acceleration(motion, placed, seam, visible_reach(seam.stiffness)).kept
        assert dynamics_kept(motion, placed, seam) == pytest.approx(free, rel=0.15)
