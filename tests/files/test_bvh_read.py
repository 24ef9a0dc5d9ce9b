"""What the BVH reader makes of layouts, channels, counts, rates and units; every text here is written by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.core.rotation import EULER_ORDERS, quat_about_axis, quat_distance, quat_multiply
from kinestitch.errors import KinestitchWarning, ParameterError
from kinestitch.files import read
from kinestitch.files.bvh import read_bvh
from kinestitch.files.rates import COMMON_RATES, snap_rate
from kinestitch.testing import check_motion

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


@pytest.fixture
def load(tmp_path):
    def load(text, **options):
        path = tmp_path / "clip.bvh"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        motion = read_bvh(path, **options)
        check_motion(motion)
        return motion

    return load


def product(order, degrees):
    q = np.array([0.0, 0.0, 0.0, 1.0])
    for letter, angle in zip(order, degrees, strict=True):
        q = quat_multiply(q, quat_about_axis("XYZ".index(letter), np.radians(angle)))
    return q


def turned_by(motion, frame, joint, order, degrees):
    return quat_distance(motion.rotations[frame, joint], product(order, degrees)) < 1e-12


def test_plain_file(load):
    motion = load(ARM)
    assert motion.skeleton.names == ("Hips", "Arm")
    assert motion.skeleton.parents == (-1, 0)
    assert motion.fps == 30.0
    assert motion.name == "clip"
    assert np.allclose(motion.skeleton.offsets, [[0, 0.9, 0], [0.1, 0, 0]], atol=1e-15)
    assert np.allclose(motion.skeleton.tips, [[np.nan] * 3, [0.05, 0, 0]], equal_nan=True)
    assert np.allclose(motion.translations[:, 0], [[0.01, 0.02, 0.03], [0.04, 0.05, 0.06]], atol=1e-15)
    assert np.allclose(motion.translations[:, 1], [0.1, 0, 0], atol=1e-15)
    assert turned_by(motion, 0, 0, "ZXY", (10, 20, 30))
    assert turned_by(motion, 1, 1, "ZXY", (41, 51, 61))


@pytest.mark.parametrize("order", EULER_ORDERS)
def test_every_order_of_rotations(load, order):
    channels = " ".join(f"{letter}rotation" for letter in order)
    motion = load(ARM.replace("CHANNELS 3 Zrotation Xrotation Yrotation", f"CHANNELS 3 {channels}"))
    assert turned_by(motion, 0, 1, order, (40, 50, 60))
    assert turned_by(motion, 0, 0, "ZXY", (10, 20, 30))


def arm_with(channels, values):
    text = ARM.replace("CHANNELS 3 Zrotation Xrotation Yrotation", f"CHANNELS {len(channels.split())} {channels}")
    return text.replace(" 40 50 60", f" {values}").replace(" 41 51 61", f" {values}")


@pytest.mark.parametrize(
    ("channels", "values", "order", "degrees", "place"),
    [
        ("", "", "", (), (10, 0, 0)),
        ("Yrotation", "70", "Y", (70,), (10, 0, 0)),
        ("Xrotation Zrotation", "70 -20", "XZ", (70, -20), (10, 0, 0)),
        ("Xrotation Yrotation Xrotation", "5 6 7", "XYX", (5, 6, 7), (10, 0, 0)),
        ("Yposition", "9", "", (), (10, 9, 0)),
        ("Zrotation Xposition Yrotation Zposition", "15 3 25 4", "ZY", (15, 25), (3, 0, 4)),
        ("Xrotation Yrotation Zrotation Xposition Yposition Zposition", "1 2 3 7 8 9", "XYZ", (1, 2, 3), (7, 8, 9)),
        ("zROTATION xRotation YROTATION", "1 2 3", "ZXY", (1, 2, 3), (10, 0, 0)),
    ],
)
def test_channels_of_any_kind(load, channels, values, order, degrees, place):
    motion = load(arm_with(channels, values))
    for frame in range(2):
        assert turned_by(motion, frame, 1, order, degrees)
        assert np.allclose(motion.translations[frame, 1], np.array(place) * 0.01, atol=1e-15)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace(" ", "\t"),
        lambda text: text.replace("\n{", " {"),
        lambda text: text.replace("\n", "\n\n"),
        lambda text: text.rstrip("\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("Frames:", "Frames :").replace("Frame Time: ", "Frame Time:\t"),
        lambda text: text.replace("Frames: 2\nFrame Time", "FRAMES: 2\nframe time"),
        lambda text: text.replace("40 50 60", "4e1 +50.0 6.0E+01"),
        lambda text: text.replace("1 2 3 10", "   1\t2  3 10").replace("60\n", "60  \n"),
        lambda text: text.replace("End Site", "End Site of the arm"),
        lambda text: text.replace("OFFSET 10 0 0\n", "OFFSET 10 0 0 "),
        lambda text: text.replace("HIERARCHY", "hierarchy").replace("ROOT", "Root").replace("MOTION", "Motion"),
    ],
)
def test_layouts_read_alike(load, change):
    plain, other = load(ARM), load(change(ARM))
    assert other.skeleton == plain.skeleton
    assert np.array_equal(other.rotations, plain.rotations)
    assert np.array_equal(other.translations, plain.translations)


def test_one_frame(load):
    assert load(ARM.replace("Frames: 2", "Frames: 1").replace("4 5 6 11 21 31 41 51 61\n", "")).frames == 1


@pytest.mark.parametrize("name", ["mixamorig:Hips", "Left Arm 2", "bip.01/Hüfte", "0"])
def test_names_are_kept(load, name):
    assert load(ARM.replace("ROOT Hips", f"ROOT  {name} ")).skeleton.names == (name, "Arm")


def test_names_in_latin1(load):
    assert load(ARM.replace("Arm", "Hüfte").encode("latin-1")).skeleton.names[1] == "Hüfte"


def test_repeated_names_get_a_number(load):
    two = ARM.replace("  JOINT Arm", "  JOINT Arm\n  {\n    OFFSET 0 1 0\n    CHANNELS 0\n  }\n  JOINT Arm")
    with pytest.warns(KinestitchWarning, match=r"1 joint name"):
        motion = load(two)
    assert motion.skeleton.names == ("Hips", "Arm", "Arm_2")
    assert motion.skeleton.parents == (-1, 0, 0)


def test_end_site_missing_or_of_no_length(load):
    bare = ARM.replace("    End Site\n    {\n      OFFSET 5 0 0\n    }\n", "")
    assert np.isnan(load(bare).skeleton.tips).all()
    assert np.isnan(load(ARM.replace("OFFSET 5 0 0", "OFFSET 0 0.0 -0")).skeleton.tips).all()


def test_rows_beyond_the_declared_ones_are_left_out(load):
    with pytest.warns(KinestitchWarning, match=r"^2 row\(s\) after the 1 frames"):
        motion = load(ARM.replace("Frames: 2", "Frames: 1") + "\nhalf a row\n")
    assert motion.frames == 1


@pytest.mark.parametrize(
    ("frame_time", "fps"),
    [
        (".0083333", 120),
        ("0.008333", 120),
        ("0.0333333", 30),
        ("0.03333", 30),
        ("0.0416667", 24),
        ("0.0417083750417", 24000 / 1001),
        ("0.033367", 30000 / 1001),
        ("0.008342", 120000 / 1001),
        ("0.04", 25),
        ("8e-3", 125),
        ("1", 1),
        ("0.027027027", 1 / 0.027027027),
    ],
)
def test_rate(load, frame_time, fps):
    assert load(ARM.replace("0.0333333", frame_time)).fps == pytest.approx(fps, rel=1e-12)


@given(st.sampled_from(COMMON_RATES), st.floats(-4.9e-4, 4.9e-4))
def test_common_rates_are_found(rate, error):
    assert snap_rate(rate * (1 + error)) == pytest.approx(rate, rel=1.1e-3)
    assert snap_rate(rate) == rate


def test_units(load):
    hips = [load(ARM, unit=unit).skeleton.offsets[0, 1] for unit in ("m", "cm", "mm", "inch", "asf", 2.0)]
    assert hips == pytest.approx([90, 0.9, 0.09, 2.286, 5.08, 180])
    small = ARM.replace("OFFSET 10", "OFFSET 1")
    assert load(small).skeleton.offsets[1, 0] == pytest.approx(1)
    assert load(ARM).skeleton.offsets[1, 0] == pytest.approx(0.1)
    cmu = ARM.replace("OFFSET 10", "OFFSET 20").replace("Hips", "LHipJoint").replace("Arm", "LowerBack")
    assert load(cmu).skeleton.offsets[1, 0] == pytest.approx(20 * 0.0254 / 0.45)
    with pytest.raises(ParameterError, match="unit"):
        load(ARM, unit="foot")
    with pytest.raises(ParameterError, match="unit"):
        load(ARM, unit=-1.0)


def test_front_door_reads_bvh(tmp_path):
    path = tmp_path / "A.BVH"
    path.write_text(ARM)
    assert read(path, unit="m").frames == 2
    with pytest.raises(ParameterError, match="take"):
        read(path, take="one")


@pytest.mark.parametrize("block", [1, 30, 61])
@pytest.mark.parametrize("gap", ["\n", "\r\n", "\n\n  \n"])
def test_blocks_end_anywhere(load, monkeypatch, block, gap):
    rows = [" ".join(str(f * 9 + c) for c in range(9)) for f in range(20)]
    text = ARM[: ARM.index("1 2 3 10")].replace("Frames: 2", "Frames: 18") + gap.join(rows)
    with pytest.warns(KinestitchWarning, match="2 row"):
        whole = load(text)
    monkeypatch.setattr("kinestitch.files.bvh_frames.BLOCK", block)
    with pytest.warns(KinestitchWarning, match="2 row"):
        cut = load(text)
    assert cut.frames == 18
    assert np.array_equal(cut.rotations, whole.rotations)
    assert np.array_equal(cut.translations, whole.translations)


def test_long_rows_and_many_blocks(load):
    rows = "\n".join(" ".join(f"{(f * 9 + c) % 997 / 7:.6f}" for c in range(9)) for f in range(5000))
    motion = load(ARM[: ARM.index("1 2 3 10")].replace("Frames: 2", "Frames: 5000") + rows)
    expected = np.array([[float(x) for x in row.split()] for row in rows.split("\n")])
    assert np.array_equal(motion.translations[:, 0], expected[:, :3] * 0.01)
    assert turned_by(motion, 4999, 1, "ZXY", expected[4999, 6:])
