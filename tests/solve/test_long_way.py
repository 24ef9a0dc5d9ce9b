"""A source that turns almost all the way round between two seams: no gap is closed the long way round."""

import numpy as np
import pytest

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_distance, quat_multiply
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.solve.energy import joint_price, seam_price
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline

FRAMES = 200


def turning(total: float, start: float) -> Motion:
    """An arm that turns by `total` rad between frames 70 and 130, on a hanging body."""
    skeleton = Skeleton(("Hips", "Arm"), (-1, 0), [[0, 1, 0], [0.2, 0, 0]])
    share = np.clip((np.arange(FRAMES) - 70) / 60, 0, 1)
    angle = start + total * share * share * (3 - 2 * share)
    rotations = np.zeros((FRAMES, 2, 4))
    rotations[..., 3] = 1
    rotations[:, 1] = quat_multiply(quat_about_axis(0, angle), quat_about_axis(2, 0.2 * np.sin(angle)))
    translations = np.broadcast_to(skeleton.offsets, (FRAMES, 2, 3))
    return Motion(skeleton, translations, rotations, 30.0)


@pytest.mark.parametrize("degrees", [0, 90, 180, 270, 300, 330, 345, 360, 400, 700])
@pytest.mark.parametrize("sign", [-1, 1])
def test_no_gap_is_closed_the_long_way(degrees, sign):
    solved = with_a_turn(degrees, sign)
    gaps = [quat_distance(solved.cut.rotations[m - 1, 1], solved.cut.rotations[m, 1]) for m in (80, 140)]
    moved = quat_distance(solved.motion.rotations[:, 1], solved.cut.rotations[:, 1])
    assert moved.max() <= 0.65 * max(gaps) + 0.05


@pytest.mark.parametrize("degrees", [0, 90, 330, 345, 360, 400, 700])
@pytest.mark.parametrize("sign", [-1, 1])
def test_no_gap_is_priced_the_long_way(degrees, sign):
    placed = with_a_turn(degrees, sign).placed
    alone = sum(seam_price(placed, seam) for seam in placed.seams)
    assert joint_price(placed) == pytest.approx(alone, rel=0.05)


def with_a_turn(degrees: float, sign: int) -> Solved:
    """Some of the still arm's frames replaced by those in which the other one turns."""
    still, turn = turning(0.0, 0.3), turning(sign * np.radians(degrees), 0.0)
    infos = (ClipInfo("still", FRAMES, 30.0), ClipInfo("turn", FRAMES, 30.0))
    segments = (
        Segment("still", FrameRange(0, 80)),
        Segment("turn", FrameRange(70, 130)),
        Segment("still", FrameRange(100, 200)),
    )
    line = Timeline(infos, segments, (Seam(), Seam()), 30.0)
    return solve_timeline(line, {"still": still, "turn": turn})
