"""``video``: one figure a clip, three an edit, before beside after, and refusals before anything is read."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from kinestitch.files import write
from kinestitch.samples import sample

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
