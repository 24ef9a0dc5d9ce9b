"""Where in its steps a body is, told by contacts that are known, by the samples, and by real walks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinestitch as ks
from kinestitch.core.motion import Motion
from kinestitch.edit.speed import set_speed
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.samples import run, walk
from kinestitch.search.align import phase_gaps
from kinestitch.search.phase import LONGEST_STEP, SHORTEST_STEP, find_steps, step_phase, strikes
from kinestitch.solve.contacts import Contacts, legs_of
from kinestitch.testing import random_motion

FPS = 60.0


@pytest.fixture(scope="module")
def body() -> Motion:
    return ks.sample("idle")


def standing(body: Motion, left: list[tuple[int, int]], right: list[tuple[int, int]]) -> Contacts:
    """Contacts in which the feet stand in these frames."""
    joints = tuple(j for leg in legs_of(body.skeleton) for j in (leg.foot, leg.toe) if j is not None)
    held = np.zeros((body.frames, len(joints)), dtype=bool)
    for column, stretches in ((0, left), (len(joints) // 2, right)):
        for start, stop in stretches:
            held[start:stop, column] = True
    return Contacts(joints, held)


@given(st.integers(1, 10), st.lists(st.integers(13, 50), min_size=1, max_size=4), st.integers(0, 1))
def test_phase_of_known_steps(body, first, lengths, side):
    """0 at the left foot's strikes, π at the right one's, straight lines in between, no more than a step beyond."""
    frames = np.cumsum([first, *lengths])
    sides: list[list[tuple[int, int]]] = [[], []]
    for count, frame in enumerate(frames):
        sides[(count + side) % 2].append((frame, frame + 10))
    phase = step_phase(body, standing(body, *sides))
    expected = np.pi * (side + np.arange(len(frames)))
    assert np.allclose(phase[frames], expected)
    here = np.arange(frames[0], frames[-1] + 1)
    assert np.allclose(phase[here], np.interp(here, frames, expected))
    begin, end = frames[0] - lengths[0], frames[-1] + lengths[-1]
    known = np.isfinite(phase)
    assert np.array_equal(known, (np.arange(body.frames) >= begin) & (np.arange(body.frames) <= end))
    rates = np.diff(phase[known])
    assert (rates > 0).all()
    assert rates[-1] == pytest.approx(np.pi / lengths[-1])


def test_what_makes_no_steps(body):
    for left, right in (
        ([(0, 121)], [(0, 121)]),  # standing
        ([(20, 40), (80, 100)], []),  # hopping
        ([(20, 40), (80, 100)], [(22, 40), (80, 100)]),  # jumping
        ([(5, 20)], [(5 + int(LONGEST_STEP * FPS) + 1, 100)]),  # a step that is none
    ):
        assert np.isnan(step_phase(body, standing(body, left, right))).all()


def test_a_landing_on_both_feet_ends_the_steps(body):
    soon = int(SHORTEST_STEP * FPS) - 1
    contacts = standing(body, [(5, 20), (65, 80)], [(30, 45), (65 + soon, 90)])
    phase = step_phase(body, contacts)
    assert np.allclose(phase[[5, 30, 55]], [0, np.pi, 2 * np.pi])
    assert np.isnan(phase[56:]).all()


def test_a_foot_that_barely_leaves_the_ground_has_made_no_step(body):
    assert strikes(body, standing(body, [(10, 20), (26, 40)], [(50, 70)])) == [(10, 0), (50, 1)]
    assert strikes(body, standing(body, [(0, 20), (60, 80)], [(40, 121)])) == [(40, 1), (60, 0)]


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("gait", [walk, run])
def test_cadence_and_sides_of_the_samples(gait, fps):
    name = gait.__name__.rpartition(".")[2]
    motion = ks.sample(name, fps=fps)
    phase = step_phase(motion)
    assert np.isfinite(phase).all()
    truth = 2 * np.pi * np.arange(motion.frames) / fps / gait.PERIOD  # the left foot touches down at 0
    late = truth - phase  # a heel that rolls is not yet still
    seconds = late / (2 * np.pi) * gait.PERIOD
    assert seconds.min() > -0.01
    assert seconds.max() < 0.1
    assert np.ptp(seconds) < 1.5 / fps


@pytest.mark.parametrize("name", ["idle", "jump", "jumping_jacks", "light_punch"])
def test_samples_that_make_no_steps(name):
    assert np.isnan(step_phase(ks.sample(name))).all()


def test_no_contact_at_all(body):
    with pytest.raises(ParameterError, match="a foot stands, got no contact in 241 frames of 'idle'"):
        step_phase(body, standing(body, [], []))
    with pytest.raises(SkeletonMismatchError, match="two feet"):
        step_phase(random_motion(0))
    with pytest.raises(ParameterError, match="241 frames"):
        step_phase(body, standing(ks.sample("walk"), [(3, 9)], []))


def test_a_retimed_clip_has_its_source_s_phases():
    clips = {"walk": ks.sample("walk", fps=30.0), "robot": random_motion(0)}
    line = set_speed(ks.timeline({"walk": clips["walk"]}, "walk"), 0, 0.5)
    steps = find_steps(line, clips)
    phase = step_phase(clips["walk"])
    assert np.allclose(steps.at(line.clips[1], np.arange(50) / 30.0), np.interp(np.arange(50) / 2, range(101), phase))
    assert np.allclose(steps.at(line.clips[0], [-1 / 30]), 2 * phase[0] - phase[1])
    assert np.isnan(steps.at(line.clips[0], [-2 / 30, 4.0])).all()


def test_at_the_ends_of_a_fast_clip_its_steps_go_on_for_a_frame_as_it_is_shown():
    clips = {"walk": ks.sample("walk"), "run": ks.sample("run")}
    phase = step_phase(clips["run"])
    line = set_speed(ks.append(ks.timeline(clips, "walk"), "run"), 1, 1.5)
    early = find_steps(line, clips).at(line.clips[2], [-1 / 60, -2 / 60], 1 / 60)
    assert early[0] == pytest.approx(phase[0] - 1.5 * (phase[1] - phase[0]))
    assert np.isnan(early[1])
    slow = ks.sample("walk", fps=30.0)
    line = ks.append(ks.timeline({"walk": slow, "run": clips["run"]}, "walk"), "run")
    assert np.isfinite(phase_gaps(line, find_steps(line, {"walk": slow, "run": clips["run"]}))).all()


def test_why_a_clip_has_no_steps():
    clips = {"robot": random_motion(0), "idle": ks.sample("idle")}
    steps = find_steps(ks.append(ks.timeline(clips, "robot"), "idle"), clips)
    assert steps.missing == {"robot": "has no feet that its joints' names tell"}
    assert np.isnan(steps.phases["idle"]).all()
    assert np.isnan(steps.at(ks.timeline(clips, "robot").clips[0], [0.1])).all()


WALKS = {
    "bandai/dataset-1_walk_normal_001.bvh": (0.5, 0.6),
    "bandai/dataset-1_walk-left_normal_001.bvh": (0.5, 0.65),
    "mixamo_xbot_60fps/Running.fbx": (0.28, 0.36),
    "mixamo_xbot_60fps/Walking (1).fbx": (0.45, 0.65),
    "cmu/02_01.bvh": (0.5, 0.6),
}
"""Clip: least and greatest mean time of a step in s."""


@pytest.mark.parametrize("place", WALKS)
def test_real_walks_step_throughout(real_clip, place):
    motion = real_clip(place)
    phase = step_phase(motion)
    known = np.isfinite(phase)
    assert known.mean() > 0.95
    steps = (phase[known][-1] - phase[known][0]) / np.pi
    low, high = WALKS[place]
    assert low < (known.sum() - 1) / motion.fps / steps < high
