"""Pins as values: what they may say, how they are written, and that they go where their frames go."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest
from edit_strategies import agreeing, pinned_labels, pins, spans, timelines
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from kinestitch.edit import operations as ops
from kinestitch.edit.document import load_document, save_document
from kinestitch.edit.history import History, commit, undo
from kinestitch.edit.pieces import with_bounds
from kinestitch.edit.pinning import add_pin, come_back, remove_pin
from kinestitch.edit.pins import Pin, parse_pin, parse_waypoint
from kinestitch.edit.script import Edit, apply_edits
from kinestitch.edit.timeline import ClipInfo, FrameRange, Segment, timeline
from kinestitch.errors import DocumentError, KinestitchWarning, ParameterError, RangeError

A, B = ClipInfo("A", 120, 30.0), ClipInfo("B", 101, 60.0)
LINE = timeline([A, B], "A")


@given(timelines(), st.data())
def test_every_edit_takes_pins_where_their_frames_go(line, data):
    (start, stop), info = data.draw(spans(line)), data.draw(st.sampled_from(line.clips))
    before = pinned_labels(line)
    pasted = [((info.key, frame), ()) for frame in range(info.frames_at(line.fps))]
    assert pinned_labels(ops.replace(line, start, stop, info.key)) == before[:start] + pasted + before[stop:]
    assert pinned_labels(ops.insert(line, start, info.key)) == before[:start] + pasted + before[start:]
    assert pinned_labels(ops.append(line, info.key)) == before + pasted
    assert pinned_labels(ops.trim(line, start, stop)) == before[start:stop]
    if stop - start < line.frames:
        assert pinned_labels(ops.delete(line, start, stop)) == before[:start] + before[stop:]
    if line.frames > 1:
        assert pinned_labels(ops.split(line, max(1, start))) == before
    to = data.draw(st.integers(0, start) | st.integers(stop, line.frames))
    rest, at = before[:start] + before[stop:], to if to <= start else to - (stop - start)
    assert pinned_labels(ops.move(line, start, stop, to)) == rest[:at] + before[start:stop] + rest[at:]
    script = [Edit("delete", start, stop), Edit("append", clip=info.key)]
    assert pinned_labels(apply_edits(line, script)) == before[:start] + before[stop:] + pasted


@given(timelines(), st.data())
def test_other_bounds_keep_pins_on_the_frames_of_their_clips(line, data):
    def other(segment):
        frames = line.clip(segment.clip).frames_at(line.fps)
        start = data.draw(st.integers(0, frames - 1))
        return Segment(segment.clip, FrameRange(start, data.draw(st.integers(start + 1, frames))))

    segments = tuple(map(other, line.segments))
    found = with_bounds(line, segments)
    assert found.segments == segments
    expected, before = [], pinned_labels(line)
    for old, new, first in zip(line.segments, segments, line.starts, strict=False):
        shown = {frame: pinned for (_, frame), pinned in before[first : first + len(old)]}
        expected += [((new.clip, frame), shown.get(frame, ())) for frame in range(new.range.start, new.range.stop)]
    assert pinned_labels(found) == expected


@given(timelines(), st.data())
def test_pins_are_added_and_removed_one_by_one(line, data):
    pin = data.draw(pins(line.frames))
    if agreeing([*line.pins, pin]) != (*line.pins, pin):
        with pytest.raises(ParameterError, match="one pin for the"):
            add_pin(line, pin)
        return
    more = add_pin(line, pin)
    assert more != line
    assert [p.frame for p in more.pins] == sorted(p.frame for p in more.pins)
    assert remove_pin(more, more.pins.index(pin)) == line
    history = commit(History(line), more)
    assert undo(history).value == line


def test_places_outside_are_refused():
    for frame in (-1, 120):
        with pytest.raises(RangeError, match=r"frames 0 to 119, got heading@"):
            add_pin(LINE, Pin("heading", frame, (1.0,)))
    with pytest.raises(RangeError, match="0 pins, numbered from 0, got 0"):
        remove_pin(LINE, 0)
    with pytest.raises(ParameterError, match="whole number"):
        remove_pin(LINE, 0.5)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (Pin("root", 5, (0, 0, 1)), Pin("waypoint", 5, (0, 1), weight=2.0)),
        (Pin("root", 5, (0, 0, 1)), Pin("root", 5, (0, 0, 2))),
        (Pin("heading", 5, (1,)), Pin("return", 5, smoothing=1.0)),
        (Pin("position", 5, (0, 0, 1), "Hand"), Pin("position", 5, (0, 0, 1), "Hand", 3.0)),
    ],
)
def test_two_pins_for_one_thing_are_refused(first, second):
    with pytest.raises(ParameterError, match=r"one pin for the \w+ in frame 5, got .* and "):
        replace(LINE, pins=(first, second))
    assert len(replace(LINE, pins=(first, replace(second, frame=6))).pins) == 2


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"kind": "knee"}, "a pin out of root, heading"),
        ({"frame": 1.5}, "whole number for a pin's frame"),
        ({"target": (0.0, 1.0)}, "3 numbers for the pin root on frame 3, got 2"),
        ({"target": (0.0, 1.0, math.nan)}, "finite number for a pin's target"),
        ({"target": (0.0, 1.0, math.inf)}, "finite number for a pin's target"),
        ({"target": (0.0, 1.0, "x")}, "a number for a pin's target"),
        ({"joint": "Hips"}, "no joint for the pin root on frame 3, got 'Hips'"),
        ({"kind": "position"}, "a joint for the pin position on frame 3, got none"),
        ({"weight": 0.0}, "weight > 0"),
        ({"weight": -1.0}, "weight > 0"),
        ({"weight": math.nan}, "finite number for a pin's weight"),
        ({"smoothing": 0.0}, "smoothing time > 0 s"),
        ({"kind": "rotation", "target": (0, 0, 0, 2.0), "joint": "Head"}, "length 1"),
        ({"kind": "return", "target": ()}, "a time for the way back"),
        ({"kind": "return", "target": (), "smoothing": 1.0, "weight": 2.0}, "no weight"),
    ],
)
def test_values_out_of_their_domain(values, words):
    with pytest.raises(ParameterError, match=words) as caught:
        Pin(**{"kind": "root", "frame": 3, "target": (0.0, 0.0, 1.0)} | values)
    assert "\n" not in str(caught.value)


@given(st.data())
def test_what_is_written_is_read(data):
    pin = data.draw(pins(1000).filter(lambda pin: pin.kind != "return"))
    text = str(replace(pin, smoothing=None))
    again = parse_waypoint(text.removeprefix("waypoint@")) if pin.kind == "waypoint" else parse_pin(text)
    assert (again.kind, again.frame, again.joint) == (pin.kind, pin.frame, pin.joint)
    assert again.target == pytest.approx(pin.target, rel=1e-5)
    assert again.weight == pytest.approx(pin.weight, rel=1e-5)


def test_notation():
    assert parse_pin("heading@120=90") == Pin("heading", 120, (math.pi / 2,))
    assert parse_pin("mixamorig:LeftHand@80=0.1,-1.4,3e-1:2.5") == Pin(
        "position", 80, (0.1, -1.4, 0.3), "mixamorig:LeftHand", 2.5
    )
    assert parse_pin("Head@8=0,0,0.6,0.8") == Pin("rotation", 8, (0, 0, 0.6, 0.8), "Head")
    assert parse_waypoint(" 30=1,2:4 ") == Pin("waypoint", 30, (1, 2), weight=4.0)


NO_PINS = """|root|root@1|root@x=1,2,3|root@-1=1,2,3|root@1=1,2|root@1=1,2,3:0|root@1=1,2,3:x|@1=1,2,3|Head@1=1,2
|Head@1=1,2,3,4,5|Head@1=1,2,3,4|heading@1=north|root@1=1,,3|root@1=1,2,inf"""


@pytest.mark.parametrize("text", NO_PINS.split("|"))
def test_what_is_no_pin(text):
    with pytest.raises(ParameterError, match="Expected") as caught:
        parse_pin(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "30", "30=1", "30=1,2,3", "x=1,2", "30=1,2:", "30=1,2:-1"])
def test_what_is_no_waypoint(text):
    with pytest.raises(ParameterError, match="Expected"):
        parse_waypoint(text)


def test_coming_back():
    line = ops.insert(LINE, 60, "B", 20, 60)
    assert come_back(line, 0.5).pins == (Pin("return", 95, smoothing=0.5),)
    assert come_back(line, 1e-9).pins[0].frame == 81
    with pytest.raises(ParameterError, match="got a clip as it was"):
        come_back(LINE, 1.0)
    with pytest.raises(ParameterError, match="a piece of 'A' behind the last seam to come back to, got 'B'"):
        come_back(ops.append(LINE, "B"), 1.0)
    with pytest.raises(RangeError, match=r"at most 1.97 s, all of the last segment, got 2 s"):
        come_back(line, 2.0)
    with pytest.raises(ParameterError, match="smoothing time > 0"):
        come_back(line, 0.0)


def kept(tmp_path, line, change=None):
    """What a document gives back, after another program has changed its text."""
    path = tmp_path / "edit.otio"
    save_document(line, path)
    data = json.loads(path.read_text())
    if change is not None:
        change(data["tracks"]["children"][0]["children"])
    path.write_text(json.dumps(data))
    return load_document(path).timeline


PINNED = replace(
    ops.insert(LINE, 60, "B", 20, 60),
    pins=(Pin("root", 10, (0.1, 0, 3)), Pin("heading", 70, (1 / 3,)), Pin("return", 90, smoothing=0.3)),
)


def test_pins_travel_with_their_segments(tmp_path):
    assert kept(tmp_path, PINNED) == PINNED
    swapped = kept(tmp_path, PINNED, lambda children: children.reverse())
    assert [(pin.kind, pin.frame) for pin in swapped.pins] == [("return", 10), ("heading", 70), ("root", 90)]
    without = kept(tmp_path, PINNED, lambda children: children.pop(1))
    assert [(pin.kind, pin.frame) for pin in without.pins] == [("root", 10), ("return", 70)]


def test_a_pin_whose_frame_another_program_cut_off_is_left_out(tmp_path):
    def shorten(children):
        children[0]["source_range"]["duration"]["value"] = 5

    with pytest.warns(KinestitchWarning, match="1 × pin on a frame that is not shown"):
        line = kept(tmp_path, PINNED, shorten)
    assert [(pin.kind, pin.frame) for pin in line.pins] == [("heading", 15), ("return", 35)]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda pin: pin.pop("kind"), "a pin's kind to be text, got nothing"),
        (lambda pin: pin.update(kind="knee"), "a pin out of root"),
        (lambda pin: pin.update(frame="x"), "a pin's frame to be a whole number"),
        (lambda pin: pin.update(frame=1.0), "a pin's frame to be a whole number"),
        (lambda pin: pin.update(target=3), "a pin's target to be a list"),
        (lambda pin: pin.update(target=[1, 2]), "3 numbers"),
        (lambda pin: pin.update(target=[1, 2, None]), "a pin's target"),
        (lambda pin: pin.update(weight="much"), "a pin's weight"),
        (lambda pin: pin.update(weight=-1), "weight > 0"),
        (lambda pin: pin.update(joint=3), "a pin's joint to be text"),
        (lambda pin: pin.update(smoothing=math.nan), "smoothing"),
    ],
)
def test_damaged_pins(tmp_path, change, words):
    with pytest.raises(DocumentError, match=words) as caught:
        kept(tmp_path, PINNED, lambda children: change(children[0]["metadata"]["kinestitch"]["pins"][0]))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("value", [3, "x", [3], {"kind": "root"}, None])
def test_pins_that_are_no_list_of_tables(tmp_path, value):
    with pytest.raises(DocumentError, match="Expected"):
        kept(tmp_path, PINNED, lambda children: children[0]["metadata"]["kinestitch"].update(pins=value))


def test_settings_of_a_pin_that_nobody_knows_are_left_out(tmp_path):
    def extend(children):
        children[0]["metadata"]["kinestitch"]["pins"][0]["colour"] = "red"

    with pytest.warns(KinestitchWarning, match="1 × unknown setting 'colour'"):
        assert kept(tmp_path, PINNED, extend) == PINNED


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(timelines(most_frames=2**40))
def test_round_trips_of_pins_are_exact(tmp_path, line):
    again = kept(tmp_path, line)
    assert again.pins == line.pins
    assert again == line
