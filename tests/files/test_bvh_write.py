"""What is written as BVH comes back: rotations to 1e-5°, lengths to 1e-6 m."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.core.kinematics import with_joint_axes, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import EULER_ORDERS, euler_to_quat, quat_identity, quat_normalize, quat_slerp
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import OutputError, ParameterError
from kinestitch.files import read, write
from kinestitch.files.bvh import UNITS, read_bvh, write_bvh
from kinestitch.testing import assert_motion_close, motions, quaternions, random_motion


def chain(motion: Motion, scale: float = 1.0) -> Motion:
    """The motion's numbers on a chain without rest rotations, whose joints are depth first and keep their offsets."""
    count = motion.skeleton.joint_count
    offsets = motion.skeleton.offsets * scale
    skeleton = Skeleton(motion.skeleton.names, tuple(range(-1, count - 1)), offsets)
    translations = np.broadcast_to(offsets, motion.translations.shape).copy()
    translations[:, 0] = motion.translations[:, 0] * scale
    return replace(motion, skeleton=skeleton, translations=translations)


def there_and_back(motion, path, unit="auto", **options):
    write_bvh(motion, path, unit=unit, **options)
    return read_bvh(path, unit=unit)


@settings(max_examples=30, deadline=None)
@given(motions(bend=3.0), st.sampled_from(EULER_ORDERS), st.sampled_from(["auto", *UNITS, 0.3]))
def test_round_trip(tmp_path_factory, motion, order, unit):
    path = tmp_path_factory.getbasetemp() / "round.bvh"
    straight = chain(motion)
    assert_motion_close(there_and_back(straight, path, unit, order=order), straight, degrees=1e-5, metres=1e-6)


@settings(max_examples=25, deadline=None)
@given(st.floats(-3, 3).map(lambda power: 10.0**power))
def test_auto_unit_reads_back_what_it_wrote(tmp_path_factory, scale):
    path = tmp_path_factory.getbasetemp() / "scale.bvh"
    motion = chain(random_motion(5, frames=3), scale)
    assert_motion_close(there_and_back(motion, path), motion, degrees=1e-5, metres=1e-6)
    names = ("LHipJoint", "LowerBack", "c", "d")
    motion = replace(motion, skeleton=replace(motion.skeleton, names=names))
    assert_motion_close(there_and_back(motion, path), motion, degrees=1e-5, metres=1e-6)


@settings(max_examples=30, deadline=None)
@given(motions(bend=2.0))
def test_rest_rotations_become_joint_axes_of_the_world(tmp_path_factory, motion):
    path = tmp_path_factory.getbasetemp() / "rest.bvh"
    back = there_and_back(motion, path)
    told = with_joint_axes(motion, quat_identity())
    place = [back.skeleton.names.index(name) for name in motion.skeleton.names]
    assert np.abs(world_pose(back).positions[:, place] - world_pose(motion).positions).max() < 1e-6
    assert np.abs(back.skeleton.offsets[place] - told.skeleton.offsets).max() < 1e-6
    assert not back.skeleton.rest[:, :3].any()


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(EULER_ORDERS), st.floats(-12, 0), st.sampled_from([-1, 1]), st.floats(-3, 3), st.floats(-3, 3))
def test_gimbal_lock(tmp_path_factory, order, power, side, first, third):
    path = tmp_path_factory.getbasetemp() / "gimbal.bvh"
    middle = side * (np.pi / 2 - 10.0**power)
    rotations = np.array([euler_to_quat([first, middle, third], order)])
    motion = Motion(Skeleton(("a",), (-1,), [[0, 0, 0]]), np.zeros((1, 1, 3)), rotations[None], 30.0)
    assert_motion_close(there_and_back(motion, path, order=order), motion, degrees=1e-5, metres=1e-6)


@settings(max_examples=40, deadline=None)
@given(quaternions(), quaternions())
def test_angles_do_not_jump(tmp_path_factory, start, stop):
    path = tmp_path_factory.getbasetemp() / "jump.bvh"
    q = quat_slerp(start, stop, np.linspace(0, 1, 1300))[:, None]
    skeleton = Skeleton(("a",), (-1,), [[0, 0, 0]])
    motion = Motion(skeleton, np.zeros((1300, 1, 3)), quat_normalize(q), 60.0)
    assert_motion_close(there_and_back(motion, path), motion, degrees=1e-5, metres=1e-6)
    lines = path.read_text().split("Frame Time")[1].splitlines()[1:]
    rows = np.array([[float(x) for x in line.split()] for line in lines])
    assert np.abs(np.diff(rows[:, [3, 5]], axis=0)).max() <= 181


def test_channels_names_tips_and_rate(tmp_path):
    tips = np.full((3, 3), np.nan)
    tips[1] = [0.1, 0.2, 0.3]
    skeleton = Skeleton(("mixamorig:Hips", "Left {Arm}", "Left _Arm_"), (-1, 0, 0), np.eye(3), tips=tips)
    translations = np.broadcast_to(np.eye(3), (2, 3, 3)).copy()
    translations[1, 2, 0] += 0.5
    motion = Motion(skeleton, translations, quat_identity((2, 3)), 120000 / 1001)
    write_bvh(motion, tmp_path / "a.bvh")
    text = (tmp_path / "a.bvh").read_text()
    assert text.count("CHANNELS 6") == 2
    assert text.count("CHANNELS 3") == 1
    assert "-0.0" not in text
    back = read_bvh(tmp_path / "a.bvh")
    assert back.skeleton.names == ("mixamorig:Hips", "Left_Arm_", "Left__Arm_")
    assert np.allclose(back.skeleton.tips, tips, atol=1e-9, equal_nan=True)
    assert np.allclose(back.translations, translations, atol=1e-9)
    assert back.fps == motion.fps


@pytest.mark.parametrize("fps", [24, 30, 37.5, 119.88, 1000 / 7, 0.5])
def test_rate_survives(tmp_path, fps):
    motion = replace(random_motion(1, frames=2), fps=fps)
    assert there_and_back(motion, tmp_path / "a.bvh").fps == pytest.approx(fps, rel=1e-4 if fps == 119.88 else 1e-12)


def test_written_twice_is_the_same_bytes(tmp_path):
    motion = random_motion(2, frames=1100)
    write_bvh(motion, tmp_path / "a.bvh")
    write_bvh(motion, tmp_path / "b.bvh")
    assert (tmp_path / "a.bvh").read_bytes() == (tmp_path / "b.bvh").read_bytes()


def test_front_door_and_refusals(tmp_path):
    motion = random_motion(2)
    write(motion, tmp_path / "a.bvh", order="XYZ")
    assert read(tmp_path / "a.bvh").frames == motion.frames
    with pytest.raises(ParameterError, match="order"):
        write_bvh(motion, tmp_path / "b.bvh", order="XYX")
    with pytest.raises(ParameterError, match="unit"):
        write_bvh(motion, tmp_path / "b.bvh", unit="mile")
    with pytest.raises(OutputError):
        write_bvh(motion, tmp_path / "no" / "b.bvh")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a.bvh"]
