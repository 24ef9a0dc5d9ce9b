"""Clips joined whole whose joining frames are the same pose: the pose is shown once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.rotation import quat_about_axis, quat_multiply, quat_rotate
from kinestitch.files import read, write
from kinestitch.testing import assert_motion_close, random_motion


@pytest.fixture
def halves(tmp_path):
    """One clip, and its halves as two files that share frame 30; the second stands elsewhere and faces elsewhere."""
    whole = random_motion(5, frames=61)
    first = replace(whole, rotations=whole.rotations[:31], translations=whole.translations[:31])
    rotations, translations = whole.rotations[30:].copy(), whole.translations[30:].copy()
    turn = quat_about_axis(1, 1.1)
    rotations[:, 0] = quat_multiply(turn, rotations[:, 0])
    translations[:, 0] = quat_rotate(turn, translations[:, 0]) + np.array([3.0, 0.0, -2.0])
    second = replace(whole, rotations=rotations, translations=translations)
    for name, motion in (("whole", whole), ("first", first), ("second", second)):
        write(motion, tmp_path / f"{name}.bvh")
    return whole


def test_the_shared_frame_is_kept_once(kinestitch, halves):
    ran = kinestitch("stitch", "first.bvh", "--append", "second.bvh", "--method", "cut", "-o", "out.bvh")
    assert ran.code == 0
    assert ran.err == "note: second starts with the last pose of first; that frame is kept once.\n"
    assert read("out.bvh").frames == 61
    # The cut's heading is fitted over two frames, of which the halves share one; so the fit is close, not exact.
    assert_motion_close(read("out.bvh"), read("whole.bvh"), degrees=1.0, metres=0.02)


def test_it_holds_for_every_clip_of_a_row(kinestitch, halves):
    ran = kinestitch("stitch", "first.bvh", "--append", "second.bvh", "--append", "first.bvh", "-o", "out.bvh")
    assert ran.err.count("note:") == 1
    assert read("out.bvh").frames == 61 + 31


@pytest.mark.parametrize("reference", ["second.bvh@0:20", "second.bvh@1:", "whole.bvh"])
def test_a_part_or_another_pose_stays_as_it_is(kinestitch, halves, reference):
    ran = kinestitch("stitch", "first.bvh", "--append", reference, "-o", "out.bvh")
    assert (ran.code, ran.err) == (0, "")


def test_an_insert_is_not_a_join(kinestitch, halves):
    ran = kinestitch("stitch", "first.bvh", "--insert", 31, "second.bvh", "-o", "out.bvh")
    assert ran.err == ""
    assert read("out.bvh").frames == 62


def test_the_document_says_so_too(kinestitch, halves):
    assert kinestitch("stitch", "first.bvh", "--append", "second.bvh", "-o", "edit.otio").err.count("note:") == 1
    assert kinestitch("stitch", "edit.otio", "-o", "out.bvh").err == ""
    assert read("out.bvh").frames == 61
