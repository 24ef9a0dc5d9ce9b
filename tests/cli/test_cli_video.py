"""``video``: one figure a clip, three an edit, before beside after, and refusals before anything is read."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from kinestitch.cli.pictures import show
from kinestitch.cli.video import _panels
from kinestitch.files import read, write
from kinestitch.samples import sample
from kinestitch.solve.contacts import find_contacts
from kinestitch.testing import random_motion

av = pytest.importorskip("av", reason="the extra kinestitch[video] is not installed")
QUICK = ("--size", "192x96", "--fps", 10)


@pytest.fixture
def edit(kinestitch, tmp_path):
    for name in ("walk", "kick"):
        write(sample(name, fps=20), tmp_path / f"{name}.bvh")
    assert kinestitch("stitch", "walk.bvh", "--replace", "20:40", "kick.bvh@10:40", "-o", "edit.otio").code == 0


def shape(path):
    with av.open(path) as container:
        frames = [(frame.width, frame.height) for frame in container.decode(video=0)]
    assert len(set(frames)) == 1
    return len(frames), frames[0]


@pytest.mark.parametrize(
    ("words", "told", "count"),
    [
        (["edit.otio"], "39 pictures of 3 figures", 39),
        (["walk.bvh"], "34 pictures of 1 figure", 34),
        (["walk.bvh", "kick.bvh", "--view", "side"], "34 pictures of 2 figures", 34),
        (["edit.otio", "walk.bvh", "--speed", 2], "20 pictures of 4 figures", 20),
        (["walk.bvh", "--style", "skeleton"], "34 pictures of 1 figure", 34),
        (["kick.bvh", "--before", "walk.bvh", "--view", "-30"], "34 pictures of 2 figures", 34),
    ],
)
def test_videos(kinestitch, edit, words, told, count):
    ran = kinestitch("video", *words, "-o", "out.mp4", *QUICK)
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == f"out.mp4: {told}\n"
    assert shape("out.mp4") == (count, (192, 96))


def test_width_grows_with_the_figures(kinestitch, edit):
    assert kinestitch("video", "edit.otio", "-o", "out.mp4", "--fps", 1).code == 0
    assert shape("out.mp4")[1] == (1440, 540)


def test_feet_of_clips_and_edits_are_green_while_they_stand(kinestitch, edit):
    walk = read("walk.bvh")
    (clip,) = _panels(show("walk.bvh", print))
    np.testing.assert_array_equal(clip.contacts.held, find_contacts(walk).held)
    panels = _panels(show("edit.otio", print))
    assert [panel.contacts.held[:20].tolist() for panel in panels[:2]] == [clip.contacts.held[:20].tolist()] * 2
    assert all(len(panel.contacts.held) == panel.motion.frames for panel in panels)


def test_a_rig_without_feet_is_shown_without_contacts(kinestitch, tmp_path):
    write(random_motion(1, frames=5), tmp_path / "snake.bvh")
    assert _panels(show("snake.bvh", print))[0].contacts is None
    assert kinestitch("video", "snake.bvh", "-o", "out.mp4", *QUICK).code == 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["walk.bvh", "-o", "out.avi"], ".mp4"),
        (["walk.bvh", "-o", "out.mp4", "--view", "below"], "below"),
        (["walk.bvh", "-o", "out.mp4", "--size", "large"], "WIDTHxHEIGHT"),
        (["walk.bvh", "-o", "out.mp4", "--size", "961x540"], "961x540"),
        (["walk.bvh", "-o", "out.mp4", "--fps", "0"], "fps"),
        (["edit.otio", "-o", "out.mp4", "--before", "walk.bvh"], "hard cut"),
        (["nothing.bvh", "-o", "out.mp4"], "nothing.bvh"),
        (["walk.bvh", "-o", "out.mp4", "--character", "walk.bvh"], "walk.bvh"),
    ],
)
def test_what_is_refused(kinestitch, edit, words, told):
    assert told in kinestitch("video", *words).error
    assert not list(Path().glob("out*"))


def test_without_the_extra(kinestitch, edit, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    assert "pip install 'kinestitch[video]'" in kinestitch("video", "walk.bvh", "-o", "out.mp4").error
