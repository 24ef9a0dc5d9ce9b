"""The way back to the original path, and the seams that end where it ends."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solve_oracles import dense, laplacian

from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.edit.operations import append, insert
from kinestitch.edit.operations import replace as paste
from kinestitch.edit.pinning import come_back
from kinestitch.edit.pins import Pin, away_again
from kinestitch.edit.timeline import Seam, timeline
from kinestitch.errors import KinestitchWarning
from kinestitch.rig.root_motion import extract_root
from kinestitch.samples import sample
from kinestitch.solve.seam import SeamPlace, clusters, displacement_correction, seam_curves
from kinestitch.solve.stitch import solve_seam, solve_timeline, stitch
from kinestitch.testing import assert_motion_close, check_motion

CLIPS = {name: sample(name) for name in ("walk", "kick")}
LINE = paste(timeline(CLIPS, "walk"), 84, 130, "kick", 30, 112)


def back_from(line, frame):
    """The frame of the last segment's clip that is shown in a frame of the result."""
    return line.segments[-1].range.start + frame - line.starts[-2]


@settings(deadline=None, max_examples=12)
@given(st.floats(0.4, 1.1), st.floats(-3, 3), st.sampled_from(["hips", "root"]), st.integers(30, 120))
def test_the_clip_is_its_own_again(seconds, yaw, kind, at):
    clips = {name: turn_about_up(clip, yaw * (name == "kick"), (yaw, 0.0, 1.0)) for name, clip in CLIPS.items()}
    if kind == "root":
        clips = {name: extract_root(clip) for name, clip in clips.items()}
    line = come_back(paste(timeline(clips, "walk"), at, at + 10, "kick", 30, 112), seconds)
    frame = line.pins[0].frame
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        motion = stitch(line, clips)
    check_motion(motion)
    own = back_from(line, frame)
    ours, theirs = world_pose(motion), world_pose(clips["walk"])
    assert np.abs(ours.positions[frame:] - theirs.positions[own:]).max() < 1e-9
    assert np.abs(np.abs(ours.rotations[frame:] * theirs.rotations[own:]).sum(-1) - 1).max() < 1e-12
    early = stitch(replace(line, pins=()), clips)
    first = line.starts[-2]
    assert np.abs(motion.translations[:at] - early.translations[:at]).max() < 1e-4
    assert np.abs(motion.rotations[: first - 10] - early.rotations[: first - 10]).max() < 5e-3


def test_the_way_back_is_smooth():
    line = come_back(insert(timeline(CLIPS, "walk"), 100, "kick", 30, 112), 1.5)
    motion, plain = stitch(line, CLIPS), stitch(replace(line, pins=()), CLIPS)
    first, frame = line.starts[-2], line.pins[0].frame
    bent, own = (np.diff(world_pose(m).positions[first - 5 : frame + 5, 0], 2, axis=0) * 3600 for m in (motion, plain))
    assert np.linalg.norm(bent, axis=1).max() < 1.5 * np.linalg.norm(own, axis=1).max()


def test_a_hasty_way_back_is_told():
    with pytest.warns(KinestitchWarning, match=r"way back to the original path is 1.\d\d m in 0.3 s"):
        stitch(come_back(LINE, 0.3), CLIPS)


def test_a_pin_behind_the_return_is_told():
    line = come_back(insert(timeline(CLIPS, "walk"), 60, "kick", 30, 112), 1.5)
    frame = line.pins[0].frame
    for pin in (Pin("waypoint", frame + 20, (0.1, 3.55)), Pin("heading", frame + 20, (0.3,))):
        words = rf"return@{frame} leads back to the original path, and {pin.kind}@{frame + 20}=.* away from it again"
        with pytest.warns(KinestitchWarning, match=words):
            stitch(replace(line, pins=(*line.pins, pin)), CLIPS)
    for pin in (Pin("heading", frame - 20, (0.3,)), Pin("rotation", frame + 20, (0.0, 0.0, 0.6, 0.8), "LeftArm")):
        assert away_again(replace(line, pins=(*line.pins, pin)).pins) == ""
    assert away_again((Pin("heading", 20, (0.3,)),)) == ""


def test_what_comes_after_a_return_rides_along_and_may_come_back_again():
    line = come_back(LINE, 1.1)
    line = append(line, "kick", 30, 112, seam=Seam(smoothing=0.05))
    line = append(line, "walk", 100, seam=Seam(smoothing=0.05))
    line = replace(line, pins=(*line.pins, Pin("waypoint", line.frames - 70, (0.5, 4.6)), Pin("heading", 60, (0.3,))))
    line = come_back(line, 1.4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        motion = stitch(line, CLIPS)
    returns = [pin.frame for pin in line.pins if pin.kind == "return"]
    index, own = line.segment_at(returns[0])
    assert np.abs(motion.translations[returns[0], 0] - CLIPS["walk"].translations[own, 0]).max() < 1e-9
    assert np.abs(motion.translations[-1] - CLIPS["walk"].translations[-1]).max() < 1e-9
    assert index == 2


@st.composite
def firm_cases(draw):
    frames = draw(st.integers(30, 90))
    firm = draw(st.integers(5, frames - 5))
    seams = draw(st.lists(st.integers(2, frames - 2), min_size=1, max_size=3, unique=True))
    stiffness = 10.0 ** draw(st.floats(-1, 4))
    return frames, firm, [SeamPlace(k, m, stiffness) for k, m in enumerate(sorted(seams))], draw(st.integers(0, 999))


@given(firm_cases())
def test_seams_beside_a_firm_frame_equal_the_dense_solution_with_that_side_held(case):
    frames, firm, seams, seed = case
    rng = np.random.default_rng(seed)
    total = np.zeros((frames, 2))
    for cluster in clusters(seams, frames, [firm]):
        assert all(a.frame <= firm for a in cluster.seams) or all(a.frame > firm for a in cluster.seams)
        offsets = rng.normal(size=(2 * len(cluster.seams), 2))
        found = np.zeros((frames, 2))
        found[cluster.start : cluster.stop] = seam_curves(cluster) @ offsets
        error = np.zeros((frames, 2))
        for k, seam in enumerate(cluster.seams):
            error[seam.frame - 1] -= offsets[2 * k + 1]
            error[seam.frame] += offsets[2 * k]
        before = cluster.seams[0].frame <= firm
        free = np.arange(frames) < firm if before else np.arange(frames) > firm
        assert np.abs(found[~free]).max() == 0.0
        L = laplacian(frames)
        rows = np.full(frames, seams[0].stiffness)
        rows[[0, -1]] = 0.0
        matrix = np.eye(frames) + L.T @ (rows[:, None] * L)
        rhs = L.T @ (rows[:, None] * error)
        expected = np.linalg.solve(matrix[np.ix_(free, free)], rhs[free])
        reach = cluster.start > 0 and not cluster.held[0], cluster.stop < frames and not cluster.held[1]
        assert np.abs(found[free] - expected).max() < (1e-9 if not any(reach) else 1e-8)
        total += found
    assert np.abs(total[firm]).max() == 0.0


@given(firm_cases())
def test_paths_beside_a_firm_frame_stay_where_they_are(case):
    frames, firm, seams, seed = case
    rng = np.random.default_rng(seed)
    for cluster in clusters(seams, frames, [firm]):
        found = displacement_correction(cluster, rng.normal(size=(3 * len(cluster.seams), 2)))
        at = firm - cluster.start
        held = slice(at, None) if cluster.seams[0].frame <= firm else slice(None, at + 1)
        if 0 <= at < cluster.frames:
            assert np.abs(found[held] - found[held][:1]).max() < 1e-12
        assert np.abs(found[-1] - found[0]).max() < 1e-9


def test_clusters_without_firm_frames_are_as_ever():
    seams = [SeamPlace(0, 40, 10.0), SeamPlace(1, 400, 10.0)]
    assert clusters(seams, 500, []) == clusters(seams, 500)
    assert all(cluster.held == (0, 0) for cluster in clusters(seams, 500))


def test_one_seam_alone_knows_of_the_return():
    line = come_back(LINE, 0.8)
    with pytest.warns(KinestitchWarning, match="way back"):
        solved = solve_timeline(line, CLIPS)
    window = solve_seam(solved.placed, 1)
    assert window.stop == line.pins[0].frame + 3
    assert_motion_close(
        replace(solved.unpinned, rotations=window.rotations, translations=window.translations),
        replace(
            solved.unpinned,
            rotations=solved.unpinned.rotations[window.start : window.stop],
            translations=solved.unpinned.translations[window.start : window.stop],
        ),
        metres=1e-9,
    )


def test_the_oracle_of_this_file_solves_what_the_others_solve():
    rng = np.random.default_rng(0)
    target, delta = rng.normal(size=(2, 20, 1))
    L, rows = laplacian(20), np.full(20, 3.0)
    rows[[0, -1]] = 0.0
    direct = np.linalg.solve(np.eye(20) + L.T @ (rows[:, None] * L), target + L.T @ (rows[:, None] * delta))
    assert np.allclose(direct, dense(target, delta, rows))
