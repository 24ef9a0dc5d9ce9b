"""The whole stitch against the method spelled out slowly, and what a user may rely on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from solve_oracles import cast, line, naive_stitch

from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.resample import resample
from kinestitch.core.rotation import quat_distance
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline, timeline
from kinestitch.errors import MissingClipError, ParameterError, RangeError, SkeletonMismatchError
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.seam import seam_reach
from kinestitch.solve.stitch import solve_seam, solve_timeline, stitch
from kinestitch.testing import assert_motion_close, check_motion, random_motion

Parts = list[tuple[str, int, int]]

LINES: dict[str, Parts] = {
    "one seam": [("a", 0, 30), ("b", 10, 60)],
    "near the ends": [("a", 0, 3), ("b", 60, 64)],
    "own neighbours missing": [("a", 0, 70), ("b", 0, 70)],
    "a clip replaced in": [("a", 0, 30), ("b", 10, 20), ("a", 40, 70)],
    "a jump within a clip": [("a", 0, 30), ("a", 35, 70)],
    "backwards in a clip": [("a", 20, 50), ("a", 10, 40)],
    "short segments": [("a", 0, 2), ("b", 10, 12), ("c", 40, 42)],
    "single frames": [("a", 5, 6), ("b", 10, 11), ("c", 40, 41), ("a", 3, 9)],
    "two frames": [("a", 5, 6), ("b", 10, 11)],
    "many": [("a", 0, 9), ("b", 3, 9), ("c", 60, 70), ("b", 20, 29), ("a", 40, 66)],
}


@pytest.mark.parametrize("chart", ["centred", "principal"])
@pytest.mark.parametrize("stiffness", [1.0, 81.0, 1e4])
@pytest.mark.parametrize("name", LINES)
def test_equals_the_method_spelled_out(name: str, stiffness: float, chart: str):
    clips = cast(3, frames=70)
    parts = line(LINES[name], clips, Seam(stiffness=stiffness))
    ours, slow = stitch(parts, clips, chart=chart), naive_stitch(parts, clips, chart)  # type: ignore[arg-type]
    check_motion(ours)
    assert_motion_close(ours, slow, degrees=np.degrees(1e-9), metres=1e-9)


@pytest.mark.parametrize("name", ["a clip replaced in", "short segments"])
def test_equals_it_on_bodies_whose_hips_are_not_the_root(name: str):
    clips = cast(3, frames=70, joints=8, bend=0.8)
    parts = line(LINES[name], clips, Seam(stiffness=81.0))
    assert_motion_close(stitch(parts, clips), naive_stitch(parts, clips), degrees=np.degrees(1e-9), metres=1e-9)


def test_equals_it_with_a_stiffness_for_each_seam():
    clips = cast(3, frames=70)
    seams = [Seam(stiffness=1e4), Seam(stiffness=1.0), Seam(stiffness=81.0), Seam(smoothing=0.2)]
    parts = line(LINES["many"], clips, *seams)
    assert_motion_close(stitch(parts, clips), naive_stitch(parts, clips), degrees=np.degrees(1e-9), metres=1e-9)


def test_a_timeline_without_seams_is_its_clip():
    clips = cast(1)
    assert_motion_close(stitch(timeline(clips, "a"), clips), clips["a"], degrees=1e-12, metres=0)
    part = stitch(line([("a", 7, 21)], clips), clips)
    np.testing.assert_array_equal(part.rotations, clips["a"].rotations[7:21])
    np.testing.assert_array_equal(part.translations, clips["a"].translations[7:21])


@pytest.mark.parametrize("chart", ["centred", "principal"])
def test_frames_out_of_reach_of_every_seam_do_not_move(chart: str):
    clips = cast(2, frames=400)
    parts = line([("a", 0, 150), ("b", 20, 240), ("a", 200, 400)], clips, Seam(stiffness=1.0))
    out = stitch(parts, clips, chart=chart)  # type: ignore[arg-type]
    cut = stitch(parts, clips, method="cut")
    reach = seam_reach(1.0)
    moved = np.zeros(out.frames, dtype=bool)
    for m in (150, 370):
        moved[m - reach : m + reach] = True
    np.testing.assert_array_equal(out.rotations[~moved], cut.rotations[~moved])
    np.testing.assert_array_equal(out.rotations[:100], clips["a"].rotations[:100])
    np.testing.assert_array_equal(out.rotations[200:300, 1:], clips["b"].rotations[70:170, 1:])
    np.testing.assert_array_equal(out.translations[:100], clips["a"].translations[:100])
    np.testing.assert_array_equal(out.translations[~moved], cut.translations[~moved])
    assert quat_distance(out.rotations[149:151], cut.rotations[149:151]).max() > 0.01


def test_no_stiffness_is_the_hard_cut():
    clips = cast(3)
    parts = line([("a", 0, 20), ("b", 5, 30), ("c", 2, 9)], clips, Seam(stiffness=0.0))
    solved = solve_timeline(parts, clips)
    np.testing.assert_array_equal(solved.motion.rotations, solved.cut.rotations)
    np.testing.assert_array_equal(solved.motion.translations, solved.cut.translations)
    np.testing.assert_array_equal(solved.cut.rotations[:20], clips["a"].rotations[:20])
    np.testing.assert_array_equal(solved.cut.rotations[20:45, 1:], clips["b"].rotations[5:30, 1:])


def test_a_stiffness_that_vanishes_approaches_the_hard_cut():
    clips = cast(2)
    parts = [("a", 0, 20), ("b", 5, 30)]
    cut = stitch(line(parts, clips), clips, method="cut")
    for stiffness in (1e-3, 1e-6, 1e-9):
        out = stitch(line(parts, clips, Seam(stiffness=stiffness)), clips)
        assert quat_distance(out.rotations, cut.rotations).max() < 20 * stiffness


@pytest.mark.parametrize("parts", [LINES["a clip replaced in"], LINES["short segments"], LINES["many"]])
def test_a_hard_cut_beside_a_soft_seam_is_the_limit_of_a_small_stiffness(parts: Parts):
    clips = cast(3, frames=70)
    soft = [Seam(stiffness=81.0)] * (len(parts) - 2)
    hard = stitch(line(parts, clips, *soft, Seam(stiffness=0.0)), clips)
    for stiffness in (1e-4, 1e-7):
        nearly = stitch(line(parts, clips, *soft, Seam(stiffness=stiffness)), clips)
        assert quat_distance(nearly.rotations, hard.rotations).max() < 100 * stiffness
        assert np.abs(nearly.translations - hard.translations).max() < 100 * stiffness


def test_no_correction_crosses_a_hard_cut():
    clips = cast(3, frames=100)
    parts = line([("a", 0, 40), ("b", 10, 20), ("c", 30, 90)], clips, Seam(stiffness=81.0), Seam(stiffness=0.0))
    solved = solve_timeline(parts, clips)
    before, after = (quat_distance(solved.motion.rotations[f], solved.cut.rotations[f]).max() for f in (49, 50))
    assert before > 0.01
    assert after < 1e-9
    np.testing.assert_allclose(
        solved.motion.translations[50:, 1:], solved.cut.translations[50:, 1:], rtol=0, atol=1e-12
    )


def test_solve_timeline_holds_what_stitch_returns():
    clips = cast(3)
    parts = line([("a", 0, 20), ("b", 5, 30), ("b", 30, 35), ("c", 2, 9)], clips)
    solved = solve_timeline(parts, clips)
    np.testing.assert_array_equal(solved.motion.rotations, stitch(parts, clips).rotations)
    np.testing.assert_array_equal(solved.cut.rotations, stitch(parts, clips, method="cut").rotations)
    assert [(seam.index, seam.frame, seam.stiffness) for seam in solved.seams] == [(0, 20, 81.0), (2, 50, 81.0)]
    assert solve_timeline(parts, clips, method="cut").motion.rotations is not solved.motion.rotations


def test_one_seam_is_the_window_of_the_whole():
    clips = cast(3, frames=300)
    parts = line([("a", 0, 200), ("b", 5, 290), ("c", 2, 300), ("a", 0, 20)], clips, Seam(stiffness=1.0))
    whole = stitch(parts, clips)
    placed = place_timeline(parts, clips)
    for index in range(3):
        window = solve_seam(placed, index)
        here = slice(window.start, window.stop)
        np.testing.assert_allclose(window.rotations, whole.rotations[here], rtol=0, atol=1e-15)
        np.testing.assert_allclose(window.translations, whole.translations[here], rtol=0, atol=1e-15)
    assert (solve_seam(placed, 0).start, solve_seam(placed, 0).stop) == (152, 248)


def test_seams_that_are_none():
    clips = cast(1)
    parts = line([("a", 0, 20), ("a", 20, 40)], clips)
    placed = place_timeline(parts, clips)
    assert placed.seams == ()
    for index in (0, 1, -1):
        with pytest.raises(ParameterError, match="something to solve"):
            solve_seam(placed, index)


def test_other_rates_are_resampled_to_the_timelines():
    clips = {"a": random_motion(1, fps=30.0), "b": random_motion(2, fps=60.0, frames=81)}
    parts = line([("a", 0, 20), ("b", 5, 30)], clips)
    assert parts.fps == 30.0
    ours = stitch(parts, clips)
    same = clips | {"b": resample(clips["b"], 30.0)}
    assert_motion_close(ours, stitch(line([("a", 0, 20), ("b", 5, 30)], same), same), degrees=1e-12, metres=1e-13)


def test_smoothing_time_gives_the_same_seam_at_every_rate():
    slow = {"a": random_motion(1, frames=61), "b": random_motion(2, frames=61)}
    fast = {key: resample(motion, 120.0) for key, motion in slow.items()}
    low = stitch(line([("a", 0, 31), ("b", 30, 61)], slow, Seam(smoothing=0.1)), slow)
    high = stitch(line([("a", 0, 121), ("b", 120, 241)], fast, Seam(smoothing=0.1)), fast)
    cut = stitch(line([("a", 0, 31), ("b", 30, 61)], slow), slow, method="cut")
    gap = quat_distance(cut.rotations[30], cut.rotations[31])
    assert gap.max() > 0.5
    apart = quat_distance(low.rotations[:28], high.rotations[:112:4])
    assert (apart.max(axis=0) < 0.06 * gap + 0.01).all()


def test_what_is_solved_keeps_the_dynamics_and_closes_the_gap():
    clips = cast(2, frames=80)
    solved = solve_timeline(line([("a", 0, 40), ("b", 30, 80)], clips, Seam(stiffness=1296.0)), clips)
    before = quat_distance(solved.cut.rotations[39], solved.cut.rotations[40])
    after = quat_distance(solved.motion.rotations[39], solved.motion.rotations[40])
    own = max(quat_distance(clips[k].rotations[1:], clips[k].rotations[:-1]).max() for k in "ab")
    assert before.max() > 4 * own
    assert (after < 0.08 * before + 1.2 * own).all()


def test_the_result_belongs_to_the_first_clip():
    clips = cast(2)
    clips["b"] = replace(clips["b"], name="other")
    out = stitch(line([("b", 0, 20), ("a", 5, 30)], clips, fps=30.0), clips)
    check_motion(out)
    assert out.fps == 30.0
    assert out.skeleton == clips["a"].skeleton


@pytest.mark.parametrize("verb", [stitch, solve_timeline])
def test_what_is_refused(verb):
    clips = cast(2)
    parts = line([("a", 0, 20), ("b", 5, 30)], clips)
    with pytest.raises(ParameterError, match="Expected a chart out of centred, principal, got 'euler'"):
        verb(parts, clips, chart="euler")
    with pytest.raises(ParameterError, match="Expected a method out of laplacian, cut, got 'fade'"):
        verb(parts, clips, method="fade")
    with pytest.raises(MissingClipError, match="clip 'b', got 'a'"):
        verb(parts, {"a": clips["a"]})
    short = replace(clips["b"], rotations=clips["b"].rotations[:39], translations=clips["b"].translations[:39])
    with pytest.raises(RangeError, match="Expected 40 frames in clip 'b', as its timeline says, got 39"):
        verb(parts, clips | {"b": short})
    with pytest.raises(SkeletonMismatchError, match="differ at joint 4"):
        verb(parts, clips | {"b": random_motion(3, joints=5)})
    with pytest.raises(SkeletonMismatchError, match="joint 4: nothing and 'Joint4'"):
        verb(parts, clips | {"b": random_motion(3, joints=9)})


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
@pytest.mark.parametrize("field", ["stiffness", "smoothing"])
def test_impossible_seams_are_refused(field: str, value: float):
    with pytest.raises(ParameterError, match=f"seam's {field} ≥ 0"):
        Seam(**{field: value})


def test_a_clip_of_another_rate_than_its_timeline_says_is_resampled():
    clips = cast(1)
    info = ClipInfo("a", 40, 30.0)
    parts = Timeline((info,), (Segment("a", FrameRange(0, 79)),), (), 60.0)
    assert_motion_close(stitch(parts, clips), resample(clips["a"], 60.0), degrees=1e-12, metres=0)


def far_away(motion: Motion, yaw: float) -> Motion:
    return turn_about_up(motion, yaw, (13.0, 0.0, -7.0))


def test_the_pasted_clip_may_stand_anywhere():
    clips = cast(2, frames=60)
    parts = [("a", 0, 30), ("b", 10, 40), ("a", 35, 60)]
    plain = stitch(line(parts, clips), clips)
    moved = clips | {"b": far_away(clips["b"], 2.1)}
    assert_motion_close(stitch(line(parts, moved), moved), plain, degrees=np.degrees(1e-9), metres=1e-11)
    steps = np.linalg.norm(np.diff(world_pose(plain).positions[:, 0], axis=0), axis=-1)
    own = max(np.linalg.norm(np.diff(clips[k].translations[:, 0], axis=0), axis=-1).max() for k in "ab")
    assert steps.max() < 1.5 * own
