"""``--preset``: one line says what is set; a mesh that is left out is told."""

from __future__ import annotations

import pytest

from kinestitch.cli.keeping import preset_option
from kinestitch.files import read, write
from kinestitch.files.fbx import PRESETS
from kinestitch.samples import sample


@pytest.fixture(autouse=True)
def walk(tmp_path):
    write(sample("walk"), tmp_path / "walk.fbx")


def test_the_choices_are_the_presets():
    @preset_option
    def verb():
        pass

    assert list(verb.__click_params__[0].type.choices) == list(PRESETS)


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_convert_says_what_it_set(kinestitch, preset):
    ran = kinestitch("convert", "walk.fbx", "out.fbx", "--preset", preset)
    assert ran.code == 0
    assert ran.err.splitlines() == [f"preset: {preset}: {PRESETS[preset].says}."]
    assert read("out.fbx").frames == read("walk.fbx").frames


def test_stitch_writes_presets_too(kinestitch):
    ran = kinestitch("stitch", "walk.fbx", "--delete", "10:20", "-o", "out.fbx", "--preset", "unreal")
    assert ran.code == 0
    assert "Z up" in ran.err
    assert read("out.fbx").skeleton.names[0] == "root"


@pytest.mark.parametrize("words", [["convert", "walk.fbx", "out.bvh"], ["stitch", "walk.fbx", "-o", "out.otio"]])
def test_a_preset_of_no_use_is_refused(kinestitch, words):
    ran = kinestitch(*words, "--preset", "unity")
    assert ran.code != 0
    assert "preset" in ran.err


def test_a_mesh_left_out_is_told(kinestitch, tmp_path):
    (tmp_path / "text.fbx").write_text(TEXT)
    ran = kinestitch("convert", "text.fbx", "out.fbx", "--preset", "maya")
    assert ran.code == 0
    assert [line.split(":")[0] for line in ran.err.splitlines()] == ["preset", "warning"]
    assert "mesh" in ran.err


TEXT = """; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXVersion: 7400
}
Objects:  {
	Geometry: 3, "Geometry::", "Mesh" {
		Vertices: *3 {
			a: 0,0,0
		}
	}
	Model: 1, "Model::Hips", "LimbNode" {
	}
	Model: 2, "Model::Spine", "LimbNode" {
	}
}
Connections:  {
	C: "OO",1,0
	C: "OO",2,1
}
"""
