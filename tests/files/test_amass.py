"""AMASS: files made here, as the published ones are laid out; there and back; damaged files."""

import contextlib
import io
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.core.kinematics import rest_pose, with_joint_axes, world_pose
from kinestitch.core.mirror import mirror
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance, quat_identity, quat_rotate, rotvec_to_quat
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import FormatError, KinestitchError, ParameterError, SkeletonMismatchError
from kinestitch.files.amass import read_amass, write_amass
from kinestitch.files.smpl import BODY, LAYOUTS, skeleton_of
from kinestitch.testing import assert_motion_close, check_motion

WIDTHS = {"SMPL body": 66, "SMPL": 72, "SMPL-H": 156, "SMPL-X": 165}


def arrays(width=156, frames=5, **changes):
    rng = np.random.default_rng(0)
    poses = rng.normal(scale=0.3, size=(frames, width))
    poses[:, :3] = [np.pi / 2, 0, 0]  # a body of Y up, stood up in a world of Z up
    return {
        "poses": poses,
        "trans": np.tile([1.0, 2.0, 1.2], (frames, 1)),
        "mocap_framerate": np.float64(120.0),
        "gender": np.array("female"),
        "betas": np.ones(16),
        "dmpls": np.zeros((frames, 8)),
    } | changes


def save(path, **content):
    np.savez(path, **{key: value for key, value in content.items() if value is not None})
    return path


@pytest.mark.parametrize(("name", "width"), WIDTHS.items())
def test_length_of_a_pose_tells_the_model(tmp_path, name, width):
    motion = read_amass(save(tmp_path / "walk_poses.npz", **arrays(width)))
    check_motion(motion)
    layout = next(entry for entry in LAYOUTS if entry.name == name)
    assert motion.skeleton.names == layout.names
    assert (motion.frames, motion.fps, motion.name) == (5, 120.0, "walk_poses")
    assert motion.skeleton.names[:22] == BODY


def test_angles_are_rotation_vectors_and_the_world_is_turned_upright(tmp_path):
    content = arrays()
    motion = read_amass(save(tmp_path / "a.npz", **content))
    own = rotvec_to_quat(content["poses"].reshape(5, 52, 3))
    assert quat_distance(motion.rotations[:, 1:], own[:, 1:]).max() < 1e-12
    assert quat_distance(motion.rotations[:, 0], quat_identity((5,))).max() < 1e-12
    x, y, z = LAYOUTS[1].pelvis
    np.testing.assert_allclose(motion.translations[0, 0], [1.0 + x, 1.2 + z, -(2.0 + y)], atol=1e-12)
    upright = read_amass(save(tmp_path / "b.npz", **content), up="y")
    np.testing.assert_allclose(upright.translations[0, 0], [1.0 + x, 2.0 + y, 1.2 + z], atol=1e-12)


def test_the_mean_body_is_a_standing_person_in_a_t_pose():
    for layout in LAYOUTS:
        skeleton, _ = skeleton_of(layout)
        places, _ = rest_pose(skeleton)
        at = dict(zip(skeleton.names, places, strict=True))
        assert places[:, 1].min() == pytest.approx(0.0, abs=1e-12)
        assert 0.85 < at["pelvis"][1] < 1.0
        assert 1.4 < at["head"][1] < 1.6
        assert at["left_wrist"][0] - at["right_wrist"][0] == pytest.approx(1.35, abs=0.06)
        assert abs(at["left_wrist"][1] - at["left_shoulder"][1]) < 0.06
        assert at["left_foot"][2] - at["left_ankle"][2] > 0.1
        assert all(0 <= parent < joint for joint, parent in enumerate(skeleton.parents) if joint)
        for name, place in at.items():
            if name.startswith("left_"):
                np.testing.assert_allclose(at[name.replace("left_", "right_")], place * [-1, 1, 1], atol=1e-12)


def test_parts_of_a_pose_instead_of_the_whole(tmp_path):
    whole = arrays(165)
    cuts = {
        "root_orient": (0, 3),
        "pose_body": (3, 66),
        "pose_jaw": (66, 69),
        "pose_eye": (69, 75),
        "pose_hand": (75, 165),
    }
    parts = {key: whole["poses"][:, slice(*cut)] for key, cut in cuts.items()}
    apart = save(tmp_path / "a.npz", **(whole | parts | {"poses": None}))
    assert_motion_close(read_amass(apart), replace(read_amass(save(tmp_path / "b.npz", **whole)), name="a"))
    parts["pose_hand"] = parts["pose_hand"][:3]
    with pytest.raises(FormatError, match="as many frames in every part"):
        read_amass(save(tmp_path / "c.npz", **(whole | parts | {"poses": None})))


def test_a_file_with_joints_has_its_own_body(tmp_path):
    own = np.random.default_rng(1).normal(size=(52, 3))
    motion = read_amass(save(tmp_path / "a.npz", **arrays(J=own)))
    np.testing.assert_allclose(motion.skeleton.offsets[4], own[4] - own[1])
    positions = world_pose(motion).positions
    np.testing.assert_allclose(
        np.linalg.norm(positions[:, 5] - positions[:, 2], axis=-1), np.linalg.norm(own[5] - own[2])
    )
    np.testing.assert_allclose(
        motion.translations[0, 0], quat_rotate(rotvec_to_quat([-np.pi / 2, 0, 0]), own[0] + [1, 2, 1.2])
    )


@pytest.mark.parametrize("key", ["mocap_framerate", "mocap_frame_rate", "fps"])
def test_names_of_the_rate(tmp_path, key):
    content = arrays(mocap_framerate=None) | {key: np.array([59.99])}
    assert read_amass(save(tmp_path / "a.npz", **content)).fps == 60.0


def test_a_rate_can_be_said(tmp_path):
    path = save(tmp_path / "a.npz", **arrays(mocap_framerate=None))
    assert read_amass(path, fps=25).fps == 25.0
    with pytest.raises(FormatError, match=r"Pass fps="):
        read_amass(path)
    for options in ({"fps": 0}, {"fps": np.inf}, {"up": "x"}):
        with pytest.raises(ParameterError):
            read_amass(path, **options)


@pytest.mark.parametrize("name", ["SMPL", "SMPL-H", "SMPL-X"])
def test_there_and_back(tmp_path, name):
    motion = read_amass(save(tmp_path / "a.npz", **arrays(WIDTHS[name])))
    write_amass(motion, tmp_path / "b.npz")
    assert_motion_close(read_amass(tmp_path / "b.npz"), motion, degrees=1e-9, metres=1e-12)
    other = np.load(tmp_path / "b.npz", allow_pickle=False)
    assert {"poses", "trans", "gender", "betas", "dmpls", "mocap_framerate"} <= set(other.files)
    assert other["poses"].shape == (5, WIDTHS[name])
    np.testing.assert_allclose(other["trans"][0], [1, 2, 1.2], atol=1e-12)


def test_a_body_of_its_own_comes_back(tmp_path):
    skeleton, _ = skeleton_of(LAYOUTS[1])
    rng = np.random.default_rng(2)
    taller = replace(skeleton, offsets=skeleton.offsets * 1.1)
    rotations = rotvec_to_quat(rng.normal(size=(7, 52, 3)))
    translations = np.tile(taller.offsets, (7, 1, 1))
    motion = Motion(taller, translations, rotations, 30.0)
    write_amass(motion, tmp_path / "a.npz")
    assert_motion_close(read_amass(tmp_path / "a.npz"), motion, degrees=1e-6, metres=1e-12)
    turned = with_joint_axes(motion, rotvec_to_quat(rng.normal(size=(52, 3))))
    write_amass(turned, tmp_path / "b.npz")
    assert_motion_close(read_amass(tmp_path / "b.npz"), motion, degrees=1e-6, metres=1e-12)


def test_joints_in_another_order_find_their_places(tmp_path):
    motion = read_amass(save(tmp_path / "a.npz", **arrays(66)))
    order = [0, 3, 6, 9, 12, 15, 14, 17, 19, 21, 13, 16, 18, 20, 2, 5, 8, 11, 1, 4, 7, 10]
    old = motion.skeleton
    parents = tuple(-1 if old.parents[j] < 0 else order.index(old.parents[j]) for j in order)
    shuffled = Skeleton(tuple(old.names[j] for j in order), parents, old.offsets[order])
    write_amass(Motion(shuffled, motion.translations[:, order], motion.rotations[:, order], 120.0), tmp_path / "b.npz")
    again = read_amass(tmp_path / "b.npz")
    assert again.skeleton.joint_count == 52
    np.testing.assert_allclose(again.translations[:, :22], motion.translations, atol=1e-12)
    assert quat_distance(again.rotations[:, :22], motion.rotations).max() < 1e-12


def test_a_mirrored_clip_can_be_written(tmp_path):
    motion = mirror(read_amass(save(tmp_path / "a.npz", **arrays())))
    write_amass(motion, tmp_path / "b.npz")
    assert_motion_close(read_amass(tmp_path / "b.npz"), motion, degrees=1e-6, metres=1e-9)


def test_other_skeletons_are_refused(tmp_path):
    motion = read_amass(save(tmp_path / "a.npz", **arrays(66)))
    old = motion.skeleton

    def fails(skeleton, message):
        with pytest.raises(SkeletonMismatchError, match=message):
            write_amass(replace(motion, skeleton=skeleton), tmp_path / "b.npz")

    fails(replace(old, names=("Hips", *old.names[1:])), "without pelvis.*Retarget")
    below = tuple(3 if name == "left_hip" else parent for name, parent in zip(old.names, old.parents, strict=True))
    with pytest.raises(KinestitchError):
        fails(replace(old, parents=below), "Expected 'left_hip' below 'pelvis'")
    below = tuple(1 if name == "spine1" else parent for name, parent in zip(old.names, old.parents, strict=True))
    fails(replace(old, parents=below), "Expected 'spine1' below 'pelvis', got it below 'left_hip'")
    hanging = old.offsets.copy()
    hanging[old.index("left_elbow")] = [0.05, -0.25, 0]
    fails(replace(old, offsets=hanging), "left_elbow 7.° off")
    assert not (tmp_path / "b.npz").exists()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"poses": None}, "Expected an array 'poses', got none. Is this an AMASS file"),
        ({"trans": None}, "Expected an array 'trans'"),
        ({"poses": np.zeros((5, 100))}, "Expected poses of 72, 156, 165, 66 numbers a frame, got 100"),
        ({"poses": np.zeros((0, 156)), "trans": np.zeros((0, 3))}, "at least one frame"),
        ({"poses": np.zeros(156)}, r"Expected numbers of shape \(n, n\) in 'poses'"),
        ({"poses": np.full((5, 156), np.nan)}, "finite numbers"),
        ({"poses": np.full((5, 156), 1e300)}, "finite numbers"),
        ({"poses": np.full((5, 156), "a")}, "Expected numbers"),
        ({"poses": np.full((5, 156), None)}, "Object arrays cannot be loaded"),
        ({"trans": np.zeros((4, 3))}, r"Expected numbers of shape \(5, 3\) in 'trans'"),
        ({"trans": np.full((5, 3), np.inf)}, "finite numbers"),
        ({"mocap_framerate": np.float64(0)}, "Expected a frame rate > 0 in 'mocap_framerate', got 0.0"),
        ({"mocap_framerate": np.array("fast")}, "Expected a frame rate > 0"),
        ({"mocap_framerate": np.zeros(0)}, "Expected a frame rate > 0"),
        ({"J": np.full((52, 3), np.nan)}, "finite numbers below 1e.06 in 'J'"),
    ],
)
def test_other_arrays(tmp_path, changes, message):
    with pytest.raises(FormatError, match=message) as caught:
        read_amass(save(tmp_path / "a.npz", **arrays(**changes)))
    assert str(caught.value).endswith("a.npz)")
    assert "\n" not in str(caught.value)


def test_not_an_archive(tmp_path):
    for data in (b"", b"PK", b"hello", b"\x93NUMPY"):
        (tmp_path / "a.npz").write_bytes(data)
        with pytest.raises(FormatError):
            read_amass(tmp_path / "a.npz")
    with (tmp_path / "a.npz").open("wb") as stream:
        np.save(stream, np.zeros((5, 156)))
    with pytest.raises(FormatError):
        read_amass(tmp_path / "a.npz")
    with pytest.raises(FileNotFoundError):
        read_amass(tmp_path / "b.npz")


def test_a_bomb_is_not_unpacked(tmp_path):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10**5, 156)})
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("poses.npy", header.getvalue() + bytes(8 * 156 * 10**5))
    with pytest.raises(FormatError, match="Expected arrays that fit a file of"):
        read_amass(tmp_path / "a.npz")


@given(where=st.integers(0, 10**6), what=st.binary(max_size=8), cut=st.integers(0, 60))
def test_random_damage_raises_only_our_errors(tmp_path_factory, where, what, cut):
    folder = tmp_path_factory.mktemp("damage")
    data = save(folder / "a.npz", **arrays(66, frames=2, dmpls=None)).read_bytes()
    at = where % len(data)
    (folder / "a.npz").write_bytes(data[:at] + what + data[at + cut :])
    with contextlib.suppress(KinestitchError):
        check_motion(read_amass(folder / "a.npz"))
