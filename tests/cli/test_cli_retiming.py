"""The options ``--speed``, ``--align-steps`` and ``--warp``."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import kinestitch as ks
from kinestitch.edit import load_document, set_speed
from kinestitch.files import read, write
from kinestitch.search.align import align_phase, phase_gaps
from kinestitch.search.phase import find_steps


@pytest.fixture
def steps(tmp_path, kinestitch):
    for name in ("walk", "run", "idle"):
        write(ks.sample(name, fps=30.0), tmp_path / f"{name}.bvh")
    return kinestitch


CUT = ("stitch", "walk.bvh", "--delete", "55:101", "--append", "run.bvh@25:")


def gap(path: str) -> float:
    document = load_document(path)
    clips = {key: read(file) for key, file in document.sources.items()}
    return phase_gaps(document.timeline, find_steps(document.timeline, clips))[0]


def test_speed(steps):
    ran = steps(*CUT, "--speed", "2=0.5", "--speed", "1=1.5", "-o", "out.bvh")
    assert ran.code == 0
    assert "note: segment 2 (run 25:81) plays at 0.5 × speed: 111 frames, before 56." in ran.err
    assert "note: segment 1 (walk 0:55) plays at 1.5 × speed: 37 frames, before 55." in ran.err
    assert read("out.bvh").frames == 111 + 37


def test_speed_stands_in_the_document_and_info_tells_it(steps):
    assert steps(*CUT, "--speed", "2=0.5", "-o", "edit.otio").code == 0
    document = load_document("edit.otio")
    assert [segment.clip for segment in document.timeline.segments] == ["walk", "run ×0.5"]
    assert sorted(document.sources) == ["run", "walk"]
    told = steps("info", "edit.otio").out
    assert "segment 1   from 0: walk 0:55 " in told
    assert "segment 2   from 55: run ×0.5 50:161 " in told
    assert "at 0.5 × speed" not in told
    assert "run ×0.5: 161 frames, 30 fps, run retimed" in told
    facts = json.loads(steps("info", "--json", "edit.otio").out)[0]
    assert [part["slowest"] for part in facts["segments"]] == [1.0, 0.5]
    assert [source["retimes"] for source in facts["sources"]] == ["", "", "run"]
    assert steps("stitch", "edit.otio", "-o", "one.bvh").code == 0
    assert read("one.bvh").frames == document.timeline.frames
    assert steps("stitch", "edit.otio", "--speed", "2=1", "-o", "plain.otio").code == 0
    assert [clip.key for clip in load_document("plain.otio").timeline.clips] == ["walk", "run"]
    assert steps("filmstrip", "edit.otio", "-o", "strip.png").code == 0


def test_info_tells_the_speed_of_a_clip_of_another_name(steps):
    assert steps(*CUT, "--speed", "2=0.5", "-o", "edit.otio").code == 0
    text = Path("edit.otio").read_text(encoding="utf-8")
    assert "run ×0.5" in text
    Path("other.otio").write_text(text.replace("run ×0.5", "slow run"), encoding="utf-8")
    assert "segment 2   from 55: slow run 50:161 at 0.5 × speed" in steps("info", "other.otio").out


def test_speed_of_the_original_alone(steps):
    assert steps("stitch", "walk.bvh", "--speed", "1=2", "-o", "fast.bvh").code == 0
    line = set_speed(ks.timeline({"walk": read("walk.bvh")}, "walk"), 0, 2.0)
    assert read("fast.bvh").frames == line.frames == 51


def test_align_steps(steps):
    steps(*CUT, "-o", "before.otio")
    ran = steps(*CUT, "--align-steps", "0.3", "-o", "after.otio")
    assert ran.code == 0
    assert "note: seam 1 moved: walk now ends before frame" in ran.err
    before = load_document("before.otio").timeline
    clips = {"walk": read("walk.bvh"), "run": read("run.bvh")}
    assert load_document("after.otio").timeline == align_phase(before, clips, 0.3).timeline
    assert abs(gap("after.otio")) < 0.18 < abs(gap("before.otio"))


def test_what_align_steps_cannot_do_it_says(steps):
    ran = steps(*CUT, "--align-steps", "0.05", "-o", "out.otio")
    assert "note: the steps at seam 1 still differ by" in ran.err
    assert "no nearer place lies within 0.05 s" in ran.err
    ran = steps("stitch", "walk.bvh", "--append", "idle.bvh", "--align-steps", "0.3", "-o", "out.otio")
    assert ran.err.strip() == "note: no steps to align at seam 1: idle makes no steps around frame 0."
    assert ran.code == 0


def test_what_is_as_it_should_be_they_say_once(steps):
    same = ("--delete", "50:101", "--append", "walk.bvh@50:", "-o", "out.otio")
    ran = steps("stitch", "walk.bvh", *same, "--align-steps", "0.3")
    assert ran.err == "note: the steps at seam 1 meet already, to 0° of a stride's 360°; it stays.\n"
    for words in (("--warp", "0.2"), ("--align-steps", "0.3", "--warp", "0.2")):
        ran = steps("stitch", "walk.bvh", *same, *words)
        assert ran.err == "note: the steps at seam 1 meet already; time stays as it is.\n"
        ran = steps("stitch", "walk.bvh", *words, "-o", "out.otio")
        assert ran.err == "note: no seam at which steps could meet: the result is one stretch of one clip.\n"
        ran = steps("stitch", "walk.bvh", "--append", "idle.bvh", *words, "-o", "out.otio")
        assert ran.err == "note: no steps to align at seam 1: idle makes no steps around frame 0.\n"


def test_why_steps_stay_apart(steps):
    for words in (("--align-steps", "0.3"), ("--warp", "0.2"), ("--align-steps", "0.3", "--warp", "0.2")):
        ran = steps(*CUT, *words, "--smooth", "0", "-o", "out.otio")
        assert "note: the steps at seam 1 still differ by" in ran.err
        assert ran.err.endswith("; hard cuts stay.\n")
    ran = steps("stitch", "walk.bvh", "--append", "walk.bvh@2:", "--warp", "0.2", "-o", "out.otio")
    assert ran.err.endswith("; the clips leave no frames to bend time with.\n")


def test_steps_at_the_start_of_a_faster_clip_are_found(steps):
    words = ("stitch", "walk.bvh", "--delete", "55:101", "--append", "run.bvh", "--speed", "2=1.2", "-o", "out.otio")
    ran = steps(*words, "--align-steps", "0.3", "--warp", "0.2")
    assert "no steps" not in ran.err
    assert "note: seam 1 moved" in ran.err
    assert "note: time bent at seam 1" in ran.err


def test_clips_without_feet(clip, kinestitch):
    clip("a.bvh", frames=50, seed=1)
    clip("b.bvh", frames=40, seed=2)
    ran = kinestitch("stitch", "a.bvh", "--append", "b.bvh", "--align-steps", "0.2", "--warp", "0.1", "-o", "out.bvh")
    assert ran.code == 0
    assert "a has no feet that its joints' names tell, b has no feet" in ran.err


def test_warp(steps):
    ran = steps("stitch", "walk.bvh", "--delete", "45:101", "--append", "run.bvh@29:", "--warp", "0.2", "-o", "w.otio")
    assert ran.code == 0
    assert "note: time bent at seam 1: 1." in ran.err
    assert "stay" not in ran.err
    assert abs(gap("w.otio")) < 1e-6
    assert load_document("w.otio").timeline.starts == (0, 45, 97)
    assert "speed" in steps("info", "w.otio").out
    assert steps("stitch", "w.otio", "-o", "w.bvh").code == 0
    assert read("w.bvh").frames == 97
    ran = steps(*CUT, "--warp", "0.05", "-o", "out.otio")
    assert "° stay, as far as the bound and the clips allow." in ran.err


def test_all_together_with_snap(steps):
    words = ("--insert", "20", "idle.bvh@10:60", "--align-steps", "0.3", "--snap", "0.2", "--warp", "0.2")
    ran = steps("stitch", "walk.bvh", "--delete", "55:101", "--append", "run.bvh@25:", *words, "-o", "out.otio")
    assert ran.code == 0
    assert "no steps to align at seam 1" in ran.err
    assert "seam 1 moved" in ran.err
    assert "seam 3 moved" in ran.err
    assert len(load_document("out.otio").timeline.segments) == 4


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--speed", "3=2"), "one of the result's 2 segments, counted from 1, got --speed 3"),
        (("--speed", "1=20"), "speed from 0.1 to 10, got 20"),
        (("--speed", "1=0"), "speed from 0.1 to 10, got 0"),
        (("--speed", "0=2"), "N=FACTOR"),
        (("--speed", "2"), "N=FACTOR"),
        (("--speed", "1=nan"), "N=FACTOR"),
        (("--speed", "kick=2"), "N=FACTOR"),
        (("--align-steps", "-1"), "≥ 0"),
        (("--warp", "0.7"), "--warp"),
        (("--warp", "0"), "--warp"),
    ],
)
def test_refusals(steps, words, said):
    assert said in steps(*CUT, *words, "-o", "out.bvh").error
