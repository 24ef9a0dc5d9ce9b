"""Retimed clips as values, segments at another speed, and what documents keep of them."""

from __future__ import annotations

import json
import math

import opentimelineio as otio
import pytest
from edit_strategies import timelines
from hypothesis import assume, given
from hypothesis import strategies as st

from kinestitch.edit.document import load_document, save_document
from kinestitch.edit.operations import append, replace, split
from kinestitch.edit.pinning import add_pin
from kinestitch.edit.pins import Pin
from kinestitch.edit.retiming import Retiming
from kinestitch.edit.speed import set_speed, source_frame
from kinestitch.edit.timeline import ClipInfo, FrameRange, Segment, Timeline, timeline
from kinestitch.errors import DocumentError, KinestitchError, MissingClipError, ParameterError, RangeError

WALK, KICK = ClipInfo("walk", 121, 30.0), ClipInfo("kick", 101, 60.0)
LINE = replace(timeline([WALK, KICK], "walk"), 40, 60, "kick", 20, 80)
SPEEDS = st.floats(0.1, 10.0)


@given(timelines(), st.floats(0.1, 0.99), st.data())
def test_slowed_down_and_set_back_is_the_same_line(line, speed, data):
    index = data.draw(st.integers(0, len(line.segments) - 1))
    info = line.clip(line.segments[index].clip)
    assume(info.retiming is None and info.frames > 1)
    slow = set_speed(line, index, speed)
    assert slow.segments[index].clip != info.key
    back = set_speed(slow, index, 1.0)
    old, new = line.segments[index].range, back.segments[index].range
    short = math.ceil(line.fps / info.fps) + 1  # the slow clip may end that many frames before its source does
    if old.stop < info.frames_at(line.fps) - short:
        assert back == line
    else:
        assert abs(new.start - old.start) <= short
        assert abs(new.stop - old.stop) <= short


@given(timelines(), SPEEDS, st.data())
def test_the_same_stretch_at_another_length(line, speed, data):
    index = data.draw(st.integers(0, len(line.segments) - 1))
    old = line.segments[index]
    source = line.clip(line.clip(old.clip).source)
    assume(source.frames > 1)
    new = set_speed(line, index, speed)
    assert new.seams == line.seams
    assert [s for i, s in enumerate(new.segments) if i != index] == [
        s for i, s in enumerate(line.segments) if i != index
    ]
    shown = new.segments[index]
    last = new.clip(shown.clip).frames_at(new.fps)
    for there, here in ((old.range.start, shown.range.start), (old.range.stop, shown.range.stop)):
        away = abs(source_frame(new, shown.clip, here) - source_frame(line, old.clip, there))
        assert away <= speed * 0.5 + 1e-6 or here in (last, last - 1) or len(shown) == 1
    assert new.frames - line.frames == len(shown) - len(old)


@given(SPEEDS, SPEEDS)
def test_a_speed_counts_against_the_clip_itself(first, second):
    twice, once = set_speed(set_speed(LINE, 0, first), 0, second), set_speed(LINE, 0, second)
    assert [clip.retiming for clip in twice.clips] == [clip.retiming for clip in once.clips]


def test_lengths():
    for speed, frames in ((0.5, 60), (2.0, 15), (3.0, 10), (0.1, 300)):
        line = set_speed(LINE, 1, speed)
        assert len(line.segments[1]) == frames
        assert line.frames == LINE.frames - 30 + frames
    info = set_speed(LINE, 1, 0.5).clips[-1]
    assert (info.key, info.fps, info.frames, info.source) == ("kick ×0.5", 60.0, 201, "kick")
    assert info.retiming == Retiming("kick", ((0.0, 0.0), (100 / 30, 100 / 60)))


def test_pieces_of_one_clip_at_one_speed_share_it_and_stay_adjacent():
    line = split(timeline([WALK], "walk"), 47)
    for index in (0, 1):
        line = set_speed(line, index, 0.7)
    assert [clip.key for clip in line.clips] == ["walk", "walk ×0.7"]
    assert line.segments[0].range.stop == line.segments[1].range.start
    assert [clip.key for clip in set_speed(line, 0, 1.0).clips] == ["walk", "walk ×0.7"]
    assert [clip.key for clip in set_speed(set_speed(line, 0, 1.0), 1, 1.0).clips] == ["walk"]


def test_pins_stay_on_what_they_are_on():
    pins = [Pin("waypoint", frame, (0.0, 1.0)) for frame in (39, 40, 41, 42, 69, 70)]
    line = LINE
    for pin in pins:
        line = add_pin(line, pin)
    slow = set_speed(line, 1, 0.5)
    assert [pin.frame for pin in slow.pins] == [39, 40, 42, 44, 98, 100]
    assert set_speed(slow, 1, 1.0) == line
    fast = set_speed(line, 1, 2.0)
    assert [pin.frame for pin in fast.pins] == [39, 40, 41, 54, 55]  # two of them would fall on one frame


def test_edits_work_on_a_retimed_clip_as_on_any():
    line = set_speed(LINE, 1, 0.5)
    longer = append(line, "kick ×0.5", 10, 50)
    assert str(longer.segments[-1]) == "kick ×0.5@5:25"
    assert replace(line, 45, 50, "kick").segments[3].clip == "kick ×0.5"


def test_another_clip_may_have_the_name():
    line = timeline([WALK, ClipInfo("walk ×2", 5, 30.0)], "walk")
    assert set_speed(line, 0, 2.0).segments[0].clip == "walk ×2 2"


def test_the_body_is_the_original_s_even_where_it_is_retimed():
    line = append(timeline([WALK, KICK], "kick"), "walk")
    assert line.original == "kick"
    assert set_speed(line, 0, 0.5).original == "kick"
    turned = Timeline((WALK, *set_speed(line, 1, 2.0).clips[::2]), line.segments[:1], (), 60.0)
    assert turned.original == "kick"


@given(timelines())
def test_retimed_clips_say_what_they_are(line):
    for clip in line.clips:
        assert line.clip(clip.source).retiming is None
        if clip.retiming is not None:
            assert clip.frames == math.floor(clip.retiming.knots[-1][0] * clip.fps + 1e-6) + 1
            assert 0 < clip.retiming.speeds[0] <= clip.retiming.speeds[1]


@pytest.mark.parametrize(
    ("knots", "said"),
    [
        ((), "two knots"),
        (((0, 0),), "two knots"),
        (((1, 0), (2, 1)), "first at time 0"),
        (((0, -1), (2, 1)), "within clip"),
        (((0, 0), (1, 1), (1, 2)), "both rise"),
        (((0, 0), (1, 1), (2, 1)), "both rise"),
        (((0, 0), (1, 1e4)), "0.001 to 1000"),
        (((0, 0), (1, math.nan)), "times up to"),
        (((0, 0), (1e10, 1e10)), "times up to"),
        (((0, 0), (1, 2, 3)), "pair of times"),
        (((0, 0), None), "pair of times"),
        (3, "knots"),
    ],
)
def test_no_retiming(knots, said):
    with pytest.raises(ParameterError, match=said):
        Retiming("walk", knots)


def test_no_clip_of_a_key_that_is_none():
    with pytest.raises(ParameterError, match="source to be text"):
        Retiming(3, ((0, 0), (1, 1)))


def retimed(source: ClipInfo, end: float, **other) -> ClipInfo:
    found = Retiming(source.key, ((0.0, 0.0), (1.0, end)))
    return ClipInfo(
        **{"key": "new", "frames": found.frames_at(source.fps), "fps": source.fps, "retiming": found} | other
    )


def test_a_timeline_refuses_what_does_not_fit_together():
    shown = (Segment("walk", FrameRange(0, 5)),)
    good = retimed(WALK, 2.0)
    assert Timeline((good, WALK), shown, (), 30.0).clip("new").source == "walk"
    with pytest.raises(MissingClipError, match="'walk'"):
        Timeline((good,), (Segment("new", FrameRange(0, 5)),), (), 30.0)
    with pytest.raises(ParameterError, match="itself retimed"):
        Timeline((WALK, good, retimed(good, 0.5, key="newer")), shown, (), 30.0)
    with pytest.raises(RangeError, match="within 0 to 4 s"):
        Timeline((WALK, retimed(WALK, 4.1)), shown, (), 30.0)
    with pytest.raises(ParameterError, match="rate of 'walk'"):
        Timeline((WALK, retimed(WALK, 1.0, fps=60.0, frames=61)), shown, (), 30.0)
    with pytest.raises(RangeError, match="31 frames in the retimed clip"):
        retimed(WALK, 2.0, frames=30)


def test_refusals():
    for speed in (0.0, -1.0, 0.09, 11.0, math.nan, math.inf, "fast", None):
        with pytest.raises(ParameterError, match=r"speed from 0\.1 to 10"):
            set_speed(LINE, 0, speed)
    for index in (-1, 3):
        with pytest.raises(RangeError, match="3 segments"):
            set_speed(LINE, index, 2.0)
    with pytest.raises(RangeError, match="at least 2 frames"):
        set_speed(timeline([ClipInfo("pose", 1, 30.0)], "pose"), 0, 2.0)


def test_a_document_keeps_speeds_and_names_the_sources_file(tmp_path):
    line, path = set_speed(LINE, 1, 1 / 3), tmp_path / "edit.otio"
    save_document(line, path, sources={"kick": tmp_path / "kick.bvh"})
    found = load_document(path)
    assert found.timeline == line
    assert found.sources == {"kick": str(tmp_path / "kick.bvh")}
    (track,) = otio.adapters.read_from_file(str(path)).video_tracks()
    assert track[1].media_reference.target_url == "kick.bvh"
    with pytest.raises(ParameterError, match="source for the retimed clip"):
        save_document(line, path, sources={line.segments[1].clip: "kick.bvh"})


def test_relinking_a_retimed_clip_relinks_its_source(tmp_path):
    line, path = set_speed(LINE, 1, 0.5), tmp_path / "edit.otio"
    save_document(line, path, sources={"kick": tmp_path / "kick.bvh"})
    told = otio.adapters.read_from_file(str(path))
    told.video_tracks()[0][1].media_reference = otio.schema.ExternalReference("better.bvh")
    otio.adapters.write_to_file(told, str(path))
    assert load_document(path).sources == {"kick": str(tmp_path / "better.bvh")}


@pytest.mark.parametrize(
    "change",
    [
        lambda retiming: retiming.update(knots=[[0, 0]]),
        lambda retiming: retiming.update(knots=[[0, 0], [1, 2, 3]]),
        lambda retiming: retiming.update(knots=[[0, 0], [1, "x"]]),
        lambda retiming: retiming.update(knots={}),
        lambda retiming: retiming.update(clip="jump"),
        lambda retiming: retiming.update(clip="kick ×0.5"),
        lambda retiming: retiming.pop("clip"),
    ],
)
def test_damaged_documents(tmp_path, change):
    path = tmp_path / "edit.otio"
    save_document(set_speed(LINE, 1, 0.5), path)
    data = json.loads(path.read_text())
    change(data["metadata"]["kinestitch"]["clips"][-1]["retiming"])
    path.write_text(json.dumps(data))
    with pytest.raises(DocumentError, match="Expected") as caught:
        load_document(path)
    assert isinstance(caught.value, KinestitchError)
