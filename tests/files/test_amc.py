"""ASF/AMC: the skeleton's rules one by one, damaged files, and the same recordings as BVH."""

import contextlib
import os
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.core.kinematics import world_pose
from kinestitch.core.rotation import quat_distance, quat_identity, quat_multiply, rotvec_to_quat
from kinestitch.errors import FormatError, KinestitchError, KinestitchWarning, ParameterError
from kinestitch.files.amc import read_amc
from kinestitch.files.bvh import read_bvh
from kinestitch.testing import check_motion

DATA = os.environ.get("KINESTITCH_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")
INCH = 0.0254

ASF = """# a comment
:version 1.10
:name leg
:units
  mass 1.0
  length 0.5
  angle deg
:documentation
   two bones
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 1 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name thigh
     direction 0 -1 0
     length 8
     axis 0 0 0 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name shin
     direction 0 -1 0
     length 6
     axis 0 90 0 XYZ
    dof rx
  end
:hierarchy
  begin
    root thigh
    thigh shin
  end
"""
AMC = """#!OML:ASF
:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 0 0 0
thigh 0 0 0
shin 0
2
root 1 2 3 0 90 0
thigh 90 0 0
shin 90
"""


def write(folder, asf=ASF, amc=AMC, names=("01.asf", "01_01.amc")):
    (folder / names[0]).write_text(asf)
    (folder / names[1]).write_text(amc)
    return folder / names[1]


def test_bones_become_joints_at_their_starts(tmp_path):
    motion = read_amc(write(tmp_path))
    check_motion(motion)
    assert motion.skeleton.names == ("root", "thigh", "shin")
    assert motion.skeleton.parents == (-1, 0, 1)
    assert (motion.frames, motion.fps, motion.name) == (2, 120.0, "01_01")
    unit = INCH / 0.5
    np.testing.assert_allclose(motion.skeleton.offsets, np.array([[0, 1, 0], [0, 0, 0], [0, -8, 0]]) * unit)
    np.testing.assert_allclose(motion.skeleton.tips, np.array([[np.nan] * 3, [np.nan] * 3, [0, -6, 0]]) * unit)
    np.testing.assert_array_equal(motion.skeleton.rest, quat_identity((3,)))
    np.testing.assert_allclose(motion.translations[:, 0], [[unit, 3 * unit, 3 * unit]] * 2)


def test_angles_turn_in_the_frame_of_the_bones_axis(tmp_path):
    motion = read_amc(write(tmp_path))
    quarter = np.pi / 2
    turn = rotvec_to_quat([[0, quarter, 0], [quarter, 0, 0], [0, 0, -quarter]])  # x, turned by 90° about y, is -z
    assert np.degrees(quat_distance(motion.rotations[1], turn)).max() < 1e-9


def test_the_first_channel_turns_first(tmp_path):
    amc = AMC.replace("thigh 90 0 0", "thigh 10 20 30")
    x, y, z = (rotvec_to_quat(np.eye(3)[i] * np.radians(10 * (i + 1))) for i in range(3))
    expected = quat_multiply(z, quat_multiply(y, x))
    assert quat_distance(read_amc(write(tmp_path, amc=amc)).rotations[1, 1], expected) < 1e-12
    asf = ASF.replace("dof rx ry rz", "dof rz ry rx")
    amc = AMC.replace("thigh 90 0 0", "thigh 30 20 10")
    expected = quat_multiply(x, quat_multiply(y, z))
    assert quat_distance(read_amc(write(tmp_path, asf, amc)).rotations[1, 1], expected) < 1e-12


def test_radians_of_either_file(tmp_path):
    degrees = read_amc(write(tmp_path))
    half = repr(np.pi / 2)
    asf = ASF.replace("angle deg", "angle rad").replace("0 90 0 XYZ", f"0 {half} 0 XYZ")
    amc = AMC.replace("90", half).replace(":DEGREES", ":RADIANS")
    for text in (amc, amc.replace(":RADIANS\n", "")):
        np.testing.assert_allclose(read_amc(write(tmp_path, asf, text)).rotations, degrees.rotations, atol=1e-12)
    assert np.allclose(read_amc(write(tmp_path, asf)).rotations, degrees.rotations), "the AMC's own unit wins"


def test_orientation_of_the_root_is_part_of_the_rest_pose(tmp_path):
    asf = ASF.replace("orientation 0 0 0", "orientation 0 90 0")
    motion = read_amc(write(tmp_path, asf))
    quarter = rotvec_to_quat([0, np.pi / 2, 0])
    assert quat_distance(motion.skeleton.rest[0], quarter) < 1e-12
    unit = INCH / 0.5
    np.testing.assert_allclose(motion.translations[0, 0], np.array([3, 1 + 2, -1]) * unit, atol=1e-12)


@pytest.mark.parametrize(
    ("length", "bone", "metres"),
    [
        ("length 1", "length 8", 0.01),
        ("length 1", "length 0.8", 1.0),
        ("", "length 8", 0.01),
        ("length 2", "length 8", 0.0127),
    ],
)
def test_unit_of_length(tmp_path, length, bone, metres):
    asf = (
        ASF.replace("length 0.5", length)
        .replace("length 8", bone)
        .replace("length 6", "length 6" if "8" in bone else "")
    )
    asf = asf.replace("position 0 1 0", "position 0 0 0")
    assert read_amc(write(tmp_path, asf)).translations[0, 0, 0] == pytest.approx(metres)


def test_unit_and_rate_can_be_said(tmp_path):
    path = write(tmp_path)
    assert read_amc(path, unit="cm").translations[0, 0, 0] == pytest.approx(0.01)
    assert read_amc(path, unit=2.0, fps=60).translations[0, 0, 0] == pytest.approx(2.0)
    assert read_amc(path, fps=60).fps == 60.0
    timed = write(tmp_path, amc=AMC.replace(":DEGREES", ":DEGREES\n:SAMPLES-PER-SECOND 100"))
    assert read_amc(timed).fps == 100.0
    for options in ({"fps": 0}, {"fps": np.nan}, {"unit": "mile"}, {"unit": -1.0}):
        with pytest.raises(ParameterError):
            read_amc(path, **options)


def test_which_skeleton_is_taken(tmp_path):
    only = write(tmp_path, names=("body.ASF", "walk.amc"))
    assert read_amc(only).skeleton.joint_count == 3
    (tmp_path / "other.asf").write_text("")
    with pytest.raises(FormatError, match=r"got 2 \.asf files\. Pass skeleton= "):
        read_amc(only)
    assert read_amc(only, skeleton=tmp_path / "body.ASF").skeleton.joint_count == 3
    (tmp_path / "walk.asf").write_text(ASF)
    assert read_amc(only).frames == 2
    alone = tmp_path / "alone"
    alone.mkdir()
    (alone / "walk.amc").write_text(AMC)
    with pytest.raises(FormatError, match=r"got no \.asf files"):
        read_amc(alone / "walk.amc")


def test_bones_without_values_keep_their_rest_pose(tmp_path):
    amc = AMC.replace("shin 0\n", "").replace("shin 90\n", "")
    motion = read_amc(write(tmp_path, amc=amc))
    np.testing.assert_array_equal(motion.rotations[:, 2], quat_identity((2,)))


def test_bones_outside_the_hierarchy_are_left_out_with_a_warning(tmp_path):
    asf = ASF.replace("    thigh shin\n", "")
    amc = AMC.replace("shin 0\n", "").replace("shin 90\n", "")
    with pytest.warns(KinestitchWarning, match="1 bone"):
        assert read_amc(write(tmp_path, asf, amc)).skeleton.joint_count == 2


@pytest.mark.parametrize(
    ("asf", "amc", "message"),
    [
        ("", None, r"expected a section :bonedata, got the end.*01\.asf\)"),
        ("HIERARCHY", None, r"Line 1: expected a section.*Is this an ASF file\?"),
        (ASF[: ASF.index(":hier")], None, "expected a section :hierarchy"),
        (ASF[: ASF.index(":hier") - 10], None, "expected end after bone 'shin'|expected a section"),
        (ASF.replace("name shin", "name thigh"), None, "Line 34: expected bones with names of their own"),
        (ASF.replace("name shin", "name"), None, "expected a name"),
        (ASF.replace("length 6", "length six"), None, r"Line 31: expected 1 number\(s\) after length, got 'six'"),
        (ASF.replace("length 6", "length nan"), None, "Line 31"),
        (ASF.replace("length 0.5", "length 0"), None, "Line 6: expected length > 0"),
        (ASF.replace("angle deg", "angle gon"), None, "Line 7: expected angle deg or rad, got 'gon'"),
        (ASF.replace("0 90 0 XYZ", "0 90 0 XYX"), None, "Line 32: expected an order of axes like XYZ, got 'XYX'"),
        (ASF.replace("dof rx ry rz", "dof rx ry rw"), None, "Line 22: expected channels out of"),
        (ASF.replace("root thigh", "root knee"), None, "expected names of bones, got 'knee'"),
        (ASF.replace("thigh shin", "thigh shin thigh"), None, "every bone once in :hierarchy, got 'thigh' twice"),
        (ASF.replace("dof rx\n", "dof l\n"), None, "Expected rotations only on 'shin', got 'l'"),
        (None, "", "expected at least one frame, got the end of the file"),
        (None, "\x00\x01", "expected a frame number"),
        (None, AMC.replace("thigh 0 0 0", "thigh 0 0"), r"Line 6: expected 3 value\(s\) for 'thigh', got 2"),
        (None, AMC.replace("thigh 0 0 0", "arm 0 0 0"), "Line 6: expected a bone of the skeleton, got 'arm'"),
        (None, AMC.replace("thigh 0 0 0", "thigh 0 inf 0"), "Line 6: expected 3 number"),
        (None, AMC.replace("thigh 90 0 0\n", ""), "expected values of 'thigh' before the end of frame 2"),
        (None, AMC.replace("thigh 0 0 0\n", ""), "expected 'thigh' once in every frame"),
        (None, AMC + "shin 1\n", "expected 'shin' once in every frame"),
        (None, AMC + "3\n", "expected values of 'root' before the end of frame 3"),
        (None, "1\n2\n", "expected values of bones in frame 1"),
    ],
)  # fmt: skip
def test_damaged_files(tmp_path, asf, amc, message):
    path = write(tmp_path, ASF if asf is None else asf, AMC if amc is None else amc)
    with pytest.raises(FormatError, match=message) as caught:
        read_amc(path)
    assert str(caught.value).endswith(")")
    assert "\n" not in str(caught.value)


@given(st.sampled_from(["asf", "amc"]), st.integers(0, 10**6), st.binary(max_size=6), st.integers(0, 40))
def test_random_damage_raises_only_our_errors(tmp_path_factory, which, where, what, cut):
    texts = {"asf": ASF.encode(), "amc": AMC.encode()}
    at = where % len(texts[which])
    texts[which] = texts[which][:at] + what + texts[which][at + cut :]
    folder = tmp_path_factory.mktemp("damage")
    for name, data in texts.items():
        (folder / f"a.{name}").write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        with contextlib.suppress(KinestitchError):
            check_motion(read_amc(folder / "a.amc"))


def rows():
    if not DATA:
        return []
    table = (Path(DATA) / "MANIFEST.md").read_text(encoding="utf-8")
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return [(c[0], float(c[4]), int(c[5]), int(c[6])) for c in cells if c[0].endswith(".amc")]


@pytest.mark.parametrize(("name", "fps", "frames", "joints"), rows())
def test_real_file(name, fps, frames, joints):
    assert DATA
    motion = read_amc(Path(DATA) / name)
    check_motion(motion)
    assert (motion.fps, motion.frames, motion.skeleton.joint_count) == (fps, frames, joints)
    positions = world_pose(motion).positions
    assert 1.2 < np.ptp(positions[0], axis=0)[1] < 1.8
    assert np.abs(positions[..., 1].min()) < 0.2


@needs_data
def test_01_01_turns_like_its_bvh():
    """Another program's BVH of the same recording, after its extra first frame; it gives some bones no length."""
    assert DATA
    amc = read_amc(Path(DATA) / "cmu_asf_amc/01_01.amc")
    bvh = read_bvh(Path(DATA) / "conformance_bvh/assimp_01_01.bvh")
    assert bvh.frames == amc.frames + 1
    assert np.degrees(quat_distance(amc.rotations, bvh.rotations[1:])).max() < 2e-4  # measured 1.1e-4
    gap = np.linalg.norm(world_pose(amc).positions - world_pose(bvh).positions[1:], axis=-1).max(axis=0)
    same = [amc.skeleton.names.index(n) for n in ("root", "lfoot", "ltoes", "rfoot", "rtoes", "thorax")]
    assert gap[same].max() < 1e-5  # measured 4e-6 m


@needs_data
def test_16_15_stands_like_its_bvh():
    """The BVH agrees on every fourth frame; between them both were filled in, in angles of different axes."""
    assert DATA
    amc = read_amc(Path(DATA) / "cmu_asf_amc/16_15.amc")
    bvh = read_bvh(Path(DATA) / "cmu/16_15.bvh")
    same = [amc.skeleton.names.index(name) for name in bvh.skeleton.names]
    gap = np.linalg.norm(world_pose(amc).positions[:, same] - world_pose(bvh).positions, axis=-1)
    assert gap.shape == (471, 29)
    assert gap[::4].max() < 1e-5  # measured 5.7e-6 m
    assert np.median(gap) < 1e-3
