"""The report's numbers on motions made by hand, whose values are known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.analysis import quality
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.seam import visible_reach
from kinestitch.solve.stitch import solve_timeline

RIG = Skeleton(("Hips", "Arm", "Hand"), (-1, 0, 1), [[0, 1, 0], [0, 0.3, 0], [0, 0.3, 0]])
FPS = 30.0


def turning(arm: np.ndarray, *, hips: np.ndarray | None = None, hand: np.ndarray | None = None) -> Motion:
    """Each joint turned about one axis by these angles in rad, so that angles add up and vectors are angles."""
    rotations = np.zeros((len(arm), 3, 4))
    rotations[..., 3] = 1.0
    for joint, angles in ((0, hips), (1, arm), (2, hand)):
        if angles is not None:
            rotations[:, joint] = quat_about_axis(0, np.asarray(angles, dtype=float))
    return Motion(RIG, np.broadcast_to(RIG.offsets, (len(arm), 3, 3)), rotations, FPS)


def moving(hips: list[list[float]]) -> Motion:
    still = turning(np.zeros(len(hips)))
    translations = still.translations.copy()
    translations[:, 0] = hips
    return Motion(RIG, translations, still.rotations, FPS)


def joined(a: Motion, b: Motion, stop: int, start: int, stiffness: float) -> tuple[Timeline, dict[str, Motion]]:
    clips = {"a": a, "b": b}
    infos = tuple(ClipInfo(key, clip.frames, FPS) for key, clip in clips.items())
    segments = (Segment("a", FrameRange(0, stop)), Segment("b", FrameRange(start, b.frames)))
    return Timeline(infos, segments, (Seam(stiffness=stiffness),), FPS), clips


def placed(a: Motion, b: Motion, stop: int, start: int, stiffness: float) -> Placed:
    return place_timeline(*joined(a, b, stop, start, stiffness))


def angles(*degrees: float) -> np.ndarray:
    """The sum of these steps, from 0."""
    return np.radians(np.concatenate([[0.0], np.cumsum(degrees)]))


def test_the_rotation_step_is_the_largest_joints_turn_between_the_two_frames():
    motion = turning(angles(1, 2, 30, 5, 9), hand=-angles(2, 1, 10, 60, 3))
    steps = [np.degrees(quality.rotation_step(motion, frame)) for frame in range(1, 6)]
    np.testing.assert_allclose(steps, [2, 2, 30, 60, 9], atol=1e-6)


@pytest.mark.parametrize(
    ("frame", "change"),
    [(1, 30 - 2), (2, 12 - 2), (3, 19 - 30), (4, 4 - 12), (5, 4 - 19)],
    ids=["first interval stands in", "2", "3", "4", "last interval stands in"],
)
def test_the_velocity_step_compares_the_intervals_beside_the_seams_own(frame: int, change: float):
    motion = turning(angles(2, 30, 12, 19, 4), hand=angles(1, 1, 1, 1, 1))
    wanted = abs(change) * FPS
    assert np.degrees(quality.angular_velocity_step(motion, frame)) == pytest.approx(wanted)


def test_the_deviation_is_measured_over_the_whole_reach_on_both_sides():
    cut = turning(np.zeros(24))
    motion = turning(np.radians(np.arange(24.0)))
    mean, largest = quality.deviation(motion, cut, 12, 4)
    assert np.degrees(mean) == pytest.approx(np.mean(range(8, 16)) / 3)  # one of three joints
    assert np.degrees(largest) == pytest.approx(15)
    mean, largest = quality.deviation(motion, cut, 2, 4)
    assert np.degrees(mean) == pytest.approx(np.mean(range(6)) / 3)  # the clip starts inside the reach
    assert np.degrees(largest) == pytest.approx(5)


def test_the_root_step_counts_height_and_ground():
    motion = moving([[0, 1, 0], [0, 1, 0], [0, 1.07, 0], [0.02, 1.13, 0.09]])
    assert quality.root_step(motion, 1) == pytest.approx(0, abs=1e-12)
    assert quality.root_step(motion, 2) == pytest.approx(0.07)
    assert quality.root_step(motion, 3) == pytest.approx(0.11)  # 2, 6 and 9 cm


@pytest.mark.parametrize("stiffness", [0.0, 0.5, 40.0])
def test_the_price_of_two_poses_held_for_two_frames_each(stiffness: float):
    """L L^T is [[6, −4], [−4, 6]] there and e = (−d, d) its eigenvector of 10: E* = λ ‖e‖² / (1 + 10 λ)."""
    gap, hand = 0.3, 0.2
    b = turning(np.full(2, gap), hand=np.full(2, hand))
    line = placed(turning(np.zeros(2)), b, 2, 0, stiffness)
    wanted = 2 * (gap**2 + hand**2) * stiffness / (1 + 10 * stiffness)
    assert quality.seam_price(line, line.seams[0]) == pytest.approx(wanted)


def test_the_price_is_what_the_solve_leaves():
    """The minimum of the method's own sum, with the least squares written out."""
    count, cut, stiffness, gap = 40, 23, 300.0, 0.4
    line = placed(turning(np.zeros(cut)), turning(np.full(count - cut, gap)), cut, 0, stiffness)
    rows = np.diff(np.eye(count), 2, axis=0)
    target = np.where(np.arange(count) < cut, 0.0, gap)
    stacked = np.vstack([np.eye(count), np.sqrt(stiffness) * rows])
    wanted = np.concatenate([target, np.zeros(count - 2)])
    residual = np.linalg.lstsq(stacked, wanted, rcond=None)[1]
    assert quality.seam_price(line, line.seams[0]) == pytest.approx(float(residual[0]))


@pytest.mark.parametrize("share", [1.0, 0.5, 0.0])
def test_dynamics_kept_is_the_share_of_the_sources_acceleration_and_leaves_out_the_hips(share: float):
    time = np.arange(60.0)
    source = turning(0.5 * 0.002 * (time - 30) ** 2)
    line = placed(source, source, 30, 30, 16.0)
    shaking = 0.2 * (-1.0) ** time
    motion = turning(share * 0.5 * 0.002 * (time - 30) ** 2, hips=shaking)
    assert quality.dynamics_kept(motion, line, line.seams[0]) == pytest.approx(share, abs=1e-9)


def test_the_hips_of_the_sources_do_not_count_either():
    time = np.arange(60.0)
    swing = 0.5 * 0.002 * (time - 30) ** 2
    source = turning(swing, hips=3 * swing)
    line = placed(source, source, 30, 30, 16.0)
    assert quality.dynamics_kept(turning(0.5 * swing), line, line.seams[0]) == pytest.approx(0.5)


def test_the_report_tells_what_an_automatic_seam_took():
    line, clips = joined(turning(np.radians(np.arange(60.0))), turning(np.radians(np.arange(80.0))), 30, 40, 16.0)
    (told,) = quality.report(solve_timeline(line, clips))["seams"]
    assert "automatic" not in told
    solved = solve_timeline(replace(line, seams=(Seam(automatic=True),)), clips)
    (told,) = quality.report(solved)["seams"]
    assert (told["automatic"], told["groups"]) == (True, {})  # nobody can tell this rig's limbs
    assert told["lambda"] == solved.seams[0].stiffness
    assert told["smoothing_s"] == pytest.approx(told["lambda"] ** 0.25 / FPS)


@pytest.mark.parametrize("method", ["laplacian", "cut"])
def test_the_report_is_each_number_in_its_own_unit(method: str):
    a = turning(np.radians(np.arange(60.0)))
    b = turning(np.radians(40 + 3 * np.arange(60.0)))
    solved = solve_timeline(*joined(a, b, 30, 20, 16.0), method=method)
    (told,) = quality.report(solved)["seams"]
    (seam,) = solved.seams
    cut, motion = solved.cut, solved.motion
    assert (told["frame"], told["lambda"]) == (30, 16.0)
    assert told["price"] == quality.seam_price(solved.placed, seam)
    assert told["rotation_step_deg_before"] == pytest.approx(100 - 29)
    assert told["angular_velocity_step_deg_s_before"] == pytest.approx((3 - 1) * FPS)
    assert told["rotation_step_deg_after"] == pytest.approx(np.degrees(quality.rotation_step(motion, 30)))
    after = np.degrees(quality.angular_velocity_step(motion, 30))
    assert told["angular_velocity_step_deg_s_after"] == pytest.approx(after)
    mean, largest = np.degrees(quality.deviation(motion, cut, 30, visible_reach(16.0)))
    assert (told["deviation_mean_deg"], told["deviation_max_deg"]) == pytest.approx((mean, largest))
    assert (largest > 10) == (method == "laplacian")
    assert told["dynamics_kept"] == quality.dynamics_kept(motion, solved.placed, seam)
    assert told["root_step_m_before"] == told["root_step_m_after"] == 0.0
