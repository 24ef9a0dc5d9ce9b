"""``stitch`` locks feet unless told otherwise, and the report tells what that did or would do."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from kinestitch.files import read, write
from kinestitch.samples import sample


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
