"""Seams that move to where the steps meet."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kinestitch as ks
from kinestitch.edit.speed import set_speed
from kinestitch.edit.timeline import Seam
from kinestitch.errors import ParameterError
from kinestitch.search.align import TOLERANCE, align_phase, phase_gaps, place_phases, wrapped
from kinestitch.search.features import column_scales
from kinestitch.search.phase import find_steps, step_phase, strikes
from kinestitch.search.price import check_weights
from kinestitch.search.snap import feet_of, snap, within_reach
from kinestitch.solve.placed import place_timeline

CLIPS = {name: ks.sample(name, fps=30.0) for name in ("walk", "run", "idle", "kick")}


def walk_then_run(out: int, into: int, **seam) -> ks.Timeline:
    line = ks.timeline(CLIPS, "walk")
    line = ks.delete(line, out, line.frames) if out < line.frames else line
    return ks.append(line, "run", into, **seam)


def brute_force(line: ks.Timeline, seconds: float, tolerance: float) -> tuple[int, int]:
    """Every pair, one by one: the cheapest of those whose phases meet, or the pair whose phases come nearest."""
    placed = place_timeline(line, CLIPS)
    scales = column_scales(placed.skeleton, check_weights(placed.skeleton, None))
    found = within_reach(placed, placed.seams[0], round(seconds * line.fps), scales, feet_of(placed))
    phases = [step_phase(CLIPS[segment.clip]) for segment in line.segments]

    def at(phase: np.ndarray, place: int) -> float:
        before = phase[place - 1] if place > 0 else 2 * phase[0] - phase[1]
        after = phase[place] if place < len(phase) else 2 * phase[-1] - phase[-2]
        return (before + after) / 2

    rows = []
    for i in range(found.outs[0], found.outs[1] + 1):
        for j in range(found.intos[0], found.intos[1] + 1):
            apart = abs((at(phases[1], j) - at(phases[0], i) + np.pi) % (2 * np.pi) - np.pi)
            rows.append((apart, found.costs[i - found.outs[0], j - found.intos[0]], i, j))
    bound = max(tolerance, min(rows)[0])
    _, _, i, j = min((row for row in rows if row[0] <= bound), key=lambda row: row[1])
    return i - line.segments[0].range.stop, j - line.segments[1].range.start


@settings(max_examples=25)
@given(st.integers(10, 101), st.integers(0, 70), st.sampled_from([0.0, 0.05, 0.1, 0.3]), st.sampled_from([0.02, 0.17]))
def test_finds_what_looking_at_every_pair_finds(out, into, seconds, tolerance):
    line = walk_then_run(out, into)
    found = align_phase(line, CLIPS, seconds, tolerance=tolerance)
    assert found.moves == (brute_force(line, seconds, tolerance),)
    assert abs(found.gaps_after[0]) <= max(tolerance, abs(found.gaps_before[0])) + 1e-12


@settings(max_examples=25)
@given(st.integers(20, 80), st.integers(15, 60))
def test_within_a_third_of_a_second_the_steps_always_meet(out, into):
    found = align_phase(walk_then_run(out, into), CLIPS, 0.3)
    assert abs(found.gaps_after[0]) <= TOLERANCE
    assert found.timeline.segments[0].range.stop == out + found.moves[0][0]
    assert found.timeline.segments[1].range.start == into + found.moves[0][1]


def test_the_cheapest_pair_of_all_may_be_one_whose_steps_do_not_meet():
    line = walk_then_run(55, 25)
    aligned, snapped = align_phase(line, CLIPS, 0.3), snap(line, CLIPS, 0.3, contacts=False)
    assert max(snapped.after, aligned.after) < aligned.before
    assert abs(phase_gaps(snapped.timeline, find_steps(line, CLIPS))[0]) > 2 * TOLERANCE
    # Stances of the same foot are steps that meet.
    standing = snap(line, CLIPS, 0.3)
    assert abs(phase_gaps(standing.timeline, find_steps(line, CLIPS))[0]) < TOLERANCE


@pytest.mark.parametrize("contacts", [True, False])
def test_the_sum_of_the_seams_is_what_the_search_saw(contacts):
    line = ks.replace(walk_then_run(70, 20), 20, 40, "kick", 10, 60)
    found = align_phase(line, CLIPS, 0.3, snap=0.2, contacts=contacts)
    assert found.after == pytest.approx(found.separable, rel=0.1)
    stays = align_phase(line, CLIPS, 0.0)
    assert stays.separable == pytest.approx(stays.before, rel=0.1)


def test_seams_without_steps_snap_or_stay():
    line = ks.replace(walk_then_run(55, 20), 20, 30, "kick", 10, 40)
    stays = align_phase(line, CLIPS, 0.3)
    assert stays.moves[:2] == ((0, 0), (0, 0))
    assert np.isnan(stays.gaps_before[:2]).all()
    assert np.isnan(stays.gaps_after[:2]).all()
    both = align_phase(line, CLIPS, 0.3, snap=0.2)
    assert both.moves[:2] == snap(line, CLIPS, 0.2).moves[:2] != ((0, 0), (0, 0))
    assert both.moves[2] == stays.moves[2]
    assert align_phase(line, CLIPS, 0.0, snap=0.3).moves[2] == align_phase(line, CLIPS, 0.3).moves[2]


def test_what_stays():
    line = walk_then_run(55, 20, seam=Seam(stiffness=0.0))
    assert align_phase(line, CLIPS, 0.3).timeline == line
    still = ks.append(ks.timeline(CLIPS, "walk"), "idle")
    assert align_phase(still, CLIPS, 0.3).timeline == still
    whole = ks.timeline(CLIPS, "walk")
    assert align_phase(whole, CLIPS, 0.3).timeline == whole


def test_retimed_clips_step_too():
    line = set_speed(walk_then_run(60, 25), 1, 0.6)
    found = align_phase(line, CLIPS, 0.3)
    assert abs(found.gaps_after[0]) <= TOLERANCE
    steps = find_steps(line, CLIPS)
    left, right = found.timeline.segments
    places = [
        place_phases(found.timeline, s.clip, (at, at), steps)[0]
        for s, at in ((left, left.range.stop), (right, right.range.start))
    ]
    assert wrapped(places[1] - places[0]) == pytest.approx(found.gaps_after[0])


def test_the_legs_alternate_through_the_seam():
    """Cut in the middle of a step the walk's left foot would strike twice; aligned, foot follows foot."""
    line = align_phase(walk_then_run(55, 20), CLIPS, 0.3).timeline
    found = strikes(ks.solve_timeline(line, CLIPS, foot_lock=True).motion)
    seam = line.starts[1]
    assert any(frame < seam for frame, _ in found)
    assert any(frame > seam for frame, _ in found)
    sides = [side for _, side in found]
    assert all(a != b for a, b in pairwise(sides))
    intervals = np.diff([frame for frame, _ in found]) / 30.0
    assert intervals.max() < 0.6  # the walk's own
    assert intervals.min() > 0.3  # the run's own


def test_refusals():
    line = walk_then_run(55, 20)
    for wrong in ({"seconds": -1.0}, {"seconds": np.nan}, {"seconds": 0.1, "snap": -1.0}):
        with pytest.raises(ParameterError, match="reach in seconds"):
            align_phase(line, CLIPS, **wrong)
    with pytest.raises(ParameterError, match="tolerance"):
        align_phase(line, CLIPS, 0.1, tolerance=-1.0)
