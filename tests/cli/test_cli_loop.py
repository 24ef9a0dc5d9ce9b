"""The verb ``loop``: a clean cycle without an option, and every option does what it says."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.core.rotation import quat_distance
from kinestitch.files import read, write
from kinestitch.search.cycle import best_cycle, whole_cycle
from kinestitch.solve.loop import loop, opened, repeated
from kinestitch.testing import assert_motion_close

NEAR = {"degrees": 1e-3, "metres": 1e-5}


@pytest.fixture
def walk(tmp_path):
    """Frames 10 to 179 of the sample, two strides and a half at 30 fps, as walk.bvh; returns what a reader finds."""
    clip = ks.sample("walk", fps=30)
    part = replace(clip, rotations=clip.rotations[5:90], translations=clip.translations[5:90])
    write(part, tmp_path / "walk.bvh")
    return read(tmp_path / "walk.bvh")


def test_a_clip_becomes_a_cycle(kinestitch, walk, tmp_path):
    ran = kinestitch("loop", "walk.bvh", "-o", "cycle.bvh")
    assert ran.code == 0, ran.err
    cycle, best = read(tmp_path / "cycle.bvh"), best_cycle(walk)
    assert_motion_close(cycle, loop(walk, best.start, best.stop), **NEAR)
    assert f"cycle.bvh: {best.frames + 1} frames, 30 fps" in ran.out
    assert f"Frames {best.start}:{best.stop} of walk.bvh (85 frames); a cycle of {best.frames} frames" in ran.out
    assert ran.out.count(" ok") == 6
    assert "more\n" not in ran.out
    assert quat_distance(cycle.rotations[0, 1:], cycle.rotations[-1, 1:]).max() < 1e-4


def test_all_frames_or_those_that_are_named(kinestitch, walk, tmp_path):
    assert kinestitch("loop", "walk.bvh", "-o", "whole.bvh", "--whole", "--no-foot-lock").code == 0
    whole = whole_cycle(walk)
    assert_motion_close(read(tmp_path / "whole.bvh"), loop(walk, 0, whole.stop), **NEAR)
    assert kinestitch("loop", "walk.bvh", "-o", "named.bvh", "--frames", "20:54", "--smooth", "0.2").code == 0
    assert_motion_close(read(tmp_path / "named.bvh"), loop(walk, 20, 54, smoothing=0.2), degrees=0.5, metres=1e-5)
    assert kinestitch("loop", "walk.bvh", "-o", "rest.bvh", "--frames", "20:").code == 0
    assert read(tmp_path / "rest.bvh").frames == 66


def test_one_stride_out_of_many(kinestitch, walk, tmp_path):
    assert kinestitch("loop", "walk.bvh", "-o", "stride.bvh", "--shortest", "0.8", "--longest", "1.5").code == 0
    assert read(tmp_path / "stride.bvh").frames in (34, 35)  # a stride is 33⅓ frames


def test_open_and_copies(kinestitch, walk, tmp_path):
    for name, options in (("closed", ()), ("open", ("--open",)), ("three", ("--copies", 3))):
        assert kinestitch("loop", "walk.bvh", "-o", f"{name}.bvh", *options).code == 0
    closed, without, three = (read(tmp_path / f"{name}.bvh") for name in ("closed", "open", "three"))
    assert_motion_close(without, opened(closed), **NEAR)
    assert_motion_close(three, repeated(closed, 3), degrees=1e-2, metres=1e-4)


def test_feet_are_locked_where_it_is_needed_or_asked_for(kinestitch, tmp_path):
    write(ks.sample("walk"), tmp_path / "walk.bvh")
    slides = {}
    for name, options in (("auto", ()), ("on", ("--foot-lock",)), ("off", ("--no-foot-lock",))):
        report = f"{name}.json"
        how = ("loop", "walk.bvh", "-o", f"{name}.bvh", "--frames", "20:160", "--report", report)
        assert kinestitch(*how, *options).code == 0
        slides[name] = json.loads((tmp_path / report).read_text())["gates"]["foot_slide_m_s"]["after"]
    assert slides["auto"] == slides["on"] < 0.3 < slides["off"]


def test_the_report(kinestitch, walk, tmp_path):
    assert kinestitch("loop", "walk.bvh", "-o", "cycle.bvh", "--report", "loop.json", "--lambda", "16").code == 0
    numbers = json.loads((tmp_path / "loop.json").read_text())
    assert numbers["lambda"] == 16.0
    assert numbers["clip_frames"] == walk.frames
    assert numbers["frames"] == read(tmp_path / "cycle.bvh").frames - 1
    gate = numbers["gates"]["rotation_step_deg"]
    assert gate["bound"] == 1.0
    assert gate["kept"] is (gate["after"] <= 1.0)


def test_a_hard_cut_and_a_rig_without_feet(kinestitch, clip, tmp_path):
    clip("random.bvh")
    ran = kinestitch("loop", "random.bvh", "-o", "cycle.bvh", "--smooth", "0", "--report", "loop.json")
    assert ran.code == 0, ran.err
    assert "foot slide" not in ran.out
    gates = json.loads((tmp_path / "loop.json").read_text())["gates"]
    assert gates["foot_slide_m_s"]["after"] is None
    assert gates["rotation_step_deg"]["before"] == gates["rotation_step_deg"]["after"]
    assert np.isfinite(read(tmp_path / "cycle.bvh").rotations).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--smooth", 1, "--lambda", 1), "--smooth or --lambda, got both"),
        (("--frames", "3:9", "--whole"), "Expected --frames alone"),
        (("--whole", "--shortest", 1), "Expected no --shortest or --longest with --whole"),
        (("--frames", "3:900"), "of the clip's 85 frames, got 3:900"),
        (("--frames", "3:4"), "at least 2 of the clip's"),
        (("--shortest", 2, "--longest", 1), "shortest length of at most the longest, 1 s, got 2 s. Swap them."),
        (("--longest", 0.5), "may count. Give a shortest length as well; it is half of the clip otherwise."),
        (("--shortest", 20), "cycle of 600 frames or more, got 85 frames"),
        (("--report", "walk.bvh"), "got an input"),
        (("--report", "out.bvh"), "got one twice"),
        (("--copies", 0), "--copies"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(kinestitch, walk, tmp_path, options, message):
    assert message in kinestitch("loop", "walk.bvh", "-o", "out.bvh", *options).error
    assert not (tmp_path / "out.bvh").exists()


def test_a_clip_too_short_to_loop(kinestitch, walk, tmp_path):
    write(replace(walk, rotations=walk.rotations[:2], translations=walk.translations[:2]), tmp_path / "two.bvh")
    assert "got 2" in kinestitch("loop", "two.bvh", "-o", "out.bvh").error
    assert "at least 3 frames to loop, got 2" in kinestitch("loop", "two.bvh", "-o", "out.bvh", "--whole").error
