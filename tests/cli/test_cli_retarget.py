"""The verbs that put a clip on another rig, and those that change its travel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.core.kinematics import world_pose
from kinestitch.files import read, write
from kinestitch.testing import assert_motion_close


@pytest.fixture
def clips(tmp_path):
    """A walk of the sample body, the same body under other names, and one with a joint that nobody knows."""
    walk = ks.sample("walk", fps=30)
    write(walk, tmp_path / "walk.bvh")
    bare = replace(walk.skeleton, names=tuple(name.removeprefix("mixamorig:") for name in walk.skeleton.names))
    longer = replace(bare, offsets=bare.offsets * 1.2)
    write(replace(walk, skeleton=longer, translations=walk.translations * 1.2), tmp_path / "tall.bvh")
    odd = replace(bare, names=tuple(name.replace("LeftForeArm", "Tentacle") for name in bare.names))
    write(replace(walk, skeleton=odd), tmp_path / "odd.bvh")
    return walk


def test_a_clip_on_another_rig(kinestitch, clips, tmp_path):
    ran = kinestitch("retarget", "walk.bvh", "--to", "tall.bvh", "-o", "out.bvh", "--save-mapping", "map.toml")
    assert ran.code == 0, ran.err
    assert "out.bvh: 101 frames, 30 fps, 33 joints" in ran.out
    assert "map.toml: 33 of 33 joints follow one" in ran.out
    assert ran.err == ""
    out, tall = read(tmp_path / "out.bvh"), read(tmp_path / "tall.bvh")
    assert_motion_close(out, tall, metres=1e-3, world=True)


def test_doubt_is_refused_and_a_mapping_mends_it(kinestitch, clips, tmp_path):
    refused = kinestitch("retarget", "walk.bvh", "--to", "odd.bvh", "-o", "out.bvh")
    assert "do not tell left_lower_arm, left_hand of the target" in refused.error
    saved = kinestitch("retarget", "walk.bvh", "--to", "odd.bvh", "--save-mapping", "map.toml")
    assert saved.code == 0
    assert "names do not tell left_lower_arm, left_hand of the target" in saved.out
    with (tmp_path / "map.toml").open("a", encoding="utf-8") as stream:
        stream.write('"Tentacle" = "mixamorig:LeftForeArm"\n')
    mended = kinestitch("retarget", "walk.bvh", "--to", "odd.bvh", "-o", "out.bvh", "--mapping", "map.toml")
    assert mended.code == 0, mended.err
    assert_motion_close(read(tmp_path / "out.bvh"), read(tmp_path / "odd.bvh"), metres=1e-3, world=True)


def test_joints_that_keep_their_rest_are_told(kinestitch, clips, tmp_path):
    (tmp_path / "map.toml").write_text('[joints]\n"Hips" = "mixamorig:Hips"\n', encoding="utf-8")
    ran = kinestitch(
        "retarget", "walk.bvh", "--to", "tall.bvh", "-o", "out.bvh", "--mapping", "map.toml", "--no-foot-ik"
    )
    assert ran.code == 0
    assert ran.err.startswith("warning: 32 of 33 joints keep their rest: Spine, Spine1, ")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--to", "tall.bvh"], "Expected an output, got none"),
        (["--to", "tall.bvh", "-o", "walk.bvh"], "got an input"),
        (["--to", "tall.bvh", "-o", "tall.bvh"], "got an input"),
        (["--to", "tall.bvh", "-o", "out.xyz"], "Expected an output that ends in"),
        (["--to", "tall.bvh", "--save-mapping", "map.txt"], r"ends in .toml, .json"),
        (["--to", "gone.bvh", "-o", "out.bvh"], "got nothing of this name"),
        (["--to", "cut.otio", "-o", "out.bvh"], "Expected a clip, got an edit"),
        (["--to", "tall.bvh", "-o", "out.bvh", "--mapping", "gone.toml"], "got nothing of this name"),
        (["-o", "out.bvh"], "Missing option '--to'"),
    ],
)
def test_what_is_refused(kinestitch, clips, words, told):
    assert told in kinestitch("retarget", "walk.bvh", *words).error


def test_travel_is_taken_out_given_to_a_root_and_given_back(kinestitch, clips, tmp_path):
    assert kinestitch("in-place", "walk.bvh", "-o", "held.bvh").code == 0
    held = read(tmp_path / "held.bvh")
    assert np.ptp(held.translations[:, 0, [0, 2]], axis=0).max() < 1e-6
    assert kinestitch("extract-root", "walk.bvh", "-o", "rooted.bvh", "--smooth", "0.5", "--name", "ground").code == 0
    rooted = read(tmp_path / "rooted.bvh")
    assert rooted.skeleton.names[0] == "ground"
    before = world_pose(read(tmp_path / "walk.bvh")).positions
    assert np.abs(world_pose(rooted).positions[:, 1:] - before).max() < 1e-5
    assert kinestitch("bake-root", "rooted.bvh", "-o", "back.bvh", "--remove").code == 0
    assert np.abs(world_pose(read(tmp_path / "back.bvh")).positions - before).max() < 1e-5


def test_mirror_twice_is_nothing(kinestitch, clips, tmp_path):
    assert kinestitch("mirror", "walk.bvh", "-o", "other.bvh").code == 0
    assert kinestitch("mirror", "other.bvh", "-o", "again.bvh").code == 0
    assert_motion_close(read(tmp_path / "again.bvh"), read(tmp_path / "walk.bvh"), degrees=1e-3, metres=1e-5)


@pytest.mark.parametrize("verb", ["mirror", "in-place", "extract-root", "bake-root", "loop"])
def test_each_verb_refuses_its_input_as_output(kinestitch, clips, verb):
    assert "got an input" in kinestitch(verb, "walk.bvh", "-o", "walk.bvh").error
    assert "Expected a clip, got an edit" in kinestitch(verb, "cut.otio", "-o", "out.bvh").error
    assert "Missing option" in kinestitch(verb, "walk.bvh").error


def test_another_rig_is_stitched_and_told(kinestitch, clips, tmp_path):
    kick = ks.sample("kick", fps=30)
    names = dict(zip(("mixamorig:Hips", "mixamorig:HeadTop_End"), ("pelvis", "crown"), strict=True))
    skeleton = replace(kick.skeleton, names=tuple(names.get(name, name) for name in kick.skeleton.names))
    write(replace(kick, skeleton=skeleton), tmp_path / "kick.bvh")
    ran = kinestitch("stitch", "walk.bvh", "--replace", "40:60", "kick.bvh@20:60", "-o", "out.bvh")
    assert ran.code == 0, ran.err
    told = "warning: Clip 'kick' is retargeted onto another Mixamo rig. 1 of 33 joints keep their rest"
    assert ran.err.count("retargeted") == 1
    assert told in ran.err
