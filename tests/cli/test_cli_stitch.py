"""``stitch``: what a command line means."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from kinestitch.edit import DEFAULT_SEAM, FrameRange, Seam, load_document
from kinestitch.files import read, write
from kinestitch.samples import sample
from kinestitch.testing import assert_motion_close, random_motion


def segments(path) -> list[str]:
    return [str(segment) for segment in load_document(path).timeline.segments]


@pytest.fixture(autouse=True)
def clips(clip):
    clip("walk.bvh", frames=60, seed=1)
    clip("kick.bvh", frames=40, seed=2)
    clip("jump.bvh", frames=50, seed=3)


def test_replace_writes_the_motion_and_tells_each_seam(kinestitch):
    ran = kinestitch("stitch", "walk.bvh", "--replace", "20:30", "kick.bvh@5:35", "-o", "out.bvh")
    assert (ran.code, ran.err) == (0, "")
    assert read("out.bvh").frames == 80
    assert "walk 19 → kick 5" in ran.out
    assert "kick 34 → walk 30" in ran.out
    assert "out.bvh: 80 frames, 30 fps" in ran.out


@pytest.mark.parametrize("order", list(permutations(range(4))))
def test_edits_at_one_place_keep_the_order_of_the_command_line(kinestitch, order):
    edits = [
        ("--insert", "20", "kick.bvh@0:10"),
        ("--replace", "20:30", "jump.bvh@0:10"),
        ("--insert", "20", "jump.bvh@30:40"),
        ("--append", "kick.bvh@20:30"),
    ]
    shown = ["kick@0:10", "jump@0:10", "jump@30:40"]
    words = [word for index in order for word in edits[index]]
    assert kinestitch("stitch", *words, "walk.bvh", "-o", "edit.otio").code == 0
    pasted = [shown[index] for index in order if index != 3]
    assert segments("edit.otio") == ["walk@0:20", *pasted, "walk@30:60", "kick@20:30"]


def test_options_of_one_name_and_of_others_interleave(kinestitch):
    ran = kinestitch(
        *("stitch", "walk.bvh", "--append", "kick.bvh@0:5", "--delete", "40:50", "--insert", 10, "jump.bvh@1:2"),
        *("--append", "jump.bvh@0:5", "--insert", 10, "kick.bvh@1:2", "--delete", "0:5", "-o", "edit.otio"),
    )
    assert ran.code == 0
    assert segments("edit.otio") == [
        *("walk@5:10", "jump@1:2", "kick@1:2", "walk@10:40", "walk@50:60", "kick@0:5", "jump@0:5"),
    ]


@pytest.mark.parametrize(
    ("reference", "shown"),
    [("kick.bvh", "0:40"), ("kick.bvh@5:", "5:40"), ("kick.bvh@:7", "0:7"), ("kick.bvh@:", "0:40")],
)
def test_either_end_of_a_range_may_be_left_out(kinestitch, reference, shown):
    assert kinestitch("stitch", "walk.bvh", "--insert", 20, reference, "-o", "edit.otio").code == 0
    assert segments("edit.otio")[1] == f"kick@{shown}"


@pytest.mark.parametrize(
    "name", ["a kick.bvh", "kick@2.bvh", "kick@1:2.bvh", "tic:tac/kick [red].bvh", "-kick.bvh", "κλοτσιά.bvh"]
)
def test_names_may_hold_spaces_at_signs_colons_and_dashes(kinestitch, clip, name):
    clip(name, frames=40, seed=2)
    ran = kinestitch("stitch", "--append", f"{name}@3:9", "-o", "out.bvh", "--", "walk.bvh")
    assert (ran.code, ran.err) == (0, "")
    assert read("out.bvh").frames == 66
    ran = kinestitch("stitch", "-o", "edit.otio", "--", name)
    assert ran.code == 0
    assert kinestitch("stitch", "edit.otio", "-o", "again.bvh").code == 0
    assert_motion_close(read("again.bvh"), read(name), degrees=1e-4, metres=1e-6)


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (("--replace", "40:", "kick.bvh@5:9"), ["walk@0:40", "kick@5:9"]),
        (("--replace", ":40", "kick.bvh@5:9"), ["kick@5:9", "walk@40:60"]),
        (("--replace", ":", "kick.bvh@5:9"), ["kick@5:9"]),
        (("--delete", "40:"), ["walk@0:40"]),
        (("--delete", ":40"), ["walk@40:60"]),
    ],
)
def test_and_of_the_range_that_is_taken_out(kinestitch, words, shown):
    assert kinestitch("stitch", "walk.bvh", *words, "-o", "edit.otio").code == 0
    assert segments("edit.otio") == shown


def test_what_a_clip_goes_through_is_told(kinestitch, clip):
    fast = clip("fast.bvh", frames=121, fps=60.0, seed=4)
    skeleton = replace(fast.skeleton, offsets=fast.skeleton.offsets * 2)
    write(replace(fast, skeleton=skeleton, translations=fast.translations * 2), "big.bvh")
    ran = kinestitch("stitch", "walk.bvh", "--append", "fast.bvh", "--append", "big.bvh@0:9", "-o", "out.bvh")
    assert ran.code == 0
    assert ran.err.splitlines() == [
        "note: fast.bvh: 60 fps resampled to 30.",
        "note: big.bvh: 60 fps resampled to 30.",
        "note: big.bvh: scaled by 0.5 to the body of walk.bvh.",
    ]


def test_the_table_tells_each_seams_smoothing_time(kinestitch):
    words = ("stitch", "walk.bvh", "--append", "kick.bvh@5:", "-o", "out.bvh")
    assert "smooth s" in kinestitch(*words).out
    assert " 0.25 " in kinestitch(*words, "--smooth", "0.25").out
    assert " 0.5 " in kinestitch(*words, "--lambda", 15**4).out


def test_automatic_seams_are_told_and_kept_in_documents(kinestitch):
    for name in ("walk", "kick"):
        write(sample(name, fps=30.0), f"{name}.bvh")
    words = ("stitch", "walk.bvh", "--replace", "40:60", "kick.bvh@10:50", "--auto")
    ran = kinestitch(*words, "-o", "out.bvh", "--report", "seams.json")
    assert (ran.code, ran.err) == (0, "")
    for seam in json.loads(Path("seams.json").read_text())["seams"]:
        assert seam["automatic"] is True
        parts = seam["groups"]
        assert set(parts) == {"body", "left_arm", "left_leg", "right_arm", "right_leg"}
        assert seam["lambda"] == max(part["lambda"] for part in parts.values())
        assert seam["smoothing_s"] == pytest.approx(seam["lambda"] ** 0.25 / 30)
        times = [part["smoothing_s"] for part in parts.values()]
        assert f"{min(times):.2g}–{max(times):.2g}" in ran.out
    assert kinestitch(*words[:-1], "-o", "unsaid.bvh").code == 0  # automatic is what a seam is if nothing is said
    assert Path("out.bvh").read_bytes() == Path("unsaid.bvh").read_bytes()
    assert kinestitch(*words, "-o", "edit.otio").code == 0
    assert load_document("edit.otio").timeline.seams == (Seam(automatic=True),) * 2
    assert kinestitch("stitch", "edit.otio", "-o", "again.bvh").code == 0
    assert Path("out.bvh").read_bytes() == Path("again.bvh").read_bytes()
    assert kinestitch("stitch", "edit.otio", "--auto", "--snap", "0.1", "-o", "snapped.bvh").code == 0
    assert kinestitch("stitch", "edit.otio", "--smooth", "0.1", "-o", "told.otio").code == 0
    assert load_document("told.otio").timeline.seams == (Seam(smoothing=0.1),) * 2


def test_a_take_of_the_original(kinestitch):
    write(random_motion(7, frames=20), "two.glb")
    ran = kinestitch("stitch", "two.glb", "--take", "random 7", "--append", "walk.bvh", "-o", "out.glb")
    assert ran.code == 0, ran.err
    assert read("out.glb").frames == 80
    assert "'other'" in kinestitch("stitch", "two.glb", "--take", "other", "-o", "out.glb").error
    assert "no --take" in kinestitch("stitch", "two.glb", "--take", "random 7", "-o", "out.otio").error


def test_a_clip_of_another_rate_is_resampled_and_its_range_with_it(kinestitch, clip):
    clip("fast.bvh", frames=121, fps=60.0, seed=4)
    assert kinestitch("stitch", "walk.bvh", "--replace", "20:30", "fast.bvh@21:80", "-o", "edit.otio").code == 0
    document = load_document("edit.otio")
    assert document.timeline.fps == 30.0
    assert document.timeline.segments[1].range == FrameRange(11, 40)


def test_nothing_to_do_gives_the_clip_back(kinestitch):
    ran = kinestitch("stitch", "walk.bvh", "-o", "out.bvh")
    assert ran.code == 0
    assert_motion_close(read("out.bvh"), read("walk.bvh"), degrees=1e-4, metres=1e-6)


def test_a_clip_cut_and_put_back_is_unchanged(kinestitch):
    assert kinestitch("stitch", "walk.bvh", "--replace", "20:30", "walk.bvh@20:30", "-o", "out.bvh").code == 0
    assert_motion_close(read("out.bvh"), read("walk.bvh"), degrees=1e-4, metres=1e-6)


def test_a_document_gives_what_its_command_line_gave(kinestitch):
    words = ("stitch", "walk.bvh", "--replace", "20:30", "kick.bvh@5:35", "--smooth", "0.2")
    assert kinestitch(*words, "-o", "out.bvh").code == 0
    assert kinestitch(*words, "-o", "edit.otio").code == 0
    assert kinestitch("stitch", "edit.otio", "-o", "again.bvh").code == 0
    assert Path("out.bvh").read_bytes() == Path("again.bvh").read_bytes()


def test_a_document_finds_its_clips_beside_it(kinestitch, tmp_path, monkeypatch):
    assert kinestitch("stitch", "walk.bvh", "--append", "kick.bvh", "-o", "edit.otio").code == 0
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert kinestitch("stitch", tmp_path / "edit.otio", "-o", "out.bvh").code == 0


def test_a_document_can_be_edited_further(kinestitch):
    assert kinestitch("stitch", "walk.bvh", "--append", "kick.bvh@0:10", "--lambda", 7, "-o", "edit.otio").code == 0
    ran = kinestitch("stitch", "edit.otio", "--delete", "0:5", "--append", "./kick.bvh@20:30", "-o", "more.otio")
    assert ran.code == 0
    assert segments("more.otio") == ["walk@5:60", "kick@0:10", "kick@20:30"]
    assert load_document("more.otio").timeline.seams == (Seam(stiffness=7.0), DEFAULT_SEAM)


@pytest.mark.parametrize(
    ("words", "stiffness"),
    [
        (("--smooth", "0.1"), 81.0),
        (("--smooth", "0.2"), 1296.0),
        (("--lambda", "17.5"), 17.5),
        (("--lambda", 0), 0),
    ],
)
def test_smoothing_in_seconds_or_as_lambda(kinestitch, words, stiffness):
    ran = kinestitch("stitch", "walk.bvh", "--append", "kick.bvh@5:", *words, "--report", "r.json", "-o", "out.bvh")
    assert ran.code == 0
    told = json.loads(Path("r.json").read_text(encoding="utf-8"))
    assert told["seams"][0]["lambda"] == pytest.approx(stiffness)


def test_the_report_is_one_object_with_the_numbers_of_each_seam(kinestitch):
    kinestitch("stitch", "walk.bvh", "--replace", "20:30", "kick.bvh@5:35", "--report", "r.json", "-o", "out.bvh")
    told = json.loads(Path("r.json").read_text(encoding="utf-8"))
    assert (told["frames"], told["fps"], told["joints"]) == (80, 30.0, 4)
    assert told["solve_ms"] > 0
    assert [seam["frame"] for seam in told["seams"]] == [20, 50]
    wanted = {"frame", "lambda", "price", "deviation_mean_deg", "deviation_max_deg", "dynamics_kept"}
    for name in ("rotation_step_deg", "angular_velocity_step_deg_s", "root_step_m"):
        wanted |= {f"{name}_before", f"{name}_after"}
    for seam in told["seams"]:
        assert wanted <= seam.keys()
        assert seam["rotation_step_deg_after"] < seam["rotation_step_deg_before"]


def test_the_hard_cut_and_the_published_chart_can_be_asked_for(kinestitch):
    words = ("stitch", "walk.bvh", "--append", "kick.bvh@5:")
    assert kinestitch(*words, "--method", "cut", "-o", "cut.bvh").code == 0
    assert kinestitch(*words, "--chart", "principal", "-o", "principal.bvh").code == 0
    assert kinestitch(*words, "-o", "out.bvh").code == 0
    cut, principal, out = (read(f"{name}.bvh").rotations for name in ("cut", "principal", "out"))
    assert np.abs(cut - out).max() > 1e-3
    assert np.abs(principal - cut).max() > 1e-3


def test_a_file_used_several_times_is_read_once(kinestitch, monkeypatch, tmp_path):
    asked = []
    true_read = read

    def counting(path, **options):
        asked.append(os.path.realpath(path))
        return true_read(path, **options)

    monkeypatch.setattr("kinestitch.files.read", counting)
    (tmp_path / "link.bvh").symlink_to("kick.bvh")
    ran = kinestitch(
        *("stitch", "walk.bvh", "--append", "kick.bvh@0:5", "--append", "./kick.bvh@5:9", "--insert", 3, "link.bvh"),
        *("--insert", 5, tmp_path / "walk.bvh", "-o", "edit.otio"),
    )
    assert ran.code == 0
    assert len(asked) == len(set(asked)) == 2
    assert [clip.key for clip in load_document("edit.otio").timeline.clips] == ["walk", "kick"]


def test_two_files_of_one_name_keep_apart(kinestitch, clip):
    clip("other/kick.bvh", frames=30, seed=9)
    assert (
        kinestitch(
            "stitch", "walk.bvh", "--append", "kick.bvh@0:5", "--append", "other/kick.bvh@0:5", "-o", "e.otio"
        ).code
        == 0
    )
    assert segments("e.otio")[1:] == ["kick@0:5", "kick 2@0:5"]
    assert [os.path.relpath(path) for path in load_document("e.otio").sources.values()] == [
        *("walk.bvh", "kick.bvh", "other/kick.bvh"),
    ]


def test_an_existing_output_is_replaced(kinestitch, tmp_path):
    (tmp_path / "out.bvh").write_text("old")
    assert kinestitch("stitch", "walk.bvh", "-o", "out.bvh").code == 0
    assert read("out.bvh").frames == 60
    assert sorted(path.name for path in tmp_path.iterdir()) == ["jump.bvh", "kick.bvh", "out.bvh", "walk.bvh"]


def test_a_document_with_a_report_is_solved_too(kinestitch, tmp_path):
    ran = kinestitch("stitch", "walk.bvh", "--append", "kick.bvh", "-o", "e.otio", "--report", "r.json")
    assert ran.code == 0
    assert (tmp_path / "e.otio").exists()
    assert len(json.loads((tmp_path / "r.json").read_text())["seams"]) == 1
