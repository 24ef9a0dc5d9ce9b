"""Every reader × every writer: what one format gives, another takes, and gives back the same.

A new row of FORMATS joins by itself; one that cannot be written needs a source below. Formats may tell joints in other
axes, add joints that stay at rest, and order them otherwise: poses are compared on the skeleton that is read back.
"""

import importlib
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance
from kinestitch.errors import MissingExtraError, SkeletonMismatchError
from kinestitch.files import FORMATS, format_of, has_character, read, write
from kinestitch.files.likeness import told_on
from kinestitch.samples import sample
from kinestitch.testing import random_motion

DEGREES, METRES = 0.01, 1e-4
BODIES = {"AMASS"}
"""Formats that hold bodies of one kind only."""

READERS = [suffix for entry in FORMATS if entry.reads and not entry.records for suffix in entry.suffixes]
WRITERS = [suffix for entry in FORMATS if entry.writes and not entry.records for suffix in entry.suffixes]

ASF = """:version 1.10
:name own
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lowerback
     direction 0 1 0
     length 8
     axis 10 20 30 XYZ
    dof rx ry rz
  end
  begin
     id 2
     name head
     direction 0 0.8 0.6
     length 5
     axis 0 90 0 XYZ
    dof rx
  end
:hierarchy
  begin
    root lowerback
    lowerback head
  end
"""
AMC = ":FULLY-SPECIFIED\n:DEGREES\n" + "".join(
    f"{k}\nroot {k} 17 {-k} {3 * k} {k} 5\nlowerback {9 * k} 4 {-5 * k}\nhead {20 - k}\n" for k in range(1, 5)
)


@cache
def clips():
    """A sample, a random motion with rest rotations, one frame, and one of a body that choosy formats take."""
    from kinestitch.files.smpl import LAYOUTS, skeleton_of

    kick = sample("kick", fps=30)
    body = skeleton_of(LAYOUTS[0])[0]
    turns = random_motion(3, joints=body.joint_count, frames=12, fps=60.0, bend=2.0)
    moved = np.broadcast_to(body.offsets, turns.translations.shape).copy()
    moved[:, 0] += np.linspace(0, 1, 12)[:, None]
    return {
        "sample": replace(kick, translations=kick.translations[:30], rotations=kick.rotations[:30]),
        "random": random_motion(1, joints=9, frames=40, fps=29.97, bend=3.0),
        "one frame": random_motion(2, joints=4, frames=1, fps=24.0),
        "body": Motion(body, moved, turns.rotations, 60.0, "body"),
    }


def sources(suffix, folder):
    """Files of a format by the name of their clip."""
    entry = format_of(f"a{suffix}")
    folder.mkdir()
    made = {}
    if entry.writes:
        for name, clip in clips().items():
            path = folder / f"{name}{suffix}"
            if _write(clip, path):
                made[name] = path
    elif suffix == ".amc":
        (folder / "own.asf").write_text(ASF)
        made["own"] = folder / "own.amc"
        made["own"].write_text(AMC)
    elif suffix == ".usdz":
        utilities = pytest.importorskip("pxr.UsdUtils", reason="needs usd-core")
        for name, path in sources(".usdc", folder / "parts").items():
            made[name] = folder / f"{name}.usdz"
            assert utilities.CreateNewUsdzPackage(str(path), str(made[name]))
    assert made, f"{suffix} cannot be written: give it a source here"
    return made


def _write(motion, path):
    """Whether the format takes this motion's skeleton."""
    try:
        write(motion, path)
    except MissingExtraError as error:
        pytest.skip(str(error))
    except SkeletonMismatchError:
        assert format_of(path).name in BODIES
        return False
    return True


def assert_same(actual, expected):
    """The same poses: world positions, and rotations told in the axes that the file has."""
    assert actual.frames == expected.frames
    assert actual.fps == pytest.approx(expected.fps, rel=1e-5)
    told = told_on(expected, actual.skeleton)
    assert rest_pose(told.skeleton)[0] == pytest.approx(rest_pose(actual.skeleton)[0], abs=METRES)
    a, b = world_pose(actual), world_pose(told)
    assert np.linalg.norm(a.positions - b.positions, axis=-1).max() <= METRES
    assert np.degrees(quat_distance(a.rotations, b.rotations)).max() <= DEGREES
    assert np.degrees(quat_distance(actual.rotations, told.rotations)).max() <= DEGREES


def test_the_table_is_whole():
    assert {".bvh", ".fbx", ".glb", ".gltf"} <= set(WRITERS) <= set(READERS)
    for entry in FORMATS:
        module = importlib.import_module(f"kinestitch.files.{entry.module}")
        assert hasattr(module, f"read_{entry.module}") == entry.reads
        assert not entry.writes or hasattr(module, f"write_{entry.module}")


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    """What the reader of a suffix reads from its sources, by the name of their clip."""

    @cache
    def given(suffix):
        made = sources(suffix, tmp_path_factory.mktemp("sources") / "in")
        return {name: read(path) for name, path in made.items()}

    return given


@pytest.mark.parametrize("start", READERS)
def test_what_is_read_is_what_was_written(start, motions):
    for name, motion in motions(start).items():
        if name in clips():
            assert_same(motion, clips()[name])


@pytest.mark.parametrize("suffix", READERS)
def test_what_we_write_has_no_mesh(suffix, tmp_path):
    for path in sources(suffix, tmp_path / "in").values():
        assert not has_character(path)


def test_a_mesh_in_usd(tmp_path):
    pytest.importorskip("pxr", reason="needs usd-core")
    (tmp_path / "a.usda").write_text('#usda 1.0\ndef Xform "root"\n{\n  def Mesh "skin"\n  {\n  }\n}\n')
    assert has_character(tmp_path / "a.usda")


@pytest.mark.parametrize("stop", WRITERS)
@pytest.mark.parametrize("start", READERS)
def test_convert(start, stop, motions, tmp_path):
    done = []
    for name, motion in motions(start).items():
        target = tmp_path / f"{name}{stop}"
        if _write(motion, target):
            assert_same(read(target), motion)
            done.append(name)
    choosy = {format_of(f"a{suffix}").name for suffix in (start, stop)} & BODIES
    assert done or choosy
    assert choosy or len(done) in (1, len(clips()))
