"""What a seam adds, measured on movements whose values are known: a sine, a step, a constant turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.analysis import smoothness as s
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_multiply, quat_normalize
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.errors import ParameterError
from kinestitch.solve.rivals import crossfade, hermite, inertialize
from kinestitch.solve.solved import Solved
from kinestitch.solve.stitch import solve_timeline
from kinestitch.testing import random_motion

FPS = 50.0
RIG = Skeleton(("Hips", "Arm", "Hand"), (-1, 0, 1), [[0, 1, 0], [0, 0.3, 0], [0, 0.4, 0]])
BEND = quat_normalize(np.array([0.3, -0.2, 0.5, 0.7]))


def arm(angles: np.ndarray, before: np.ndarray = BEND) -> Motion:
    """A body whose arm turns by these angles about its own X axis, from a bent pose; its hand hangs still."""
    rotations = np.zeros((len(angles), 3, 4))
    rotations[..., 3] = 1.0
    rotations[:, 1] = quat_multiply(before, quat_about_axis(0, angles))
    return Motion(RIG, np.broadcast_to(RIG.offsets, (len(angles), 3, 3)), rotations, FPS)


def joined(left: Motion, right: Motion, cut: int, stiffness: float = 100.0) -> Solved:
    infos = (ClipInfo("a", left.frames, left.fps), ClipInfo("b", right.frames, right.fps))
    segments = (Segment("a", FrameRange(0, cut)), Segment("b", FrameRange(cut, right.frames)))
    timeline = Timeline(infos, segments, (Seam(stiffness=stiffness),), left.fps)
    return solve_timeline(timeline, {"a": left, "b": right})


def test_a_constant_turn_has_one_velocity_and_no_acceleration():
    motion = arm(2.0 * np.arange(40) / FPS)
    velocity = s.angular_velocity(motion.rotations, FPS)
    np.testing.assert_allclose(velocity[:, 1], np.tile([2.0, 0, 0], (39, 1)), atol=1e-12)
    np.testing.assert_allclose(s.angular_acceleration(motion.rotations, FPS), 0.0, atol=1e-9)


def test_a_sine_has_the_acceleration_of_a_sine():
    time = np.arange(200) / FPS
    found = s.angular_acceleration(arm(0.5 * np.sin(3 * time)).rotations, FPS)[:, 1, 0]
    np.testing.assert_allclose(
        found, -0.5 * 9 * np.sin(3 * time[1:-1]) * np.sinc(3 / (2 * np.pi * FPS)) ** 2, atol=1e-9
    )


def test_a_step_adds_its_height_and_a_still_pose_nothing():
    """A cut between two still poses 0.4 rad apart: one interval at 0.4 fps, two frames at 0.4 fps²."""
    solved = joined(arm(np.zeros(60)), arm(np.full(60, 0.4)), 30)
    (seam,) = solved.seams
    speed = s.added_velocity(solved.cut, solved.placed, seam, 10)
    bend = s.added_acceleration(solved.cut, solved.placed, seam, 10)
    np.testing.assert_allclose(speed.added, [0, 0.4 * FPS, 0], atol=1e-9)
    np.testing.assert_allclose(bend.added, [0, 0.4 * FPS**2, 0], atol=1e-6)
    np.testing.assert_allclose(bend.strongest, bend.added)
    assert bend.peak == bend.total == np.inf
    assert bend.per_joint.tolist() == [0.0, np.inf, 0.0]


def test_the_published_closed_form_of_added_acceleration():
    """Over a gap d between still poses the method adds 0.161 d/√λ a frame²."""
    solved = joined(arm(np.zeros(200)), arm(np.full(200, 0.4)), 100, stiffness=1e4)
    found = s.added_acceleration(solved.motion, solved.placed, solved.seams[0], 100).added[1]
    assert found == pytest.approx(0.161 * 0.4 / 100 * FPS**2, rel=0.02)


def test_added_is_counted_beyond_the_sources_own():
    """Two sines in step, 0.3 rad apart: own is the sine's 95th percentile, added what the cut's pop exceeds it by."""
    time = np.arange(300) / FPS
    wave = 0.5 * np.sin(4 * time)
    solved = joined(arm(wave), arm(wave + 0.3), 150)
    (seam,) = solved.seams
    own = np.abs(s.angular_acceleration(arm(wave).rotations, FPS)[49:249, 1, 0])
    found = s.added_acceleration(solved.cut, solved.placed, seam, 100)
    assert found.own[1] == pytest.approx(np.percentile(own, 95))
    assert found.own_body == pytest.approx(found.own[1])
    assert found.added[1] == pytest.approx(0.3 * FPS**2, rel=0.02)
    assert found.peak == found.per_joint[1] == pytest.approx(found.added[1] / found.own[1])
    assert found.total == pytest.approx(found.strongest[1] / found.own[1])
    assert found.own[0] == found.added[0] == found.per_joint[0] == 0.0


def test_what_survives_is_not_made_up_for_by_what_is_added():
    """Sources that nod in step: a hard cut keeps all and adds a pop, a crossfade of opposite nods leaves nothing."""
    wave = 0.3 * np.sin(np.arange(300) / 5)
    cut = joined(arm(wave), arm(wave + 0.3), 150)
    found = s.added_acceleration(cut.cut, cut.placed, cut.seams[0], 100)
    assert found.survived == pytest.approx(1.0, abs=1e-3)
    assert found.kept > 1.1
    against = joined(arm(wave), arm(-wave), 150)
    faded = s.added_acceleration(crossfade(against.placed, 100), against.placed, against.seams[0], 100)
    assert faded.kept == pytest.approx(np.sqrt(1 / 3), abs=0.03)
    assert faded.survived == pytest.approx(faded.kept, abs=0.03)


def test_a_clip_joined_to_itself_adds_nothing():
    clip = random_motion(3, frames=90)
    clips = joined(clip, replace(clip, name="again"), 40)
    for measure in (s.added_acceleration, s.added_velocity):
        found = measure(clips.cut, clips.placed, clips.seams[0], 20)
        np.testing.assert_allclose(found.added, 0.0, atol=1e-8)
        assert found.peak < 1e-8
        assert found.own_body > 0.1


def test_a_constant_turn_of_the_whole_arm_changes_no_measure():
    """What is measured depends on neither the rest pose nor on which way the limb hangs."""
    time = np.arange(120) / FPS
    values = []
    for before in (BEND, quat_normalize(np.array([0.9, 0.1, -0.3, 0.05]))):
        solved = joined(arm(np.sin(4 * time), before), arm(0.6 * np.cos(2 * time), before), 60)
        faded = crossfade(solved.placed, 10)
        values.append(s.added_acceleration(faded, solved.placed, solved.seams[0], 30).added)
    np.testing.assert_allclose(values[0], values[1], atol=1e-6)


def test_overshoot_of_the_method_is_its_published_share_of_the_gap():
    solved = joined(arm(np.zeros(300)), arm(np.full(300, 0.9)), 150, stiffness=1e3)
    found = s.overshoot(solved.motion, solved.cut, solved.placed, solved.seams[0], 150)
    assert found[1] == pytest.approx(0.033 * 0.9, rel=0.03)
    assert found[[0, 2]].tolist() == [0.0, 0.0]


def test_a_spring_let_go_at_rest_and_a_polynomial_do_not_overshoot_and_one_let_go_outwards_does():
    solved = joined(arm(np.zeros(200)), arm(np.full(200, 0.9)), 100)
    for found in (inertialize(solved.placed, 0.2), hermite(solved.placed, 30)):
        assert s.overshoot(found, solved.cut, solved.placed, solved.seams[0], 90).max() < 1e-9
    away = joined(arm(-0.05 * (np.arange(200) - 99.0)), arm(np.full(200, 0.9)), 100)
    found = inertialize(away.placed, 0.2)
    assert s.overshoot(found, away.cut, away.placed, away.seams[0], 90)[1] < 1e-9
    past = joined(arm(0.2 * (np.arange(200) - 99.0)), arm(np.full(200, 0.9)), 100)
    found = inertialize(past.placed, 0.2)
    y = 2 * np.log(2) / 0.2
    x, v = -0.9, 0.2 * FPS
    time = np.arange(1, 100) / FPS
    expected = (np.exp(-y * time) * (x + (v + y * x) * time)).max()
    assert s.overshoot(found, past.cut, past.placed, past.seams[0], 99)[1] == pytest.approx(expected, rel=1e-6)


def moving(positions: np.ndarray, fps: float = FPS) -> Motion:
    """A body that moves as a whole: hips at (F, 3) m."""
    translations = np.broadcast_to(RIG.offsets, (len(positions), 3, 3)).copy()
    translations[:, 0] = positions
    rotations = np.zeros((len(positions), 3, 4))
    rotations[..., 3] = 1.0
    return Motion(RIG, translations, rotations, fps)


def test_jerk_of_a_cubic_path_is_constant_and_adds_up_over_axes():
    k = np.arange(20.0)
    path = np.stack([k**3, -2 * k**3, 5 * k**2], axis=-1) * 1e-4
    np.testing.assert_allclose(s.jerk(moving(path)), 6e-4 + 12e-4, atol=1e-12)


def test_peak_and_area_of_a_step():
    """A hop of 0.1 m between frames 9 and 10: third differences 0.1, −0.2, 0.1."""
    path = np.zeros((20, 3))
    path[10:, 0] = 0.1
    still, hop = moving(np.zeros((20, 3))), moving(path)
    assert s.peak_jerk([hop]) == pytest.approx(0.2)
    assert s.area_under_jerk([hop], 0.0) == pytest.approx(0.4)
    assert s.peak_jerk([hop, still]) == pytest.approx(0.1)
    assert s.area_under_jerk([still], 0.05) == pytest.approx(17 * 0.05)
    assert s.area_under_jerk([hop, still], 0.0) == pytest.approx(0.2)


def test_what_cannot_be_measured_is_refused():
    with pytest.raises(ParameterError, match="at least 4 frames"):
        s.jerk(moving(np.zeros((3, 3))))
    with pytest.raises(ParameterError, match="one length"):
        s.mean_jerk([moving(np.zeros((9, 3))), moving(np.zeros((8, 3)))])
    solved = joined(arm(np.zeros(60)), arm(np.ones(60)), 30)
    with pytest.raises(ParameterError, match="reach"):
        s.added_acceleration(solved.cut, solved.placed, solved.seams[0], 0)
