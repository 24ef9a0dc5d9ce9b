"""``stitch`` locks feet unless told otherwise, and the report tells what that did or would do."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from kinestitch.cli.pictures import show
from kinestitch.files import read, write
from kinestitch.samples import sample
from kinestitch.testing import assert_motion_close


@pytest.fixture
def walker(tmp_path):
    for name in ("walk", "kick"):
        write(sample(name, fps=30), tmp_path / f"{name}.bvh")


def told(kinestitch, *words: str) -> dict:
    ran = kinestitch("stitch", "walk.bvh", "--replace", "42:65", "kick.bvh@15:56", *words, "--report", "r.json")
    assert (ran.code, ran.err) == (0, "")
    return json.loads(Path("r.json").read_text(encoding="utf-8"))["feet"]


@pytest.mark.usefixtures("walker")
def test_feet_are_locked_and_need_not_be(kinestitch):
    on = told(kinestitch, "-o", "on.bvh")
    off = told(kinestitch, "--no-foot-lock", "-o", "off.bvh")
    assert on["locked"]
    assert not off["locked"]
    assert on["slide_in_contact_m_s_after"] < 0.3 * on["slide_in_contact_m_s_before"]
    assert off["slide_in_contact_m_s_after"] == off["slide_in_contact_m_s_before"]
    assert np.abs(read("on.bvh").rotations - read("off.bvh").rotations).max() > 1e-2


@pytest.mark.usefixtures("walker")
def test_a_hard_cut_stays_one(kinestitch):
    assert not told(kinestitch, "--foot-lock", "--method", "cut", "-o", "cut.bvh")["locked"]


def test_a_rig_without_feet_is_stitched_as_it_was(kinestitch, clip):
    clip("walk.bvh", frames=80)
    clip("kick.bvh", frames=60, seed=1)
    assert told(kinestitch, "--foot-lock", "-o", "out.bvh") is None


@pytest.mark.usefixtures("walker")
def test_a_document_says_whether_feet_are_locked(kinestitch):
    words = ("stitch", "walk.bvh", "--replace", "42:65", "kick.bvh@15:56")
    assert kinestitch(*words, "--no-foot-lock", "-o", "edit.otio").code == 0
    for document, options, locked in (("edit.otio", (), False), ("edit.otio", ("--foot-lock",), True)):
        assert kinestitch("stitch", document, *options, "-o", "out.bvh", "--report", "r.json").code == 0
        assert json.loads(Path("r.json").read_text(encoding="utf-8"))["feet"]["locked"] is locked
    assert "feet" in kinestitch("info", "edit.otio").out


@pytest.mark.usefixtures("walker")
def test_bars_say_when_the_feet_stand(kinestitch):
    """Ten characters for half a second on each side of each seam, told by the contacts of the report."""
    words = ("stitch", "walk.bvh", "--replace", "42:65", "kick.bvh@15:56", "--report", "r.json", "-o", "out.bvh")
    lines = [line.split() for line in kinestitch(*words).out.splitlines() if "|" in line]
    report = json.loads(Path("r.json").read_text(encoding="utf-8"))
    joints = list(report["feet"]["contacts"].values())
    for line, seam in zip(lines, report["seams"], strict=True):
        assert (line[0], line[1], line[3]) == (str(seam["frame"]), "L", "R")
        for bar, foot in ((line[2], joints[:2]), (line[4], joints[2:])):
            before, after = bar.split("|")
            assert len(before) == len(after) == 10
            for slot, mark in enumerate(before + after):
                frames = np.arange(*(int(np.floor(1.5 * (slot - k) + 0.5)) for k in (10, 9))) + seam["frame"]
                stands = [any(start <= frame < stop for joint in foot for start, stop in joint) for frame in frames]
                if all(stands) or not any(stands):
                    assert (mark == "█") is all(stands)


@pytest.mark.usefixtures("walker")
def test_what_is_not_done_is_not_told(kinestitch):
    words = ("stitch", "walk.bvh", "--replace", "42:65", "kick.bvh@15:56", "-o", "out.bvh")
    locked = kinestitch(*words).out
    assert "smooth s" in locked
    assert "█ stands, ░ stood in its clip and steps instead." in locked
    free = kinestitch(*words, "--no-foot-lock").out
    assert "smooth s" in free
    assert "░" not in free
    assert "█ stands." in free
    cut = kinestitch(*words, "--method", "cut").out
    assert "smooth s" not in cut
    assert "░" not in cut
    assert "hips step cm" in cut


def test_there_are_no_bars_without_feet(kinestitch, clip):
    clip("walk.bvh", frames=80)
    clip("kick.bvh", frames=60, seed=1)
    ran = kinestitch("stitch", "walk.bvh", "--append", "kick.bvh", "-o", "out.bvh")
    assert ran.code == 0
    assert "|" not in ran.out


@pytest.mark.usefixtures("walker")
def test_what_is_shown_is_what_stitch_writes(kinestitch):
    """`plot` and `filmstrip` lock the feet of an edit as `stitch` does, unless the edit says otherwise."""
    words = ("stitch", "walk.bvh", "--replace", "42:65", "kick.bvh@15:56")
    for options in ((), ("--no-foot-lock",)):
        assert kinestitch(*words, *options, "-o", "edit.otio").code == 0
        assert kinestitch("stitch", "edit.otio", "-o", "out.bvh").code == 0
        shown = show("edit.otio", lambda _: None)
        assert_motion_close(shown.motion, read("out.bvh"), degrees=1e-3, metres=1e-5)
        assert (shown.contacts is None) is bool(options)
    assert kinestitch("plot", "edit.otio", "-o", "plot.svg").code == 0
    drawn = Path("plot.svg").read_text(encoding="utf-8")
    assert all(f"{side} {part}" in drawn for side in ("left", "right") for part in ("ankle", "toe"))
