"""``stitch --pin``, ``--waypoint`` and ``--return``, and what documents and ``info`` make of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.edit import load_document
from kinestitch.files import read, write
from kinestitch.samples import sample


@pytest.fixture(autouse=True)
def clips(tmp_path):
    for name in ("walk", "kick"):
        write(sample(name, fps=30), tmp_path / f"{name}.bvh")


def joint(motion, frame, ending):
    index = next(k for k, name in enumerate(motion.skeleton.names) if name.endswith(ending))
    return world_pose(motion).positions[frame, index]


def stitched(kinestitch, *words, err=""):
    ran = kinestitch("stitch", "walk.bvh", *words, "-o", "out.bvh")
    assert (ran.code, ran.err) == (0, err)
    return read("out.bvh")


def test_pins_of_every_kind(kinestitch):
    pins = ("--pin", "root@60=0.4,0,2.5", "--pin", "heading@90=30", "--pin", "LeftHand@40=0.3,1.3,1.95")
    motion = stitched(kinestitch, *pins, "--pin", "RightArm@70=0,0,0.6,0.8", "--waypoint", "50=0.3,2.1:3")
    assert joint(motion, 60, "Hips")[[0, 2]] == pytest.approx([0.4, 2.5], abs=1e-5)
    assert joint(motion, 40, "LeftHand") == pytest.approx([0.3, 1.3, 1.95], abs=1e-5)


def test_frames_are_those_of_the_result(kinestitch):
    motion = stitched(kinestitch, "--insert", "20", "kick.bvh@15:56", "--pin", "root@130=1,0,3")
    assert motion.frames == 142
    assert joint(motion, 130, "Hips")[[0, 2]] == pytest.approx([1.0, 3.0], abs=1e-5)
    told = kinestitch("stitch", "walk.bvh", "--pin", "root@130=1,0,3", "-o", "out.bvh").error
    assert "result's frames 0 to 100, got root@130=1,0,3" in told


def test_the_way_back(kinestitch):
    motion = stitched(kinestitch, "--insert", "40", "kick.bvh@15:56", "--return", "1.0")
    own = read("walk.bvh")
    assert np.abs(motion.translations[-20:] - own.translations[-20:]).max() < 1e-6
    assert (
        "at most 2 s"
        in kinestitch("stitch", "walk.bvh", "--insert", "40", "kick.bvh", "--return", "9", "-o", "o.bvh").error
    )
    assert "a clip as it was" in kinestitch("stitch", "walk.bvh", "--return", "1", "-o", "o.bvh").error


def test_a_document_holds_pins(kinestitch):
    words = ("--replace", "42:65", "kick.bvh@15:56", "--pin", "LeftHand@100=0.3,1.3,1.95:2", "--return", "0.5")
    ran = kinestitch("stitch", "walk.bvh", *words, "-o", "edit.otio")
    assert ran.code == 0
    assert ran.err == "note: whether pins can be met, and what they do to the steps, is told when the edit is solved.\n"
    pins = load_document("edit.otio").timeline.pins
    assert [str(pin) for pin in pins] == ["return@98", "LeftHand@100=0.3,1.3,1.95:2"]
    told = kinestitch("info", "edit.otio").out
    assert "return@98: from there on walk is where it was before the edit, after a way back of 0.5 s" in told
    assert "LeftHand@100=0.3,1.3,1.95:2" in told
    facts = json.loads(kinestitch("info", "edit.otio", "--json").out)[0]
    assert facts["pins"] == [str(pin) for pin in pins]
    assert facts["returns"] == [{"frame": 98, "clip": "walk", "seconds": 0.5}]
    assert kinestitch("stitch", "edit.otio", "--waypoint", "20=0.1,0.8", "-o", "more.bvh").code == 0
    assert joint(read("more.bvh"), 20, "Hips")[[0, 2]] == pytest.approx([0.1, 0.8], abs=1e-5)


def test_snapping_moves_a_documents_pins_with_their_frames(kinestitch):
    edit = ("--replace", "42:65", "kick.bvh@15:56", "--pin", "heading@100=5")
    assert kinestitch("stitch", "walk.bvh", *edit, "-o", "edit.otio").code == 0
    assert kinestitch("stitch", "edit.otio", "--snap", "0.2", "-o", "snapped.otio").code == 0
    before, after = (load_document(path).timeline for path in ("edit.otio", "snapped.otio"))
    assert before.segments != after.segments
    assert before.segment_at(before.pins[0].frame) == after.segment_at(after.pins[0].frame)


def test_feet_stand_on_a_bent_path(kinestitch):
    def slide(*words):
        stitched(kinestitch, "--pin", "heading@100=60", *words, "--report", "r.json")
        return json.loads(Path("r.json").read_text(encoding="utf-8"))["feet"]["slide_in_contact_m_s_after"]

    assert slide("--foot-lock") < 0.2 * slide("--no-foot-lock")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--pin", "root@10"), "Expected a pin such as root@120=1.2,0,3.4"),
        (("--pin", "root@10=1,2"), "3 numbers for the pin root on frame 10, got 2"),
        (("--pin", "Tail@10=1,2,3"), "name of a joint for Tail@10=1,2,3, got 'Tail'"),
        (("--pin", "LeftHand@10=1,2,3:-1"), "weight > 0"),
        (("--pin", "LeftHand@10=0,9,0"), "m from 'mixamorig:LeftArm' for LeftHand@10=0,9,0"),
        (("--waypoint", "ten=1,2"), "Expected a waypoint FRAME=X,Z"),
        (("--waypoint", "3=5,5"), "Use a root pin"),
        (("--waypoint", "9=0,1", "--pin", "root@9=0,0,1"), "one pin for the place in frame 9"),
        (("--return", "-1"), "Expected a number ≥ 0"),
        (("--return", "0", "--append", "walk.bvh"), "smoothing time > 0"),
    ],
)
def test_refusals_are_one_line(kinestitch, words, told):
    assert told in kinestitch("stitch", "walk.bvh", *words, "-o", "out.bvh").error
    assert not Path("out.bvh").exists()


def test_an_unknown_joint_is_told_before_a_document_is_saved(kinestitch):
    assert "'Tail'" in kinestitch("stitch", "walk.bvh", "--pin", "Tail@10=1,2,3", "-o", "edit.otio").error
    assert not Path("edit.otio").exists()


def test_a_pin_behind_the_return_is_told_when_an_edit_is_saved_and_when_it_is_solved(kinestitch):
    words = ("--insert", "40", "kick.bvh@15:56", "--return", "1", "--pin", "heading@130=40")
    saved = kinestitch("stitch", "walk.bvh", *words, "-o", "edit.otio")
    told = "warning: return@111 leads back to the original path, and heading@130=40 behind it away from it again."
    assert saved.err.startswith(told)
    assert saved.err.count("warning:") == 1
    for ran in (
        kinestitch("stitch", "walk.bvh", *words, "-o", "out.bvh"),
        kinestitch("stitch", "edit.otio", "-o", "two.bvh"),
        kinestitch("stitch", "walk.bvh", *words, "-o", "more.otio", "--report", "r.json"),
    ):
        assert ran.code == 0
        assert ran.err.count(told) == 1
        assert "note:" not in ran.err


def test_a_root_pin_far_away_is_a_warning(kinestitch):
    ran = kinestitch("stitch", "walk.bvh", "--pin", "root@60=900,-5,3", "-o", "out.bvh")
    assert ran.code == 0
    assert [line.split(" ")[:3] for line in ran.err.splitlines()] == [
        ["warning:", "The", "way"],
        ["warning:", "root@60=900,-5,3", "sinks"],
    ]


def test_long_steps_are_a_warning(kinestitch):
    ran = kinestitch("stitch", "walk.bvh", "--waypoint", "100=0,6", "-o", "out.bvh")
    assert ran.code == 0
    assert ran.err.startswith("warning: Steps before waypoint@100=0,6 become 1.")
