"""Wrong input: one line that says what was expected, exit code 2, and no output file made or touched."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import pytest

from kinestitch.cli.failures import STOPPED
from kinestitch.core.atomic import replacing


@pytest.fixture(autouse=True)
def clips(clip, tmp_path):
    clip("walk.bvh", frames=60, seed=1)
    clip("kick.bvh", frames=40, seed=2)
    clip("five.bvh", frames=40, seed=2, joints=5)
    sound = (tmp_path / "kick.bvh").read_bytes()
    for name, data in {
        "empty.bvh": b"",
        "cut.bvh": sound[: len(sound) // 2],
        "head.bvh": sound[:40],
        "rubbish.bvh": bytes(range(256)) * 40,
        "zero.bvh": sound.replace(b"Frames: 40", b"Frames: 0"),
        "nan.bvh": sound[:-40] + b" nan" * 10 + b"\n",
        "empty.fbx": b"",
        "rubbish.fbx": bytes(range(256)) * 40,
        "head.fbx": b"Kaydara FBX Binary  \x00\x1a\x00\xe8\x1c\x00\x00" + b"\xff" * 60,
        "empty.glb": b"",
        "rubbish.glb": bytes(range(256)) * 40,
        "empty.otio": b"",
        "rubbish.otio": b"{" + bytes(range(256)) * 40,
        "list.otio": b"[1, 2, 3]",
        "notes.txt": b"hello",
    }.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "folder.bvh").mkdir()
    (tmp_path / "out.bvh").write_text("old")


def untouched(tmp_path) -> bool:
    made = {"out.otio", "out.glb", "r.json", "out.png"} & {path.name for path in tmp_path.iterdir()}
    stray = [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]
    return not made and not stray and (tmp_path / "out.bvh").read_text() == "old"


DAMAGED = [
    *("empty.bvh", "cut.bvh", "head.bvh", "rubbish.bvh", "zero.bvh", "nan.bvh", "folder.bvh", "none.bvh"),
    *("empty.fbx", "rubbish.fbx", "head.fbx", "empty.glb", "rubbish.glb", "notes.txt", "none", "no\nline.bvh"),
]


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_clips(kinestitch, tmp_path, name):
    for words in (
        ("stitch", name, "-o", "out.bvh", "--report", "r.json"),
        ("stitch", "walk.bvh", "--append", f"{name}@1:3", "-o", "out.bvh"),
        ("convert", name, "out.bvh"),
        ("plot", name, "-o", "out.png"),
        ("filmstrip", "walk.bvh", name, "-o", "out.png"),
        ("info", name),
    ):
        error = kinestitch(*words).error
        assert "xpected" in error, error
        assert re.search(r"got .*[.;] [A-Z]", error), error  # and what to try
        assert name.replace("\n", " ") in error, error
        assert "fault of our own" not in error, error
        assert untouched(tmp_path), words


@pytest.mark.parametrize("name", ["empty.otio", "rubbish.otio", "list.otio", "none.otio"])
def test_damaged_documents(kinestitch, tmp_path, name):
    for words in (("stitch", name, "-o", "out.bvh"), ("plot", name, "-o", "out.png"), ("info", name)):
        error = kinestitch(*words).error
        assert name in error
        assert untouched(tmp_path)


WRONG = [
    (("--replace", "20-30", "kick.bvh"), "'--replace': Expected a range START:STOP such as 60:110, got '20-30'"),
    (("--replace", "-5:30", "kick.bvh"), "got '-5:30'"),
    (("--replace", "30:20", "kick.bvh"), "within 0:60 of the timeline, got 30:20. Let its stop come after its start"),
    (("--replace", "20:20", "kick.bvh"), "got 20:20. Let its stop come after its start; the stop frame itself"),
    (("--replace", "20:61", "kick.bvh"), "within 0:60 of the timeline, got 20:61. Choose frames inside it"),
    (("--replace", "20:30", "kick.bvh@5:41"), "within 0:40 of clip 'kick', got 5:41. Choose frames inside it"),
    (("--replace", "20:30", "kick.bvh@9:9"), "within 0:40 of clip 'kick', got 9:9. Let its stop come after its start"),
    (("--delete", "70:"), "got 70:60. Choose frames inside it"),
    (("--append", "kick.bvh@-5:"), "START:STOP behind kick.bvh@, such as 20:75, got '-5:'"),
    (("--append", "kick.bvh@3"), "got '3'"),
    (("--append", "none.bvh@a:b"), "got 'a:b'"),
    (("--append", "kick.bvh@1:2@3:4"), "got '1:2@3:4'"),
    (("--append", "none@2.bvh"), "none@2.bvh"),
    (("--delete", ":"), "at least one frame"),
    (("--replace", "20:30", "@1:2"), "PATH@START:STOP"),
    (("--replace", "20:30"), "got the option '-o'"),
    (("--append", "--delete", "1:2"), "got the option '--delete'"),
    (("--insert", "61", "kick.bvh"), "from 0 to 60"),
    (("--insert", "-1", "kick.bvh"), "got -1"),
    (("--insert", "2.5", "kick.bvh"), "'2.5'"),
    (("--delete", "0:60"), "at least one frame"),
    (("--delete", "10:30", "--replace", "20:40", "kick.bvh"), "separate frames"),
    (("--delete", "10:30", "--insert", "20", "kick.bvh"), "separate frames"),
    (("--append", "five.bvh"), "Skeletons differ"),
    (("--lambda", "-1"), "'--lambda': Expected a number ≥ 0, got '-1'"),
    (("--lambda", "nan"), "got 'nan'"),
    (("--lambda", "inf"), "got 'inf'"),
    (("--lambda", "much"), "got 'much'"),
    (("--smooth", "-0.1"), "'--smooth': Expected a number ≥ 0, got '-0.1'"),
    (("--smooth", "1e200", "--append", "kick.bvh"), "smoothing time"),
    (("--lambda", "1e20", "--append", "kick.bvh"), "λ from 0 to 1e+12, got 1e+20"),
    (("--smooth", "0.1", "--lambda", "1"), "got both"),
    (("--auto", "--smooth", "0.1"), "Expected --auto or --smooth, got both"),
    (("--lambda", "0", "--auto"), "Expected --auto or --lambda, got both"),
    (("--chart", "square"), "'square'"),
    (("--colour",), "No such option"),
    (("--appent", "kick.bvh"), "--append"),
    (("kick.bvh",), "unexpected extra argument"),
]


@pytest.mark.parametrize(("words", "told"), WRONG)
def test_wrong_edits_and_settings(kinestitch, tmp_path, words, told):
    error = kinestitch("stitch", "walk.bvh", *words, "-o", "out.bvh", "--report", "r.json").error
    assert told in error
    assert untouched(tmp_path)


OUTPUTS = [
    ("out.xyz", "ends in .bvh"),
    ("out", "got no suffix."),
    ("missing/out.bvh", "existing folder"),
    ("folder.bvh", "got a folder"),
    ("walk.bvh", "got an input"),
    ("./walk.bvh", "got an input"),
    ("link.bvh", "got an input"),
    ("hard.bvh", "got an input"),
    ("linked/walk.bvh", "got an input"),
    ("kick.bvh", "got an input"),
]


@pytest.mark.parametrize(("output", "told"), OUTPUTS)
def test_outputs_that_cannot_be(kinestitch, tmp_path, output, told):
    (tmp_path / "link.bvh").symlink_to("walk.bvh")
    (tmp_path / "linked").symlink_to(tmp_path, target_is_directory=True)
    os.link(tmp_path / "walk.bvh", tmp_path / "hard.bvh")
    before = (tmp_path / "walk.bvh").read_bytes()
    assert told in kinestitch("stitch", "walk.bvh", "--append", "kick.bvh", "-o", output).error
    assert (tmp_path / "walk.bvh").read_bytes() == before
    assert untouched(tmp_path)


@pytest.mark.parametrize("report", ["walk.bvh", "kick.bvh", "out.bvh", "missing/r.json", "folder.bvh", "/dev/null"])
def test_reports_that_cannot_be(kinestitch, tmp_path, report):
    words = ("stitch", "walk.bvh", "--append", "kick.bvh", "-o", "out.bvh", "--report", report)
    assert report in kinestitch(*words).error
    assert untouched(tmp_path)


def test_a_document_and_its_sources_are_inputs(kinestitch, tmp_path):
    assert kinestitch("stitch", "walk.bvh", "--append", "kick.bvh", "-o", "edit.otio").code == 0
    for output in ("edit.otio", "kick.bvh"):
        assert "got an input" in kinestitch("stitch", "edit.otio", "-o", output).error
    for words in (("plot", "edit.otio", "-o", "edit.otio"), ("filmstrip", "walk.bvh", "-o", "walk.bvh")):
        assert "ends in .png" in kinestitch(*words).error
    assert "got an input" in kinestitch("convert", "walk.bvh", "walk.bvh").error


def test_a_document_whose_clip_is_gone_or_another(kinestitch, clip, tmp_path):
    assert kinestitch("stitch", "walk.bvh", "--append", "kick.bvh", "-o", "edit.otio").code == 0
    clip("kick.bvh", frames=41)
    assert "Expected 40 frames at 30 fps in clip 'kick'" in kinestitch("stitch", "edit.otio", "-o", "out.bvh").error
    clip("kick.bvh", frames=40, fps=60)
    assert "got 40 at 60 fps" in kinestitch("stitch", "edit.otio", "-o", "out.bvh").error
    (tmp_path / "kick.bvh").unlink()
    assert "kick.bvh" in kinestitch("stitch", "edit.otio", "-o", "out.bvh").error
    assert untouched(tmp_path)


def test_the_original_takes_no_range(kinestitch, tmp_path):
    for name in ("walk.bvh@20:40", "walk.bvh@20"):
        error = kinestitch("stitch", name, "-o", "out.bvh").error
        assert "Expected ORIGINAL without a range" in error
        assert name in error
    assert untouched(tmp_path)


def test_settings_that_a_document_does_not_hold(kinestitch):
    assert "--method" in kinestitch("stitch", "walk.bvh", "--method", "cut", "-o", "new.otio").error


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("convert", "walk.bvh", "out.bvh", "--fps", "0"), "fps > 0"),
        (("convert", "walk.bvh", "out.bvh", "--fps", "nan"), "fps > 0"),
        (("convert", "walk.bvh", "out.bvh", "--fps", "many"), "'many'"),
        (("convert", "walk.bvh", "out.bvh", "--fps", "1e15"), "xpected"),
        (("convert", "walk.bvh", "out.bvh", "--unit", "parsec"), "'parsec'"),
        (("convert", "out.glb", "out.bvh", "--unit", "cm"), "an option of glTF (take), got"),
        (("convert", "walk.bvh", "out.bvh", "--unit", "-1"), "unit > 0"),
        (("convert", "walk.bvh", "out.bvh", "--take", "one"), "'take'"),
        (("convert", "walk.bvh"), "Missing argument 'OUT'"),
        (("plot", "walk.bvh", "-o", "out.png", "--joint", "Tail"), "got 'Tail'"),
        (("plot", "walk.bvh", "-o", "out.png", "--seam", "60"), "from 1 to 59"),
        (("plot", "walk.bvh", "-o", "out.png", "--before", "kick.bvh"), "60 frames"),
        (("plot", "walk.bvh", "-o", "out.gif"), "ends in .png"),
        (("filmstrip", "walk.bvh", "-o", "out.png", "--poses", "0"), "0"),
        (("filmstrip", "walk.bvh", "-o", "out.png", "--view", "below"), "'below'"),
        (("filmstrip", "-o", "out.png"), "Missing argument"),
        (("sew",), "No such command 'sew'"),
        (("completion", "cmd"), "'cmd'"),
        (("demo", "walk.bvh"), "got a file"),
    ],
)
def test_other_verbs(kinestitch, tmp_path, words, told):
    ran = kinestitch(*words)
    assert ran.code == 2
    assert told in ran.err
    assert ran.err.count("\n") == 1
    assert untouched(tmp_path)


@pytest.mark.parametrize("words", [(), ("info",), ("stitch",)])
def test_without_arguments_the_help_is_shown(kinestitch, words):
    ran = kinestitch(*words)
    assert "Usage: kinestitch" in ran.out + ran.err
    assert ran.code == 2 or not ran.err  # click before 8.2 takes it for a question, not a mistake


def test_info_goes_on_after_a_damaged_file(kinestitch):
    ran = kinestitch("info", "walk.bvh", "empty.bvh", "kick.bvh")
    assert ran.code == 2
    assert ran.err.count("\n") == 1
    assert "walk.bvh" in ran.out
    assert "kick.bvh" in ran.out


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        (MemoryError(), "enough memory"),
        (PermissionError(13, "Permission denied", "walk.bvh"), "no permission"),
        (OSError(5, "Input/output error", "walk.bvh"), "Input/output error. (walk.bvh)"),
        (RuntimeError("two\nlines"), "fault of our own, got RuntimeError: two lines"),
        (RecursionError("deep"), "RecursionError"),
    ],
)
def test_faults_of_the_machine_are_one_line(kinestitch, monkeypatch, fault, told):
    def failing(path: str) -> None:
        raise fault

    monkeypatch.setattr("kinestitch.cli.info.clip_facts", failing)
    assert told in kinestitch("info", "walk.bvh").error


def test_stopping_is_130(kinestitch, monkeypatch):
    def stopping(path: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("kinestitch.cli.info.clip_facts", stopping)
    ran = kinestitch("info", "walk.bvh")
    assert (ran.code, ran.err) == (STOPPED, "error: Stopped before the end.\n")


def test_a_traceback_only_on_request(kinestitch, monkeypatch):
    assert "Traceback" not in kinestitch("info", "empty.bvh").error
    monkeypatch.setenv("KINESTITCH_TRACEBACK", "1")
    ran = kinestitch("info", "empty.bvh")
    assert ran.code == 2
    assert "Traceback" in ran.err
    assert ran.err.splitlines()[-1].startswith("error: ")


def test_a_full_disk_leaves_the_old_file(kinestitch, monkeypatch, tmp_path):
    def failing(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device", "out.bvh")

    monkeypatch.setattr("kinestitch.files.write", failing)
    error = kinestitch("stitch", "walk.bvh", "-o", "out.bvh", "--report", "r.json").error
    assert "No space left" in error
    assert untouched(tmp_path)


def test_a_file_that_grows_too_large_is_named(kinestitch, monkeypatch, tmp_path):
    def failing(*_: object, **__: object) -> None:
        with replacing("out.bvh"):
            raise OSError(27, "File too large")

    monkeypatch.setattr("kinestitch.files.write", failing)
    error = kinestitch("stitch", "walk.bvh", "-o", "out.bvh", "--report", "r.json").error
    assert error.endswith("got: File too large. Choose another output path. (out.bvh)")
    assert untouched(tmp_path)


def test_a_reader_that_leaves_early_is_no_error(tmp_path):
    words = [sys.executable, "-m", "kinestitch", "info", "walk.bvh", "--joints"]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert b"Traceback" not in process.stderr.read()


def test_the_clips_of_another_programs_document_are_inputs_too(kinestitch, tmp_path):
    import opentimelineio as otio

    line = otio.schema.Timeline("foreign")
    track = otio.schema.Track("motion", kind=otio.schema.TrackKind.Video)
    line.tracks.append(track)
    for name in ("walk", "kick"):
        track.append(otio.schema.Clip(name, otio.schema.ExternalReference(target_url=f"{name}.bvh")))
    otio.adapters.write_to_file(line, str(tmp_path / "foreign.otio"))
    assert kinestitch("stitch", "foreign.otio", "-o", "new.bvh").code == 0
    before = (tmp_path / "kick.bvh").read_bytes()
    assert "got an input" in kinestitch("stitch", "foreign.otio", "-o", "kick.bvh").error
    assert "got an input" in kinestitch("stitch", "foreign.otio", "-o", "out.bvh", "--report", "kick.bvh").error
    assert (tmp_path / "kick.bvh").read_bytes() == before
