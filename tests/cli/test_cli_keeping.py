"""Outputs in the input's format keep its character; a mesh that is left out is told in one line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from kinestitch.files import has_character, read, write
from kinestitch.files.glb import BINARY_CHUNK, parse_glb, serialise_glb
from kinestitch.files.gltf import list_takes
from kinestitch.samples import sample
from kinestitch.testing import assert_motion_close


@pytest.fixture(autouse=True)
def walk(tmp_path):
    """A walk as walk.glb, with a mesh of one triangle and a second animation."""
    motion = replace(sample("walk", fps=30), name="walking")
    path = tmp_path / "walk.glb"
    write(motion, path)
    container = parse_glb(path.read_bytes())
    document = json.loads(json.dumps(container.document))
    corners = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0] * 3, "max": [1] * 3}
    document["accessors"].append(corners)
    document["meshes"] = [{"primitives": [{"attributes": {"POSITION": len(document["accessors"]) - 1}}]}]
    document["nodes"].append({"name": "flesh", "mesh": 0})
    document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    still = {**document["animations"][0], "name": "walk"}  # the file's own name, to mislead
    still["channels"] = still["channels"][:1]
    document["animations"].append(still)
    path.write_bytes(b"".join(serialise_glb(document, [(BINARY_CHUNK, [container.binary])])))
    return motion


def test_convert_keeps_the_character(kinestitch):
    ran = kinestitch("convert", "walk.glb", "out.glb", "--fps", "60")
    assert (ran.err, ran.code) == ("", 0)
    assert has_character("out.glb")
    assert list_takes("out.glb") == ("walking", "walk")
    assert read("out.glb").fps == 60


def test_stitch_keeps_the_character_of_the_original(kinestitch):
    ran = kinestitch("stitch", "walk.glb", "--delete", "10:20", "-o", "out.glb")
    assert (ran.err, ran.code) == ("", 0)
    assert has_character("out.glb")
    out = read("out.glb")
    assert (out.name, out.frames) == ("walking", read("walk.glb").frames - 10)
    assert kinestitch("stitch", "walk.glb", "--delete", "10:20", "-o", "edit.otio").code == 0
    assert kinestitch("stitch", "edit.otio", "-o", "again.glb").code == 0
    assert_motion_close(read("again.glb"), out)


@pytest.mark.parametrize("verb", ["convert", "stitch"])
def test_skeleton_only(kinestitch, verb):
    words = ("convert", "walk.glb", "out.glb") if verb == "convert" else ("stitch", "walk.glb", "-o", "out.glb")
    ran = kinestitch(*words, "--skeleton-only")
    assert (ran.err, ran.code) == ("", 0)
    assert not has_character("out.glb")


@pytest.mark.parametrize("verb", ["convert", "stitch"])
def test_a_mesh_left_out_is_told_once(kinestitch, verb):
    words = ("convert", "walk.glb", "out.bvh") if verb == "convert" else ("stitch", "walk.glb", "-o", "out.bvh")
    ran = kinestitch(*words)
    assert ran.code == 0
    assert ran.err.startswith("warning: The mesh of walk.glb is left out: the output is BVH. ")
    assert ran.err.count("\n") == 1
    assert Path("out.bvh").exists()


def test_a_chosen_take_is_replaced(kinestitch):
    ran = kinestitch("convert", "walk.glb", "out.glb", "--take", "walk", "--fps", "10")
    assert (ran.err, ran.code) == ("", 0)
    assert read("out.glb").name == "walk"
    assert read("out.glb", take="walking").fps == 30
