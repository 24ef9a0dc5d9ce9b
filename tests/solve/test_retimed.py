"""Retimed clips on a timeline that is solved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.core.kinematics import world_pose
from kinestitch.core.retime import poses_at
from kinestitch.core.rotation import quat_conjugate, quat_distance, quat_multiply, quat_to_rotvec
from kinestitch.edit.retiming import Retiming
from kinestitch.edit.speed import set_speed
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.errors import MissingClipError, RangeError
from kinestitch.solve.placed import place_timeline

CLIPS = {"walk": ks.sample("walk", fps=30.0), "kick": ks.sample("kick")}
LINE = ks.replace(ks.timeline(CLIPS, "walk"), 40, 60, "kick", 30, 112)


def test_only_sources_have_to_be_there():
    line = set_speed(LINE, 1, 0.5)
    assert ks.stitch(line, CLIPS).frames == line.frames == LINE.frames + 41
    with pytest.raises(MissingClipError, match="motion for clip 'kick'"):
        place_timeline(line, {"walk": CLIPS["walk"]})
    with pytest.raises(RangeError, match="151 frames in clip 'kick'"):
        place_timeline(line, CLIPS | {"kick": _shorter(CLIPS["kick"])})


def _shorter(motion: ks.Motion) -> ks.Motion:
    return replace(motion, rotations=motion.rotations[:-1], translations=motion.translations[:-1])


def test_one_interpolation_from_the_source_s_frames():
    placed = place_timeline(set_speed(LINE, 1, 0.7), CLIPS)
    slow = placed.sources["kick ×0.7"]
    assert slow.fps == 30.0
    expected = poses_at(CLIPS["kick"], np.arange(slow.frames) / 30.0 * 0.7 * 60.0)
    assert quat_distance(slow.rotations, expected.rotations).max() < 1e-9
    assert np.allclose(slow.translations, expected.translations)


def test_a_whole_clip_at_another_speed_is_no_longer_and_goes_no_further():
    line = set_speed(ks.timeline(CLIPS, "walk"), 0, 0.5)
    slow = ks.stitch(line, CLIPS)
    assert slow.frames == 2 * CLIPS["walk"].frames - 1
    assert np.array_equal(slow.rotations[::2], CLIPS["walk"].rotations)
    assert np.allclose(world_pose(slow).positions[-1], world_pose(CLIPS["walk"]).positions[-1])
    fast = ks.stitch(set_speed(line, 0, 2.0), CLIPS)
    assert np.array_equal(fast.rotations, CLIPS["walk"].rotations[::2])


def test_seams_between_two_speeds_of_one_clip_are_solved():
    line = set_speed(ks.append(ks.delete(ks.timeline(CLIPS, "walk"), 60, 101), "walk", 60, seam=ks.Seam()), 1, 0.5)
    solved = ks.solve_timeline(line, CLIPS)
    assert [seam.frame for seam in solved.seams] == [60]

    def bend(motion: ks.Motion) -> float:
        turns = quat_to_rotvec(quat_multiply(quat_conjugate(motion.rotations[:-1]), motion.rotations[1:]))
        return float(np.linalg.norm(np.diff(turns, axis=0), axis=-1)[50:70].max())

    assert bend(solved.motion) < bend(solved.cut)


def test_pieces_at_one_speed_have_no_seam_to_solve():
    line = ks.append(ks.delete(ks.timeline(CLIPS, "walk"), 60, 101), "walk", 60)
    for index in (0, 1):
        line = set_speed(line, index, 0.7)
    assert ks.solve_timeline(line, CLIPS).seams == ()


def test_the_original_s_body_is_kept_where_only_retimed_parts_of_it_are_shown():
    small = ks.sample("kick", fps=30.0)
    skeleton = replace(small.skeleton, offsets=small.skeleton.offsets * 0.5)
    clips = CLIPS | {"kick": replace(small, skeleton=skeleton, translations=small.translations * 0.5)}
    line = ks.replace(ks.timeline(clips, "walk"), 0, 60, "kick", 0, 40)
    slow = set_speed(line, 1, 0.5)
    assert place_timeline(slow, clips).skeleton is CLIPS["walk"].skeleton


def test_time_runs_backwards_through_a_retiming():
    """Clip, knots and cut reversed in time give the reversed result."""

    def backwards(motion: ks.Motion) -> ks.Motion:
        return replace(motion, rotations=motion.rotations[::-1], translations=motion.translations[::-1])

    walk, run = CLIPS["walk"], ks.sample("run", fps=30.0)
    end = walk.duration
    knots = ((0.0, 0.0), (1.0, 1.2), (2.0, 1.9), (3.0, end))
    mirrored = tuple((3.0 - time, end - shown) for time, shown in reversed(knots))
    frames = 91  # 3 s

    def line(own: tuple, first: bool) -> Timeline:
        bent = ClipInfo("bent", frames, 30.0, Retiming("walk", own))
        infos = (ClipInfo("walk", walk.frames, 30.0), ClipInfo("run", run.frames, 30.0), bent)
        segments = [Segment("bent", FrameRange(0, 60)), Segment("run", FrameRange(20, run.frames))]
        if not first:
            segments = [
                Segment("run", FrameRange(0, run.frames - 20)),
                Segment("bent", FrameRange(frames - 60, frames)),
            ]
        return Timeline(infos, tuple(segments), (Seam(),), 30.0)

    there = ks.stitch(line(knots, True), {"walk": walk, "run": run})
    back = ks.stitch(line(mirrored, False), {"walk": backwards(walk), "run": backwards(run)})
    below = slice(1, None)  # the hips are placed from the first frame on
    assert quat_distance(there.rotations[:, below], back.rotations[::-1][:, below]).max() < 1e-6
