"""Time bent near seams until the steps meet."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kinestitch as ks
from kinestitch.core.retime import time_map
from kinestitch.edit.document import load_document, save_document
from kinestitch.edit.speed import set_speed
from kinestitch.edit.timeline import Seam, Timeline
from kinestitch.errors import ParameterError
from kinestitch.search.align import phase_gaps
from kinestitch.search.phase import find_steps
from kinestitch.search.warp import warp_steps
from kinestitch.solve.placed import place_timeline

CLIPS = {name: ks.sample(name, fps=30.0) for name in ("walk", "run", "idle")}


def walk_then_run(out: int, into: int, **seam) -> Timeline:
    line = ks.timeline(CLIPS, "walk")
    line = ks.delete(line, out, line.frames) if out < line.frames else line
    return ks.append(line, "run", into, **seam)


def shown_times(line: Timeline, index: int) -> np.ndarray:
    """Which moment of its source each frame of a segment shows, in s."""
    segment = line.segments[index]
    times = np.arange(segment.range.start, segment.range.stop) / line.fps
    retiming = line.clip(segment.clip).retiming
    return times if retiming is None else time_map(retiming.knots, times)


CUTS = st.tuples(st.integers(8, 101), st.integers(0, 70))


@settings(max_examples=30)
@given(CUTS, st.sampled_from([0.05, 0.2, 0.5]), st.sampled_from([0.2, 0.5, 1.0]))
def test_keeps_every_frame_and_the_bound(cut, bound, seconds):
    line = walk_then_run(*cut)
    found = warp_steps(line, CLIPS, bound, seconds=seconds)
    assert [s.range for s in found.timeline.segments] == [s.range for s in line.segments]
    assert found.timeline.seams == line.seams
    for index, before, speed in zip((0, 1), (line, line), found.speeds[0], strict=True):
        times, old = shown_times(found.timeline, index), shown_times(before, index)
        speeds = np.diff(times) * line.fps
        assert (abs(speeds - 1) <= bound + 1e-9).all()
        assert abs(speed - 1) <= bound + 1e-12
        into = 1 if index == 0 else -1
        assert (np.diff(abs(speeds - 1)) * into >= -1e-9).all()  # ever more towards the seam
        away = abs(np.arange(len(times)) - (len(times) - 1 if index == 0 else 0)) / line.fps
        assert np.abs(times - old)[away >= seconds + 1 / line.fps].max(initial=0.0) < 1e-12


@settings(max_examples=30)
@given(CUTS, st.sampled_from([0.1, 0.3]))
def test_the_phases_meet_or_come_as_near_as_they_can(cut, bound):
    line = walk_then_run(*cut)
    found = warp_steps(line, CLIPS, bound)
    before, after = found.gaps_before[0], found.gaps_after[0]
    assert before == phase_gaps(line, find_steps(line, CLIPS))[0]
    assert abs(after) <= abs(before) + 1e-9
    away = abs(np.array(found.speeds[0]) - 1)
    if abs(after) > 1e-4:
        ends = (line.segments[0].range.stop > 89, line.segments[1].range.start < 12)
        assert all(share == pytest.approx(bound) or end for share, end in zip(away, ends, strict=True))
        assert max(away) == pytest.approx(bound) or all(ends)
    if abs(before) < np.radians(20) and 20 < cut[0] < 90 and cut[1] > 10:
        assert abs(after) < 1e-9


def test_speeds_tell_the_direction():
    early, late = walk_then_run(45, 25), walk_then_run(45, 29)
    for line in (early, late):
        found = warp_steps(line, CLIPS)
        ahead = found.gaps_before[0] > 0  # the run is ahead: the walk has to hurry
        assert all((speed > 1) == ahead for speed in found.speeds[0])
        assert found.speeds[0][0] == pytest.approx(found.speeds[0][1])
    assert warp_steps(early, CLIPS).gaps_before[0] < 0 < warp_steps(late, CLIPS).gaps_before[0]


def test_speed_changes_without_jumps():
    found = warp_steps(walk_then_run(45, 27), CLIPS, seconds=1.0)
    for index in (0, 1):
        assert abs(np.diff(shown_times(found.timeline, index), n=2) * 30).max() < 0.2 * np.pi / 2 / 30 * 1.1


def test_both_ends_of_a_segment():
    line = ks.replace(ks.timeline(CLIPS, "walk"), 40, 60, "run", 20, 50)
    found = warp_steps(line, CLIPS, 0.3)
    assert [s.clip for s in found.timeline.segments] == ["walk warped", "run warped", "walk warped 2"]
    assert found.timeline.starts == line.starts
    assert all(abs(a) <= abs(b) for a, b in zip(found.gaps_after, found.gaps_before, strict=True))
    middle = shown_times(found.timeline, 1)
    assert middle[15] == pytest.approx(shown_times(line, 1)[15], abs=1e-5)


def test_on_top_of_another_speed():
    line = set_speed(walk_then_run(45, 27), 1, 0.8)
    found = warp_steps(line, CLIPS)
    assert found.timeline.starts == line.starts
    speeds = np.diff(shown_times(found.timeline, 1)) * 30
    assert abs(speeds / 0.8 - 1).max() <= 0.2 + 1e-9
    assert abs(found.gaps_after[0]) < abs(found.gaps_before[0])
    again = warp_steps(found.timeline, CLIPS)
    assert abs(again.gaps_after[0]) < 1e-6


def test_a_clip_of_another_rate():
    clips = CLIPS | {"run": ks.sample("run", fps=120.0)}
    line = ks.append(ks.delete(ks.timeline(clips, "walk"), 45, 101), "run", 108)
    found = warp_steps(line, clips)
    assert found.timeline.starts == line.starts
    assert found.gaps_after[0] == pytest.approx(0.0, abs=1e-6)
    assert found.gaps_before[0] == pytest.approx(warp_steps(walk_then_run(45, 27), CLIPS).gaps_before[0], abs=0.2)


def test_the_solved_motion_is_the_clips_own_away_from_the_seam():
    line = walk_then_run(80, 9, seam=Seam(stiffness=1.0))
    found = warp_steps(line, CLIPS, seconds=0.3)
    before, after = ks.stitch(line, CLIPS), ks.stitch(found.timeline, CLIPS)
    assert np.array_equal(after.rotations[:32], before.rotations[:32])
    assert not np.array_equal(after.rotations[79], before.rotations[79])
    assert place_timeline(found.timeline, CLIPS).sources["walk warped"].frames == CLIPS["walk"].frames
    legs = [j for j, name in enumerate(after.skeleton.names) if "Leg" in name]
    assert np.array_equal(after.rotations[128:, legs], before.rotations[128:, legs])


def test_a_document_keeps_it(tmp_path):
    line = warp_steps(walk_then_run(45, 27), CLIPS).timeline
    save_document(line, tmp_path / "edit.otio")
    assert load_document(tmp_path / "edit.otio").timeline == line


def test_what_stays():
    for line in (
        walk_then_run(45, 27, seam=Seam(stiffness=0.0)),
        ks.append(ks.timeline(CLIPS, "walk"), "idle"),
        ks.timeline(CLIPS, "walk"),
    ):
        found = warp_steps(line, CLIPS)
        assert found.timeline == line
        assert all(speeds == (1.0, 1.0) for speeds in found.speeds)


@pytest.mark.parametrize("bound", [0.0, -0.1, 0.6, np.nan])
def test_refused_bounds(bound):
    with pytest.raises(ParameterError, match=r"above 0 and up to 0\.5"):
        warp_steps(walk_then_run(45, 27), CLIPS, bound)


@pytest.mark.parametrize("seconds", [0.0, -1.0, np.inf])
def test_refused_times(seconds):
    with pytest.raises(ParameterError, match="above 0 s"):
        warp_steps(walk_then_run(45, 27), CLIPS, seconds=seconds)
