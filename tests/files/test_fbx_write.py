"""FBX written and read back."""

import math
from dataclasses import replace

import numpy as np
import pytest

import kinestitch.files
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import euler_to_quat, quat_distance, quat_identity
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import FormatError, KinestitchError, OutputError
from kinestitch.files.fbx import list_takes, read_fbx, write_fbx
from kinestitch.files.fbx.euler import continuous_degrees
from kinestitch.files.fbx.transform import euler_quat
from kinestitch.testing import assert_motion_close, check_motion, random_motion

RATES = (24.0, 25.0, 30000 / 1001, 29.97, 30.0, 60.0, 120.0, 24000 / 1001, 23.976, 37.3, 1000 / 3, 1.0)


def there_and_back(motion, tmp_path):
    write_fbx(motion, tmp_path / "clip.fbx")
    again = read_fbx(tmp_path / "clip.fbx")
    check_motion(again)
    return again


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("bend", [0.6, 3.3])
def test_a_random_motion_survives(fps, bend, tmp_path):
    motion = random_motion(7, joints=9, frames=60, fps=fps, bend=bend, skeleton_seed=3)
    again = there_and_back(motion, tmp_path)
    assert_motion_close(again, motion, degrees=1e-3, metres=1e-6)
    assert math.isclose(again.fps, fps, rel_tol=1e-9)
    assert np.degrees(quat_distance(again.skeleton.rest, motion.skeleton.rest)).max() < 1e-5
    assert np.abs(again.skeleton.offsets - motion.skeleton.offsets).max() < 1e-9
    assert again.name == "clip"


def test_gimbal_lock_survives(tmp_path):
    angles = np.zeros((90, 2, 3))
    angles[:, 0, 1] = np.pi / 2
    angles[:, 0, 0] = np.linspace(0, 3, 90)
    angles[:, 1] = np.linspace([0, 0, 0], [7, 12, -9], 90)
    angles[40:50, 1, 1] = -np.pi / 2
    skeleton = Skeleton(("a", "b"), (-1, 0), np.array([[0, 1.0, 0], [0, 0.5, 0]]))
    motion = Motion(skeleton, np.broadcast_to(skeleton.offsets, (90, 2, 3)), euler_to_quat(angles, "ZYX"), 30)
    assert_motion_close(there_and_back(motion, tmp_path), motion, degrees=1e-4, metres=1e-9)


def test_euler_angles_do_not_jump_where_the_rotation_does_not():
    time = np.linspace(0, 4 * np.pi, 600)[:, None]
    angles = np.concatenate([time, 1.4 * np.sin(time), 0.3 * time], axis=1)[:, None]
    degrees = continuous_degrees(euler_to_quat(angles[..., ::-1], "ZYX"))
    assert np.abs(np.diff(degrees, axis=0)).max() < 10
    assert np.degrees(quat_distance(euler_quat(degrees, 0), euler_to_quat(angles[..., ::-1], "ZYX"))).max() < 1e-6


def test_a_thousand_turns_stay_exact(tmp_path):
    angles = np.zeros((4000, 1, 3))
    angles[:, 0, 0] = np.linspace(0, 2000 * np.pi, 4000)
    angles[:, 0, 2] = 0.3
    skeleton = Skeleton(("spinner",), (-1,), np.zeros((1, 3)))
    motion = Motion(skeleton, np.zeros((4000, 1, 3)), euler_to_quat(angles, "ZYX"), 30)
    assert_motion_close(there_and_back(motion, tmp_path), motion, degrees=1e-3, metres=1e-9)


def test_a_still_clip_keeps_its_length_and_its_pose(tmp_path):
    motion = random_motion(2, joints=5, frames=1)
    still = replace(
        motion, translations=np.repeat(motion.translations, 20, 0), rotations=np.repeat(motion.rotations, 20, 0)
    )
    assert_motion_close(there_and_back(still, tmp_path), still, degrees=1e-4, metres=1e-6)
    assert_motion_close(there_and_back(motion, tmp_path), motion, degrees=1e-4, metres=1e-6)


def test_one_joint_and_odd_names(tmp_path):
    skeleton = Skeleton(("mixamorig:Hips", 'Finger "1" é漢', "a::b"), (-1, 0, 1), np.ones((3, 3)))
    motion = Motion(skeleton, np.broadcast_to(skeleton.offsets, (3, 3, 3)), quat_identity((3, 3)), 30)
    assert there_and_back(motion, tmp_path).skeleton.names == skeleton.names
    alone = random_motion(1, joints=1)
    assert_motion_close(there_and_back(alone, tmp_path), alone, degrees=1e-4, metres=1e-6)


def test_far_travel_and_moving_joints_survive(tmp_path):
    motion = random_motion(4, joints=6, frames=50)
    moved = motion.translations + np.random.default_rng(0).normal(size=motion.translations.shape) * 0.05
    moved[:, 0, 0] += 500
    far = replace(motion, translations=moved)
    assert_motion_close(there_and_back(far, tmp_path), far, degrees=1e-4, metres=1e-4)


def test_the_take_carries_a_name(tmp_path):
    motion = random_motion(1)
    write_fbx(motion, tmp_path / "a.fbx")
    assert list_takes(tmp_path / "a.fbx") == (motion.name,)
    kinestitch.files.write(motion, tmp_path / "b.fbx", take="walk")
    assert list_takes(tmp_path / "b.fbx") == ("walk",)
    assert kinestitch.files.read(tmp_path / "b.fbx", take="walk").frames == motion.frames
    with pytest.raises(KinestitchError, match=r"'walk'.*'run'"):
        read_fbx(tmp_path / "b.fbx", take="run")


def test_equal_motions_give_equal_files(tmp_path):
    for name in ("a.fbx", "b.fbx"):
        write_fbx(random_motion(1), tmp_path / name)
    assert (tmp_path / "a.fbx").read_bytes() == (tmp_path / "b.fbx").read_bytes()


def test_a_missing_folder_is_one_clear_error(tmp_path):
    with pytest.raises(OutputError):
        write_fbx(random_motion(1), tmp_path / "no" / "a.fbx")


def test_damaged_files_raise_nothing_but_our_errors(tmp_path):
    path = tmp_path / "clip.fbx"
    write_fbx(random_motion(3, joints=3, frames=8), path)
    data = path.read_bytes()
    rng = np.random.default_rng(5)
    faults = []
    for trial in range(250):
        damaged = bytearray(data if trial % 5 else data[: int(rng.integers(len(data)))])
        for at in rng.integers(0, max(len(damaged), 1), int(rng.integers(1, 6))):
            if damaged:
                damaged[at] = int(rng.integers(256))
        path.write_bytes(bytes(damaged))
        try:
            check_motion(read_fbx(path))
        except FormatError as error:
            faults.append(str(error))
    assert len(faults) > 50
    assert all(fault.endswith(f"({path})") and "\n" not in fault for fault in faults)
