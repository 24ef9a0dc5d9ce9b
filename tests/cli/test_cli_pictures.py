"""``plot``, ``filmstrip`` and ``demo``: pictures are made, and made of the right frames."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from kinestitch.cli.demo import CLIPS, RESULTS
from kinestitch.edit import load_document
from kinestitch.files import read, write
from kinestitch.samples import sample
from kinestitch.testing import assert_motion_close, random_motion


@pytest.fixture
def edit(kinestitch, tmp_path):
    for name in ("walk", "kick"):
        write(sample(name, fps=20), tmp_path / f"{name}.bvh")
    assert kinestitch("stitch", "walk.bvh", "--replace", "20:40", "kick.bvh@10:40", "-o", "edit.otio").code == 0


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_plot_of_an_edit(kinestitch, edit, suffix):
    ran = kinestitch("plot", "edit.otio", "-o", f"out.{suffix}", "--joint", "RightUpLeg")
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == f"out.{suffix}: mixamorig:RightUpLeg, 77 frames\n"
    assert Path(f"out.{suffix}").stat().st_size > 5000


def test_plot_of_a_clip_with_its_cut(kinestitch, edit):
    for method in ("laplacian", "cut"):
        words = ("--replace", "20:40", "kick.bvh@10:40", "--method", method)
        assert kinestitch("stitch", "walk.bvh", *words, "-o", f"{method}.bvh").code == 0
    ran = kinestitch("plot", "laplacian.bvh", "--before", "cut.bvh", "--seam", 20, "--seam", 50, "-o", "out.svg")
    assert ran.code == 0
    assert "before" in Path("out.svg").read_text()


def test_plot_chooses_a_limb(kinestitch, edit):
    told = kinestitch("plot", "kick.bvh", "-o", "out.svg").out
    assert "UpLeg" in told or "Arm" in told


def test_filmstrip_tints_what_was_pasted(kinestitch, edit):
    words = ("--poses", 7, "--title", "A kick", "--view", "side")
    ran = kinestitch("filmstrip", "walk.bvh", "kick.bvh", "edit.otio", "-o", "out.svg", *words)
    assert (ran.code, ran.err) == (0, "")
    picture = Path("out.svg").read_text()
    assert "kick 10–39" in picture
    assert "A kick" in picture
    assert picture.count('id="pose ') == 3 * 7


@pytest.mark.parametrize("view", ["front", "45", "-30.5"])
def test_views_by_name_or_degrees(kinestitch, edit, view):
    assert kinestitch("filmstrip", "walk.bvh", "-o", "out.png", "--poses", 2, "--view", view).code == 0


def test_demo_writes_everything(tmp_path):
    words = [sys.executable, "-m", "kinestitch", "demo"]
    ran = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    folder = tmp_path / "kinestitch-demo"
    assert {path.name for path in folder.iterdir()} == {*CLIPS, *RESULTS}
    assert ran.stderr == ""
    assert all(name in ran.stdout for name in RESULTS)
    assert "solved in" in ran.stdout
    bvh, glb = read(folder / "walk_kick.bvh"), read(folder / "walk_kick.glb")
    assert_motion_close(glb, bvh, world=True, metres=1e-4)
    sources = load_document(folder / "walk_kick.otio").sources.values()
    assert {Path(source).parent for source in sources} == {folder}


def test_the_demo_says_how_to_do_it_by_hand(kinestitch):
    ran = kinestitch("demo", "some where")
    words = shlex.split(ran.out.splitlines()[-1])
    by_hand = kinestitch(*words[words.index("stitch") :])
    assert by_hand.code == 0
    assert_motion_close(read("some where/mine.bvh"), read("some where/walk_kick.bvh"), degrees=1e-3, metres=1e-5)


@pytest.mark.parametrize("known", [True, False])
def test_its_command_starts_what_was_started(kinestitch, monkeypatch, tmp_path, known):
    program = tmp_path / "kinestitch"
    program.touch()
    monkeypatch.setattr(shutil, "which", lambda name: "/somewhere/kinestitch" if known else None)
    for started, start in ((str(program), [str(program)]), ("x/__main__.py", [sys.executable, "-m", "kinestitch"])):
        monkeypatch.setattr(sys, "argv", [started, "demo"])
        words = shlex.split(kinestitch("demo", "here").out.splitlines()[-1])
        assert words[: words.index("stitch")] == (["kinestitch"] if known else start)


def test_the_demo_replaces_its_own_files_only(kinestitch, tmp_path):
    assert kinestitch("demo", "here").code == 0
    assert kinestitch("demo", "here").code == 0
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "walk.bvh").write_text("mine")
    assert "walk.bvh" in kinestitch("demo", "mine").error
    assert (tmp_path / "mine" / "walk.bvh").read_text() == "mine"


def test_a_row_is_called_as_its_file(kinestitch, monkeypatch):
    """Not as the take: files of several takes give their motion its name."""
    monkeypatch.setattr("kinestitch.files.read", lambda path, **_: random_motion(3, frames=5))
    ran = kinestitch("filmstrip", "pose.glb", "-o", "out.svg", "--poses", 1)
    assert (ran.code, ran.out) == (0, "out.svg: 1 row of up to 1 pose\n")
    drawn = Path("out.svg").read_text(encoding="utf-8")
    assert ">pose<" in drawn
    assert "random 3" not in drawn
    monkeypatch.setattr("kinestitch.files.read", lambda path, **_: random_motion(3, frames=1))
    assert kinestitch("plot", "pose.glb", "-o", "out.png").out.endswith(", 1 frame\n")
