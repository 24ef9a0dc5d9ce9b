"""``info`` and ``convert``."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kinestitch.files import read
from kinestitch.samples import sample
from kinestitch.testing import assert_motion_close


@pytest.fixture(autouse=True)
def walk(tmp_path):
    from kinestitch.files import write

    motion = sample("walk", fps=30)
    write(motion, tmp_path / "walk.bvh")
    return motion


def test_one_file_is_told_as_a_block(kinestitch, walk):
    ran = kinestitch("info", "walk.bvh")
    assert (ran.code, ran.err) == (0, "")
    told = dict(line.split(maxsplit=1) for line in ran.out.splitlines())
    assert told["file"].strip() == "walk.bvh"
    assert told["format"].strip() == "BVH"
    assert told["joints"].startswith(f"{walk.skeleton.joint_count}, root mixamorig:Hips")
    assert told["frames"].startswith(f"{walk.frames}, numbered 0 to {walk.frames - 1}")


def test_several_are_told_as_a_table(kinestitch, clip, walk):
    clip("other [x:y].bvh", frames=7)
    ran = kinestitch("info", "walk.bvh", "other [x:y].bvh")
    rows = ran.out.splitlines()
    assert len(rows) == 3
    assert rows[1].split()[:5] == ["walk.bvh", "BVH", str(walk.skeleton.joint_count), "30", str(walk.frames)]
    assert rows[2].startswith("other [x:y].bvh")


def test_json_for_programs(kinestitch, walk):
    told = json.loads(kinestitch("info", "--json", "walk.bvh").out)
    assert len(told) == 1
    facts = told[0]
    assert (facts["file"], facts["fps"], facts["frames"]) == ("walk.bvh", 30.0, walk.frames)
    assert facts["duration"] == pytest.approx(walk.duration)
    assert facts["joint_names"] == list(walk.skeleton.names)
    assert facts["hips"] == "mixamorig:Hips"
    assert 2.0 < facts["travel"] <= facts["path"] < 8.0
    assert 0.7 < facts["hip_height"] < 1.1
    assert facts["warnings"] == facts["takes"] == []


def test_oddities_are_told_with_the_file(kinestitch, tmp_path):
    path = tmp_path / "walk.bvh"
    path.write_bytes(path.read_bytes().replace(b"mixamorig:Neck\n", b"mixamorig:Hips\n"))
    assert "warning  " in kinestitch("info", "walk.bvh").out
    ran = kinestitch("info", "walk.bvh", "walk.bvh")
    assert ran.code == 0
    assert ran.err.startswith("warning: ")
    assert len(json.loads(kinestitch("info", "walk.bvh", "--json").out)[0]["warnings"]) == 1
    ran = kinestitch("stitch", "walk.bvh", "-o", "out.bvh")
    assert ran.err.count("\n") == 1
    assert ran.err.startswith("warning: ")
    assert "(walk.bvh)" in ran.err


def test_the_tree_of_joints(kinestitch, walk):
    told = kinestitch("info", "walk.bvh", "--joints").out
    assert all(name in told for name in walk.skeleton.names)


@pytest.mark.parametrize("suffix", [".bvh", ".fbx", ".glb"])
def test_convert_keeps_the_movement(kinestitch, walk, suffix):
    ran = kinestitch("convert", "walk.bvh", f"out{suffix}")
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == f"out{suffix}: {walk.frames} frames, 30 fps, {walk.duration:.2f} s, 33 joints\n"
    assert_motion_close(read(f"out{suffix}"), walk, world=True, metres=1e-4)


def test_convert_resamples(kinestitch, walk):
    assert kinestitch("convert", "walk.bvh", "out.bvh", "--fps", "60").code == 0
    out = read("out.bvh")
    assert out.fps == 60
    assert out.duration == pytest.approx(walk.duration)


@pytest.mark.parametrize("unit", ["inch", "0.0254"])
def test_convert_reads_in_a_unit(kinestitch, walk, unit):
    assert kinestitch("convert", "walk.bvh", "out.bvh", "--unit", unit).code == 0
    height = read("out.bvh").translations[0, 0, 1]
    assert height == pytest.approx(2.54 * walk.translations[0, 0, 1], rel=1e-4)


def test_convert_picks_a_take(kinestitch, walk):
    assert kinestitch("convert", "walk.bvh", "out.fbx").code == 0
    takes = json.loads(kinestitch("info", "out.fbx", "--json").out)[0]["takes"]
    assert len(takes) == 1
    assert kinestitch("convert", "out.fbx", "again.bvh", "--take", takes[0]).code == 0
    assert takes[0] in kinestitch("convert", "out.fbx", "again.bvh", "--take", "another").error


def test_convert_is_not_for_edits(kinestitch):
    assert kinestitch("stitch", "walk.bvh", "-o", "edit.otio").code == 0
    assert "kinestitch stitch" in kinestitch("convert", "edit.otio", "out.bvh").error
    assert not Path("out.bvh").exists()


def test_info_of_an_edit(kinestitch, clip, tmp_path):
    clip("walk.bvh", frames=60, seed=1)
    clip("kick.bvh", frames=40, seed=2)
    words = ("stitch", "walk.bvh", "--replace", "20:30", "kick.bvh@5:35", "--smooth", "0.2", "-o", "edit.otio")
    assert kinestitch(*words).code == 0
    (tmp_path / "kick.bvh").unlink()
    ran = kinestitch("info", "edit.otio")
    assert (ran.code, ran.err) == (0, "")
    for told in (
        *("80, numbered 0 to 79", "from 20: kick 5:35", "from 50: walk 30:60"),
        *("before 50: smoothing 0.2 s (λ = 1296)", "walk: 60 frames, 30 fps", "kick.bvh (not found)"),
    ):
        assert told in ran.out
    (facts,) = json.loads(kinestitch("info", "edit.otio", "--json").out)
    assert [part["clip"] for part in facts["segments"]] == ["walk", "kick", "walk"]
    assert [seam["frame"] for seam in facts["seams"]] == [20, 50]
    assert [source["found"] for source in facts["sources"]] == [True, False]
    assert not any(seam["automatic"] for seam in facts["seams"])


def test_info_of_an_edit_whose_seams_are_automatic(kinestitch, clip):
    clip("walk.bvh", frames=60, seed=1)
    assert kinestitch("stitch", "walk.bvh", "--delete", "20:30", "--auto", "-o", "edit.otio").code == 0
    assert "before 20: smoothing automatic" in kinestitch("info", "edit.otio").out
    (facts,) = json.loads(kinestitch("info", "edit.otio", "--json").out)
    assert facts["seams"] == [{"frame": 20, "smoothing": None, "stiffness": None, "automatic": True}]
