"""Batches of edits: all frames are those of the unedited timeline."""

import re
from contextlib import suppress

import pytest
from edit_strategies import labels
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.edit import operations as ops
from kinestitch.edit.script import Edit, apply_edits, parse_range, parse_source
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline, timeline
from kinestitch.errors import MissingClipError, ParameterError, RangeError

FRAMES = 24
CLIPS = (ClipInfo("A", FRAMES, 30.0), *(ClipInfo(key, 5, 30.0) for key in "BCDE"))
LINE = timeline(CLIPS, "A")
SPLIT = Timeline(
    CLIPS, (Segment("A", FrameRange(3, 13)), Segment("B", FrameRange(0, 4)), Segment("A", FrameRange(0, 10))),
    (Seam(), Seam(stiffness=3.0)), 30.0,
)  # fmt: skip


@st.composite
def edits(draw):
    kind = draw(st.sampled_from(["replace", "insert", "append", "delete"]))
    a = draw(st.integers(0, FRAMES))
    b = draw(st.integers(0, FRAMES).filter(lambda b: b != a))
    start, stop = min(a, b), max(a, b)
    clip = {} if kind == "delete" else {"clip": draw(st.sampled_from("BCDE")), "clip_stop": draw(st.integers(1, 5))}
    place = {"append": {}, "insert": {"start": a}}.get(kind, {"start": start, "stop": stop})
    return Edit(kind, **place, **clip)


def by_hand(line, script):
    """The result as labels, or None where two edits overlap: every border keeps a list of what is put there."""
    before = labels(line)
    put = [[] for _ in range(FRAMES + 1)]
    tail, gone = [], set()
    for edit in script:
        pasted = [(edit.clip, frame) for frame in range(edit.clip_stop)] if edit.pastes else []
        if edit.kind == "append":
            tail += pasted
            continue
        put[edit.start] += pasted
        frames = set(range(edit.start, edit.stop or edit.start))
        if gone & frames:
            return None
        gone |= frames
    for edit in script:
        for other in script:
            if other.stop is not None and edit.kind == "insert" and other.start < edit.start < other.stop:
                return None
    result = []
    for place in range(FRAMES + 1):
        result += put[place]
        if place < FRAMES and place not in gone:
            result.append(before[place])
    return result + tail


@given(st.sampled_from([LINE, SPLIT]), st.lists(edits(), max_size=6))
def test_apply_edits_equals_brute_force(line, script):
    expected = by_hand(line, script)
    if expected is None or not expected:
        with pytest.raises(RangeError):
            apply_edits(line, script)
    else:
        assert labels(apply_edits(line, script)) == expected


@given(st.lists(edits(), min_size=1, max_size=1))
def test_one_edit_is_the_operation(script):
    (edit,) = script
    place = [value for value in (edit.start, edit.stop) if value is not None]
    source = [edit.clip, None, edit.clip_stop] if edit.pastes else []
    operation = getattr(ops, edit.kind)
    try:
        expected = operation(SPLIT, *place, *source, seam=Seam(stiffness=9.0))
    except RangeError:
        with pytest.raises(RangeError):
            apply_edits(SPLIT, script, seam=Seam(stiffness=9.0))
        return
    assert apply_edits(SPLIT, script, seam=Seam(stiffness=9.0)) == expected


def shown(*script):
    return " ".join(str(segment) for segment in apply_edits(LINE, script).segments)


def test_order_at_one_place():
    insert_b, insert_c = Edit("insert", 6, clip="B"), Edit("insert", 6, clip="C")
    paste = Edit("replace", 6, 8, clip="D")
    assert shown(insert_b, insert_c) == "A@0:6 B@0:5 C@0:5 A@6:24"
    assert shown(insert_c, insert_b) == "A@0:6 C@0:5 B@0:5 A@6:24"
    assert shown(insert_b, paste) == "A@0:6 B@0:5 D@0:5 A@8:24"
    assert shown(paste, insert_b) == "A@0:6 D@0:5 B@0:5 A@8:24"
    assert shown(Edit("insert", 8, clip="B"), paste) == "A@0:6 D@0:5 B@0:5 A@8:24"


def test_appends_come_last():
    end = Edit("insert", 24, clip="B")
    assert shown(Edit("append", clip="C"), Edit("append", clip="D"), end) == "A@0:24 B@0:5 C@0:5 D@0:5"


def test_neighbouring_edits_do_not_overlap():
    assert shown(Edit("delete", 10, 12), Edit("replace", 12, 14, clip="B"), Edit("insert", 10, clip="C")) == (
        "A@0:10 C@0:5 B@0:5 A@14:24"
    )
    assert shown(Edit("delete", 0, 24), Edit("insert", 3 * 8, clip="B")) == "B@0:5"


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (Edit("delete", 4, 8), Edit("replace", 7, 9, clip="B")),
        (Edit("replace", 2, 20, clip="C"), Edit("insert", 5, clip="B")),
        (Edit("delete", 4, 8), Edit("delete", 4, 8)),
    ],
)
def test_overlaps_name_both(first, second):
    for script in ((first, second), (second, first)):
        with pytest.raises(RangeError, match="separate frames") as caught:
            apply_edits(LINE, script)
        assert str(first) in str(caught.value)
        assert str(second) in str(caught.value)


def test_no_edits_return_the_input():
    assert apply_edits(LINE, []) is LINE


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"kind": "cut", "start": 3}, "Expected one of replace, insert, append, delete, got 'cut'"),
        ({"kind": "replace", "start": 3, "clip": "B"}, "a stop for replace, got none"),
        ({"kind": "insert", "start": 3, "stop": 4, "clip": "B"}, "no stop for insert, got 4"),
        ({"kind": "append", "start": 3, "clip": "B"}, "no start for append, got 3"),
        ({"kind": "insert", "start": 3}, "a clip for insert, got none"),
        ({"kind": "delete", "start": 3, "stop": 4, "clip": "B"}, "no clip for delete, got 'B'"),
        ({"kind": "delete", "start": 3, "stop": 4, "clip_stop": 4}, "no range of a clip"),
    ],
)
def test_incomplete_edits_are_refused(fields, words):
    with pytest.raises(ParameterError, match=re.escape(words)):
        Edit(**fields)


def test_edits_outside_are_refused():
    with pytest.raises(RangeError, match="0:24"):
        apply_edits(LINE, [Edit("delete", 20, 25)])
    with pytest.raises(RangeError, match="0 to 24"):
        apply_edits(LINE, [Edit("insert", 25, clip="B")])
    with pytest.raises(MissingClipError, match="'X'"):
        apply_edits(LINE, [Edit("append", clip="X")])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("walk.fbx", ("walk.fbx", None, None)),
        ("walk.fbx@20:75", ("walk.fbx", 20, 75)),
        ("walk.fbx@20:", ("walk.fbx", 20, None)),
        ("walk.fbx@:75", ("walk.fbx", None, 75)),
        ("walk.fbx@:", ("walk.fbx", None, None)),
        ("walk@2.fbx@20:75", ("walk@2.fbx", 20, 75)),
        ("walk@2.fbx", ("walk@2.fbx", None, None)),
        ("a@1:2@3:4", ("a@1:2", 3, 4)),
        ("C:\\clips\\Happy Walk@30.bvh@0:9", ("C:\\clips\\Happy Walk@30.bvh", 0, 9)),
        ("C:\\clips\\walk.bvh", ("C:\\clips\\walk.bvh", None, None)),
        ("odd@x:9", ("odd@x:9", None, None)),
        ("two\nlines@1:2", ("two\nlines", 1, 2)),
    ],
)
def test_sources(text, expected):
    assert parse_source(text) == expected


@given(st.text(min_size=1), st.none() | st.integers(0, 10**9), st.none() | st.integers(0, 10**9))
def test_sources_round_trip(path, start, stop):
    text = f"{path}@{'' if start is None else start}:{'' if stop is None else stop}"
    assert parse_source(text) == (path, start, stop)


@pytest.mark.parametrize("text", ["", "@1:2", "@:"])
def test_sources_need_a_path(text):
    with pytest.raises(ParameterError, match="PATH@START:STOP"):
        parse_source(text)


@given(st.text())
def test_parsers_raise_nothing_else(text):
    with suppress(ParameterError):
        parse_range(text)
    with suppress(ParameterError):
        parse_source(text)


@pytest.mark.parametrize("text", ["60", "", "60-110", "a:b", "-1:5", "1:2:3", "1.5:3"])
def test_parse_range_refuses(text):
    with pytest.raises(ParameterError, match=re.escape(repr(text))):
        parse_range(text)
