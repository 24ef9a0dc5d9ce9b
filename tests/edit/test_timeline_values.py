"""The values a timeline is made of: what they accept, what they refuse, and in which words."""

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.motion import Motion
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline, timeline
from kinestitch.errors import MissingClipError, ParameterError, RangeError

WALK = ClipInfo("walk", 120, 30.0)
KICK = ClipInfo("kick", 101, 60.0)
LINE = Timeline(
    (WALK, KICK),
    (Segment("walk", FrameRange(0, 60)), Segment("kick", FrameRange(5, 25)), Segment("walk", FrameRange(80, 120))),
    (Seam(), Seam(stiffness=10.0)),
    30.0,
)


def test_range_is_half_open():
    assert len(FrameRange(60, 110)) == 50
    assert FrameRange(np.int64(3), np.int32(5)) == FrameRange(3, 5)
    assert hash(FrameRange(np.int64(3), 5)) == hash(FrameRange(3, 5))
    assert type(FrameRange(np.int64(3), 5).start) is int


@pytest.mark.parametrize(("start", "stop"), [(5, 5), (6, 5), (-1, 4), (0, 2**60)])
def test_range_refuses_empty_backward_negative(start, stop):
    with pytest.raises(RangeError, match=f"got {start}:{stop}"):
        FrameRange(start, stop)


@pytest.mark.parametrize("start", [1.5, None, "1", 1.0])
def test_range_refuses_what_is_no_whole_number(start):
    with pytest.raises(ParameterError, match="whole number"):
        FrameRange(start, 9)


@pytest.mark.parametrize("fps", [0.0, -30.0, float("nan"), float("inf"), "fast", None])
def test_rates_must_be_positive(fps):
    with pytest.raises(ParameterError, match="fps > 0"):
        ClipInfo("walk", 10, fps)
    with pytest.raises(ParameterError, match="fps > 0"):
        replace(LINE, fps=fps)


def test_clip_needs_a_frame_and_a_key():
    with pytest.raises(RangeError, match="at least 1 frame, got 0"):
        ClipInfo("walk", 0, 30.0)
    with pytest.raises(ParameterError, match="key"):
        ClipInfo(3, 10, 30.0)


def test_clip_frames_at_other_rates():
    assert KICK.frames_at(30.0) == 51
    assert KICK.frames_at(60.0) == KICK.frames_at(60.02) == 101
    assert WALK.frames_at(60.0) == 239
    with pytest.raises(RangeError, match="resampled"):
        ClipInfo("slow", 10**9, 1e-300).frames_at(30.0)


def test_seam_lambda():
    assert Seam().lambda_at(30.0) == pytest.approx(81.0, rel=1e-15)
    assert Seam().lambda_at(60.0) == pytest.approx(1296.0, rel=1e-15)
    assert Seam(smoothing=0.2).lambda_at(30.0) == pytest.approx(1296.0, rel=1e-15)
    assert Seam(stiffness=7).lambda_at(30.0) == Seam(stiffness=7).lambda_at(60.0) == 7.0
    assert Seam(smoothing=0.0).lambda_at(30.0) == Seam(stiffness=0).lambda_at(30.0) == 0.0


@pytest.mark.parametrize("value", [-1e-9, -1.0, float("nan"), float("inf"), "x"])
@pytest.mark.parametrize("name", ["stiffness", "smoothing"])
def test_seam_refuses(name, value):
    with pytest.raises(ParameterError, match=f"{name} ≥ 0"):
        Seam(**{name: value})


def test_an_automatic_seam_has_no_settings_of_its_own():
    assert Seam(automatic=True).lambda_at(30.0) == Seam().lambda_at(30.0)
    assert Seam(automatic=True) != Seam()
    for told in ({"stiffness": 0.0}, {"smoothing": 0.1}):
        with pytest.raises(ParameterError, match="automatic seam without"):
            Seam(automatic=True, **told)
    with pytest.raises(ParameterError, match="True or False, got 'yes'"):
        Seam(automatic="yes")


def test_seam_refuses_both_and_the_endless():
    with pytest.raises(ParameterError, match="both"):
        Seam(stiffness=1.0, smoothing=0.1)
    with pytest.raises(ParameterError, match="smoothing time"):
        Seam(smoothing=1e200).lambda_at(30.0)


def test_timeline_counts():
    assert LINE.frames == 120
    assert LINE.starts == (0, 60, 80, 120)
    assert [LINE.segment_at(frame) for frame in (0, 59, 60, 79, 80, 119)] == [
        (0, 0), (0, 59), (1, 5), (1, 24), (2, 80), (2, 119),
    ]  # fmt: skip
    assert LINE.clip("kick") is KICK
    for frame in (-1, 120):
        with pytest.raises(RangeError, match=f"0:120 of the timeline, got {frame}"):
            LINE.segment_at(frame)


def test_timeline_is_a_value():
    again = Timeline(list(LINE.clips), list(LINE.segments), list(LINE.seams), 30)
    assert again == LINE
    assert hash(again) == hash(LINE)
    assert replace(LINE, seams=(Seam(), Seam())) != LINE


def test_timeline_refuses():
    with pytest.raises(RangeError, match="at least one segment"):
        Timeline((WALK,), (), (), 30.0)
    with pytest.raises(ParameterError, match="got 1 seams and 3 segments"):
        replace(LINE, seams=(Seam(),))
    with pytest.raises(ParameterError, match="'walk' twice"):
        replace(LINE, clips=(WALK, WALK))
    with pytest.raises(MissingClipError, match=r"'walk', 'kick'.*got 'jump'"):
        replace(LINE, segments=(Segment("jump", FrameRange(0, 3)),), seams=())
    with pytest.raises(RangeError, match="0:51 of clip 'kick' at 30 fps, got 5:52"):
        replace(LINE, segments=(Segment("kick", FrameRange(5, 52)),), seams=())
    with pytest.raises(MissingClipError, match="got 'jump'"):
        LINE.clip("jump")


def test_constructor_from_motions_and_from_infos():
    skeleton = Skeleton(("Hips",), (-1,), np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]))
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (7, 1, 1))
    motion = Motion(skeleton, np.zeros((7, 1, 3)), rotations, 24.0)
    line = timeline({"a": motion, "b": motion}, "b")
    assert line == timeline([ClipInfo("a", 7, 24.0), ClipInfo("b", 7, 24.0)], "b")
    assert line.segments == (Segment("b", FrameRange(0, 7)),)
    assert line.fps == 24.0
    with pytest.raises(MissingClipError, match="got 'c'"):
        timeline({"a": motion}, "c")
    with pytest.raises(MissingClipError, match="no clips"):
        timeline([], "c")
