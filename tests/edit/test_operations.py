"""The edits, against the same edit on a plain list of frame labels."""

import pytest
from edit_strategies import labels, seams, spans, timelines
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.core.resample import resampled_bound
from kinestitch.edit import operations as ops
from kinestitch.edit.timeline import DEFAULT_SEAM, ClipInfo, FrameRange, Seam, Segment, timeline
from kinestitch.errors import MissingClipError, ParameterError, RangeError

A, B = ClipInfo("A", 120, 30.0), ClipInfo("B", 101, 60.0)
LINE = timeline([A, B], "A")
TUNED = Seam(smoothing=0.3)


@st.composite
def sources(draw, line):
    """(clip, start or None, stop or None, the labels it brings) with at least one frame at the timeline's rate."""
    info = draw(st.sampled_from(line.clips))
    start = draw(st.none() | st.integers(0, info.frames - 1))
    stop = draw(st.none() | st.integers((start or 0) + 1, info.frames))
    first = resampled_bound(start or 0, info.frames, info.fps, line.fps)
    last = info.frames_at(line.fps)
    if stop is not None:
        last = resampled_bound(stop, info.frames, info.fps, line.fps)
    if first >= last:
        start = stop = None
        first, last = 0, info.frames_at(line.fps)
    return info.key, start, stop, [(info.key, frame) for frame in range(first, last)]


@given(timelines(), st.data())
def test_replace_is_slice_assignment(line, data):
    (start, stop), (clip, low, high, pasted) = data.draw(spans(line)), data.draw(sources(line))
    before = labels(line)
    result = ops.replace(line, start, stop, clip, low, high, seam=TUNED)
    assert labels(result) == before[:start] + pasted + before[stop:]
    assert labels(line) == before
    assert hash(result) == hash(ops.replace(line, start, stop, clip, low, high, seam=TUNED))


@given(timelines(), st.data())
def test_insert_and_append(line, data):
    at, (clip, low, high, pasted) = data.draw(st.integers(0, line.frames)), data.draw(sources(line))
    before = labels(line)
    inserted = ops.insert(line, at, clip, low, high)
    assert labels(inserted) == before[:at] + pasted + before[at:]
    assert labels(ops.delete(inserted, at, at + len(pasted))) == before
    assert labels(ops.append(line, clip, low, high)) == before + pasted


@given(timelines(), st.data())
def test_delete_and_trim(line, data):
    start, stop = data.draw(spans(line))
    before = labels(line)
    assert labels(ops.trim(line, start, stop)) == before[start:stop]
    if stop - start < line.frames:
        assert labels(ops.delete(line, start, stop)) == before[:start] + before[stop:]
    else:
        with pytest.raises(RangeError, match="at least one frame"):
            ops.delete(line, start, stop)


@given(timelines(), st.data())
def test_move_is_cut_and_paste(line, data):
    start, stop = data.draw(spans(line))
    to = data.draw(st.integers(0, start) | st.integers(stop, line.frames))
    before = labels(line)
    rest = before[:start] + before[stop:]
    at = to if to <= start else to - (stop - start)
    result = ops.move(line, start, stop, to)
    assert labels(result) == rest[:at] + before[start:stop] + rest[at:]
    if to in (start, stop):
        assert result == line


@given(timelines(), st.data())
def test_split_changes_no_frame_and_keeps_every_seam(line, data):
    if line.frames < 2:
        return
    at = data.draw(st.integers(1, line.frames - 1))
    result = ops.split(line, at)
    assert labels(result) == labels(line)
    assert at in result.starts
    kept = dict(zip(line.starts[1:-1], line.seams, strict=True))
    assert dict(zip(result.starts[1:-1], result.seams, strict=True)) == {at: DEFAULT_SEAM} | kept
    assert ops.split(result, at, seam=TUNED) is result


@given(timelines(), st.data())
def test_a_seam_stays_exactly_where_its_two_frames_still_meet(line, data):
    start, stop = data.draw(spans(line))
    clip, low, high, pasted = data.draw(sources(line))
    result = ops.replace(line, start, stop, clip, low, high, seam=Seam(stiffness=12345.0))
    shift = len(pasted) - (stop - start)
    expected = {m: s for m, s in zip(line.starts[1:-1], line.seams, strict=True) if m < start}
    expected |= {m + shift: s for m, s in zip(line.starts[1:-1], line.seams, strict=True) if m > stop}
    expected |= {m: Seam(stiffness=12345.0) for m in (start, start + len(pasted)) if 0 < m < result.frames}
    assert dict(zip(result.starts[1:-1], result.seams, strict=True)) == expected


@given(timelines(), seams(), st.data())
def test_set_seam(line, seam, data):
    if not line.seams:
        with pytest.raises(RangeError, match="0 seams"):
            ops.set_seam(line, 0, seam)
        return
    index = data.draw(st.integers(0, len(line.seams) - 1))
    result = ops.set_seam(line, index, seam)
    assert result.segments == line.segments
    assert [s for s in enumerate(result.seams) if s[0] != index] == [s for s in enumerate(line.seams) if s[0] != index]
    assert result.seams[index] == seam


def test_move_keeps_the_seams_it_carries():
    line = ops.set_seam(ops.split(LINE, 50), 0, TUNED)
    moved = ops.move(line, 40, 60, 0)
    assert moved.starts == (0, 10, 20, 60, 120)
    assert moved.seams == (TUNED, DEFAULT_SEAM, DEFAULT_SEAM)


def test_replacing_at_the_borders_and_everything():
    assert ops.replace(LINE, 0, 20, "B").segments[0].clip == "B"
    assert ops.replace(LINE, 100, 120, "B").segments[-1].clip == "B"
    assert ops.replace(LINE, 0, 120, "B").segments == (Segment("B", FrameRange(0, 51)),)
    assert ops.replace(LINE, 0, 120, "B").fps == 30.0


def test_cut_and_put_back_shows_the_same_frames():
    assert labels(ops.replace(LINE, 40, 70, "A", 40, 70)) == labels(LINE)


def test_own_frames_are_converted_to_the_timelines_rate():
    assert str(ops.insert(LINE, 60, "B", 20, 75).segments[1]) == "B@10:38"
    assert str(ops.append(LINE, "B", 20).segments[1]) == "B@10:51"
    assert str(ops.append(LINE, "B", None, 75).segments[1]) == "B@0:38"


def test_a_range_that_vanishes_at_the_timelines_rate_is_refused():
    line = timeline([A, ClipInfo("fast", 400, 120.0)], "A")
    with pytest.raises(RangeError, match=r"keeps a frame at 30 fps, got 12:13 of clip 'fast' at 120 fps"):
        ops.insert(line, 60, "fast", 12, 13)


@pytest.mark.parametrize(("start", "stop"), [(-1, 5), (5, 5), (6, 5), (100, 121), (120, 121)])
def test_ranges_outside_are_refused_with_numbers(start, stop):
    for edit in (
        lambda: ops.delete(LINE, start, stop),
        lambda: ops.replace(LINE, start, stop, "B"),
        lambda: ops.trim(LINE, start, stop),
        lambda: ops.move(LINE, start, stop, 0),
    ):
        with pytest.raises(RangeError, match=rf"within 0:120 of the timeline, got {start}:{stop}\."):
            edit()


def test_places_and_clips_outside_are_refused():
    for at in (-1, 121):
        with pytest.raises(RangeError, match=f"from 0 to 120 on the timeline, got {at}"):
            ops.insert(LINE, at, "B")
        with pytest.raises(RangeError, match=f"from 0 to 120 on the timeline, got {at}"):
            ops.move(LINE, 10, 20, at)
    for at in (0, 120):
        with pytest.raises(RangeError, match=f"from 1 to 119, got {at}"):
            ops.split(LINE, at)
    with pytest.raises(RangeError, match="outside the moved range 10:20, got 15"):
        ops.move(LINE, 10, 20, 15)
    for start, stop in ((0, 102), (50, 50), (-2, 5)):
        with pytest.raises(RangeError, match=f"within 0:101 of clip 'B', got {start}:{stop}"):
            ops.append(LINE, "B", start, stop)
    with pytest.raises(MissingClipError, match="'A', 'B'"):
        ops.append(LINE, "C")
    with pytest.raises(RangeError, match="0 seams, numbered from 0, got -1"):
        ops.set_seam(LINE, -1, Seam())
    with pytest.raises(ParameterError, match="whole number"):
        ops.insert(LINE, 1.5, "B")


def test_add_clip():
    info = ClipInfo("C", 5, 30.0)
    line = ops.add_clip(LINE, info)
    assert line.clips == (A, B, info)
    assert ops.add_clip(line, info) is line
    with pytest.raises(ParameterError, match="'C' twice"):
        ops.add_clip(line, ClipInfo("C", 6, 30.0))
