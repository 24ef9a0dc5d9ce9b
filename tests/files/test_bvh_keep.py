"""like= for BVH: the file's joints, unit and channels, as far as they can tell the motion."""

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.core.rotation import quat_distance, rotvec_to_quat
from kinestitch.errors import SkeletonMismatchError
from kinestitch.files import read, write
from kinestitch.files.bvh import read_bvh, write_bvh

SOURCE = """HIERARCHY
ROOT Hips
{
  OFFSET 0 9 0
  CHANNELS 6 Zposition Yposition Xposition Xrotation Yrotation Zrotation
  JOINT Arm
  {
    OFFSET 1 4 0
    CHANNELS 2 Yrotation Xrotation
    End Site { OFFSET 0 3 0 }
  }
  JOINT Knee
  {
    OFFSET 0 -4 0
    CHANNELS 1 Xrotation
    JOINT Foot { OFFSET 0 -4 0 CHANNELS 4 Yposition Zrotation Xrotation Yrotation
      End Site { OFFSET 0 0 1 } }
  }
}
MOTION
Frames: 2
Frame Time: 0.025
1 2 3 10 20 30 40 50 60 -4 7 8 9
2 3 4 11 21 31 41 51 61 -5 170 9 10
"""
INCH = 0.0254


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "source.bvh"
    path.write_text(SOURCE)
    return path


def channels(path):
    return [line.split()[2:] for line in path.read_text().splitlines() if "CHANNELS" in line]


def numbers(path):
    return np.array([[float(word) for word in line.split()] for line in path.read_text().splitlines()[-2:]])


def test_its_own_motion_comes_out_in_its_own_numbers(source, tmp_path):
    write_bvh(read_bvh(source, unit="inch"), tmp_path / "out.bvh", like=source, unit="inch")
    told = SOURCE.replace("{ OFFSET", "\n{\nOFFSET").replace(" CHANNELS", "\nCHANNELS").splitlines()
    wanted = [line.split()[2:] for line in told if "CHANNELS" in line]
    assert channels(tmp_path / "out.bvh") == wanted
    assert numbers(tmp_path / "out.bvh") == pytest.approx(numbers(source), abs=2e-6)


def test_another_motion_gets_the_channels_it_needs(source, tmp_path):
    motion = read(source)
    turns = motion.rotations.copy()
    turns[1, 2] = rotvec_to_quat(np.array([0.3, 0.2, 0.1]))
    moved = motion.translations.copy()
    moved[1, 1] += 0.01
    motion = replace(motion, rotations=turns, translations=moved)
    write(motion, tmp_path / "out.bvh", like=source)
    back = read(tmp_path / "out.bvh")
    assert channels(tmp_path / "out.bvh")[1:3] == [
        ["Xposition", "Yposition", "Zposition", "Yrotation", "Xrotation"],
        ["Xrotation", "Zrotation", "Yrotation"],
    ]
    assert np.degrees(quat_distance(back.rotations, motion.rotations)).max() < 1e-5
    assert np.abs(world_pose(back).positions - world_pose(motion).positions).max() < 1e-7
    assert back.skeleton == motion.skeleton


def test_another_figure_is_refused(source, tmp_path):
    motion = read(source)
    renamed = replace(motion.skeleton, names=("Hips", "Arm", "Knee", "Toe"))
    with pytest.raises(SkeletonMismatchError, match=r"'Toe'.*source\.bvh"):
        write(replace(motion, skeleton=renamed), tmp_path / "out.bvh", like=source)
