"""Damaged BVH files: one line that says what was expected, what was found and where; nothing else ever comes out."""

import re
import time
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.errors import FormatError, KinestitchError
from kinestitch.files.bvh import read_bvh, write_bvh
from kinestitch.testing import check_motion, random_motion

ARM = """HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Arm
  {
    OFFSET 10 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 5 0 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
1 2 3 10 20 30 40 50 60
4 5 6 11 21 31 41 51 61
"""


def second_root(text):
    return text.replace("MOTION", "ROOT Prop\n{\n OFFSET 0 0 0\n CHANNELS 0\n}\nMOTION")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: "", "Line 1: expected HIERARCHY, got an empty file"),
        (lambda t: " \n\n", "Line 1: expected HIERARCHY, got blank lines"),
        (lambda t: "Kaydara FBX Binary", "Line 1: expected HIERARCHY, got 'Kaydara'"),
        (lambda t: t.replace("MOTION", "MOTIO"), "Expected a line MOTION after the hierarchy, got the end"),
        (lambda t: t[: t.index("MOTION")], "Expected a line MOTION after the hierarchy, got the end"),
        (lambda t: t.replace("30 40", "30"), "Line 19: expected 9 channel values, got 8."),
        (lambda t: t.replace("31 41", "31 0 41"), "Line 20: expected 9 channel values, got 10."),
        (lambda t: t.replace("41 51", "41 nan"), "Line 20: expected a number for Arm Xrotation, got 'nan'."),
        (lambda t: t.replace("41 51", "41 -inf"), "Line 20: expected a number for Arm Xrotation, got '-inf'."),
        (lambda t: t.replace("41 51", "41 1e999"), "Line 20: expected a number for Arm Xrotation, got '1e999'."),
        (lambda t: t.replace("41 51", "41 5,1"), "Line 20: expected a number for Arm Xrotation, got '5,1'."),
        (lambda t: t.replace("4 5 6", "4 1e300 6"), "positions below 1e+12, got 1e+300"),
        (lambda t: t.replace("Frames: 2", "Frames: 3"), "Line 21: expected 3 frames as the file declares, got 2."),
        (
            lambda t: t.replace("Frames: 2", "Frames: 99999999999"),
            "Expected the 99999999999 frames that the file declares",
        ),
        (lambda t: t.replace("Frames: 2", "Frames: 0"), "Line 17: expected at least one frame, got 0."),
        (lambda t: t.replace("Frames: 2", "Frames: two"), "Line 17: expected a number of frames, got 'two'."),
        (lambda t: t.replace("Frames: 2", "Frames: -2"), "Line 17: expected a number of frames, got '-2'."),
        (
            lambda t: t.replace("Frames: 2\n", ""),
            "Line 17: expected Frames: and a number, got 'Frame Time: 0.0333333'.",
        ),
        (lambda t: t.replace("0.0333333", "0"), "Line 18: expected a frame time > 0 in seconds, got '0'."),
        (lambda t: t.replace("0.0333333", "-1"), "Line 18: expected a frame time > 0 in seconds, got '-1'."),
        (lambda t: t.replace("0.0333333", "nan"), "Line 18: expected a frame time > 0 in seconds, got 'nan'."),
        (
            lambda t: t.replace("OFFSET 10 0 0", "OFFSET 10 0"),
            "Line 8: expected three numbers after OFFSET, got '10 0'.",
        ),
        (lambda t: t.replace("OFFSET 10 0 0", "OFFSET 10 nan 0"), "Line 8: expected a finite OFFSET, got '10 nan 0'."),
        (lambda t: t.replace("CHANNELS 3", "CHANNELS 4"), "Line 9: expected 4 channel names, got 3."),
        (
            lambda t: t.replace("CHANNELS 3", "CHANNELS"),
            "Line 9: expected the number of channels after CHANNELS, got 'Zrotation'.",
        ),
        (
            lambda t: t.replace("3 Zrot", "3 Wrot"),
            "Line 9: expected a channel like Xposition or Zrotation, got 'Wrotation'.",
        ),
        (
            lambda t: t.replace("6 Xpos", "6 Ypos"),
            "Line 5: expected each position channel once in a joint, got Yposition twice.",
        ),
        (lambda t: t.replace("JOINT Arm", "JOINT"), "Line 6: expected a name after JOINT, got none."),
        (lambda t: t.replace("  }\n}\n", "}\n"), "expected a closing '}' for every joint, got 1 left open."),
        (
            lambda t: t.replace("}\nMOTION", "}\n}\nMOTION"),
            "Line 16: expected ROOT or MOTION, got '}' that closes nothing.",
        ),
        (second_root, "Line 16: expected one ROOT, got a second one, 'Prop'."),
        (lambda t: t.replace("ROOT Hips", "JOINT Hips"), "Line 2: expected JOINT inside a ROOT or JOINT"),
        (lambda t: re.sub(r"CHANNELS.*", "", t), "expected at least one joint with channels, got none."),
        (lambda t: "HIERARCHY\nMOTION\nFrames: 1\nFrame Time: 1\n", "Line 1: expected ROOT and the name of a joint"),
        (
            lambda t: t.replace("End Site", "Ende"),
            "Line 10: expected OFFSET, CHANNELS, JOINT, End Site or '}', got 'Ende'.",
        ),
    ],
)
def test_what_is_said(tmp_path, change, message):
    path = tmp_path / "run.bvh"
    path.write_text(change(ARM))
    with pytest.raises(FormatError) as caught:
        read_bvh(path)
    text = str(caught.value)
    assert message in text
    assert text.endswith(f"({path})")
    assert "\n" not in text


def attempt(path, data):
    """Read damaged bytes: a sound motion or a KinestitchError, and soon."""
    path.write_bytes(data)
    begin = time.perf_counter()
    message = ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            check_motion(read_bvh(path))
            result = "read"
        except KinestitchError as error:
            result = "refused"
            message = str(error)
    assert "\n" not in message
    assert time.perf_counter() - begin < 5
    return result


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    path = tmp_path_factory.mktemp("damaged") / "clip.bvh"
    write_bvh(random_motion(3, joints=5, frames=12), path)
    return path, path.read_bytes()


def test_cut_off_anywhere(clip):
    path, data = clip
    last_row = data.rstrip().rindex(b"\n")
    for length in range(0, len(data), 7):
        result = attempt(path, data[:length])
        assert result == "refused" or length > last_row, length


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 255), st.integers(1, 4))
def test_changed_bytes(clip, place, value, count):
    path, data = clip
    damaged = bytearray(data)
    for k in range(count):
        damaged[(place * (k + 1)) % len(data)] = (value + 37 * k) % 256
    attempt(path, bytes(damaged))


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=400))
def test_rubbish(clip, data):
    path, _ = clip
    assert attempt(path, data) == "refused"
    attempt(path, b"HIERARCHY\n" + data)
    attempt(path, ARM.encode()[: ARM.index("1 2 3 10")] + data)


def test_long_lines_and_deep_trees_are_no_trap(clip):
    path, _ = clip
    assert attempt(path, b"HIERARCHY" + b" " * 3_000_000) == "refused"
    assert attempt(path, b"HIERARCHY" + b"\n" * 3_000_000) == "refused"
    assert attempt(path, ARM.encode().replace(b"40 50", b"4" * 3_000_000)) == "refused"
    assert attempt(path, ARM.encode().replace(b"MOTION\n", b"MOTION\n" + b" " * 1_000_000)) == "read"
    deep = b"".join(b"JOINT j%d\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n" % k for k in range(3000))
    text = b"HIERARCHY\n" + deep.replace(b"JOINT", b"ROOT", 1) + b"}\n" * 3000
    row = b" ".join([b"1"] * 3000)
    assert attempt(path, text + b"MOTION\nFrames: 1\nFrame Time: 1\n" + row) == "read"


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_bvh(tmp_path / "none.bvh")


def test_no_warning_of_numpy_on_extreme_values(tmp_path):
    path = tmp_path / "run.bvh"
    path.write_text(ARM.replace("40 50 60", "1e15 -3e299 1e-320"))
    assert np.isfinite(read_bvh(path).rotations).all()
