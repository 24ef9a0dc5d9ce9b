"""FBX against two readers that share no code with ours: ufbx and Blender."""

import os
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import local_from_world, world_pose
from kinestitch.core.rotation import (
    matrix_to_quat,
    quat_conjugate,
    quat_distance,
    quat_multiply,
    quat_normalize,
    rotvec_to_quat,
)
from kinestitch.errors import FormatError, KinestitchWarning
from kinestitch.files.fbx import PRESETS, read_fbx, write_fbx
from kinestitch.files.fbx.bones import choose_joints
from kinestitch.files.fbx.curves import TICKS
from kinestitch.files.fbx.frames import frame_ticks
from kinestitch.files.fbx.pose import needed_models
from kinestitch.files.fbx.read import choose_take, read_document, takes_of
from kinestitch.files.fbx.scene import Scene
from kinestitch.testing import random_motion

pytestmark = pytest.mark.oracle

DEGREES, METRES = 0.01, 1e-4
CLIPS = (
    "mixamo_xbot_60fps/Walking.fbx",
    "mixamo_xbot_60fps/Kicking.fbx",
    "mixamo_xbot_60fps/Running Jump.fbx",
    "mixamo_xbot_30fps/Cheering.fbx",
    "mixamo_xbot_30fps/Burpee.fbx",
    "mixamo_ybot_60fps/Roundhouse Kick.fbx",
    "mixamo_prefix8/falling to roll.fbx",
    "mixamo_other_rigs/fbx7400_Front Kick.fbx",
    "mixamo_other_rigs/readyplayerme_Kicking.fbx",
    "mixamo_other_rigs/mario_Slow Run.fbx",
)


@pytest.fixture(scope="module")
def clips():
    home = os.environ.get("KINESTITCH_DATA")
    if not home:
        pytest.skip("KINESTITCH_DATA is unset: no real clips")
    paths = [Path(home) / name for name in CLIPS]
    return [(path, read_fbx(path)) for path in paths]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Files of our own writer, no clip needed: random motions over the whole rotation group, at awkward rates."""
    folder = tmp_path_factory.mktemp("written")
    made = []
    for seed, fps, bend in ((1, 30.0, 0.6), (2, 29.97, 3.2), (3, 120.0, 3.2)):
        path = folder / f"random{seed}.fbx"
        write_fbx(random_motion(seed, joints=12, frames=50, fps=fps, bend=bend, skeleton_seed=seed), path)
        made.append((path, random_motion(seed, joints=12, frames=50, fps=fps, bend=bend, skeleton_seed=seed)))
    return made


def requests(pairs):
    return [{"path": path, "start": 0.0, "fps": motion.fps, "frames": motion.frames} for path, motion in pairs]


def columns(motion, answer):
    assert "error" not in answer, answer["error"]
    names = list(answer["names"])
    return [names.index(name) for name in motion.skeleton.names]


def assert_like_ufbx(motion, answer):
    pick = columns(motion, answer)
    turned = quat_distance(motion.rotations[:, 1:], answer["rotations"][:, pick][:, 1:])
    assert np.degrees(turned).max() <= DEGREES
    moved = np.linalg.norm(world_pose(motion).positions - answer["positions"][:, pick], axis=-1)
    assert moved.max() <= METRES
    world = answer["matrices"][:, pick] / np.linalg.norm(answer["matrices"][:, pick], axis=-2, keepdims=True)
    assert np.degrees(quat_distance(world_pose(motion).rotations, matrix_to_quat(world))).max() <= DEGREES


def assert_like_blender(motion, answer):
    """Blender turns bone axes, so its rotations are told in ours by what both have at frame 0."""
    pick = columns(motion, answer)
    pose = world_pose(motion)
    moved = np.linalg.norm(pose.positions - answer["positions"][:, pick], axis=-1)
    assert moved.max() <= METRES
    theirs = matrix_to_quat(answer["rotations"][:, pick])
    told = quat_multiply(quat_multiply(theirs, quat_conjugate(theirs[:1])), pose.rotations[:1])
    local = local_from_world(motion.skeleton, answer["positions"][:, pick], told)[1]
    assert np.degrees(quat_distance(motion.rotations, local)).max() <= DEGREES


def test_ufbx_sees_the_same_in_ten_clips(clips, ask_ufbx):
    for (_, motion), answer in zip(clips, ask_ufbx(requests(clips)), strict=True):
        assert_like_ufbx(motion, answer)


def test_blender_sees_the_same_in_ten_clips(clips, ask_blender):
    for (_, motion), answer in zip(clips, ask_blender(requests(clips)), strict=True):
        assert_like_blender(motion, answer)


def test_ufbx_reads_what_we_write(written, ask_ufbx):
    for (_, motion), answer in zip(written, ask_ufbx(requests(written)), strict=True):
        assert_like_ufbx(motion, answer)


def test_blender_reads_what_we_write(written, ask_blender):
    for (_, motion), answer in zip(written, ask_blender(requests(written)), strict=True):
        assert_like_blender(motion, answer)
        assert abs(answer["fps"] - motion.fps) < 1e-3


def conformance_files():
    home = os.environ.get("KINESTITCH_DATA")
    return sorted((Path(home) / "conformance_fbx").glob("*.fbx")) if home else []


# where a step changes just after a key, ufbx rounds the time of that very key past it
STEPS_ON_THE_KEY = ("interpolation_modes", "late_stepped_tangents")


def test_ufbx_places_every_joint_of_the_conformance_files_alike(ask_ufbx):
    """Pivots, inherited scale, layers, tangents, extrapolation, FBX 5 to 7.7, text and binary."""
    asked = []
    for path in conformance_files():
        try:
            motion, start = read_with_start(path)
        except FormatError:
            continue
        asked.append(({"path": path, "start": start, "fps": motion.fps, "frames": motion.frames}, motion))
    if not asked:
        pytest.skip("KINESTITCH_DATA is unset: no conformance files")
    assert len(asked) > 130
    for (request, motion), answer in zip(asked, ask_ufbx([request for request, _ in asked]), strict=True):
        names = list(answer["names"])
        shared = [j for j, name in enumerate(motion.skeleton.names) if name in names]
        theirs = answer["positions"][:, [names.index(motion.skeleton.names[j]) for j in shared]]
        moved = np.linalg.norm(world_pose(motion).positions[:, shared] - theirs, axis=-1)
        allowed = 3 if any(name in request["path"].name for name in STEPS_ON_THE_KEY) else 0
        assert (moved.max(axis=1) > METRES).sum() <= allowed, f"{request['path'].name}: {moved.max()} m"


def read_with_start(path):
    """A motion and the time of its first key in s."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        motion = read_fbx(path)
    scene = Scene(read_document(path))
    take = choose_take(takes_of(scene))
    models = needed_models(scene, choose_joints(scene, take))
    return motion, frame_ticks(take, models, scene.fps)[0][0] / TICKS


def test_both_read_a_clip_that_we_wrote_anew(clips, ask_ufbx, ask_blender, tmp_path):
    again = []
    for path, motion in clips[1:4]:
        write_fbx(motion, tmp_path / path.name)
        again.append((tmp_path / path.name, motion))
    for (_, motion), ufbx, blender in zip(again, ask_ufbx(requests(again)), ask_blender(requests(again)), strict=True):
        assert_like_ufbx(motion, ufbx)
        assert_like_blender(motion, blender)


KEPT = (
    "mixamo_skinned/Samba Dancing.fbx",
    "mixamo_skinned/X Bot.fbx",
    "mixamo_skinned/X Bot Fast Run.fbx",
    "mixamo_other_rigs/mario_Jumping Jacks.fbx",
    "mixamo_other_rigs/mario_Slow Run.fbx",
    "mixamo_other_rigs/readyplayerme_Kicking.fbx",
    "mixamo_xbot_60fps/Walking.fbx",
    "ue_mannequin/MCU_am_OrcHammer_Loco_Walk_Fwd.FBX",
    "conformance_fbx/assimp_huesitos.fbx",
    "conformance_fbx/ufbx_blender_279_bone_radius_7400_binary.fbx",
    "conformance_fbx/ufbx_blender_293_half_skinned_7400_binary.fbx",
    "conformance_fbx/ufbx_max_transformed_skin_7500_binary.fbx",
    "conformance_fbx/ufbx_maya_advanced_skinned_pivot_7700_binary.fbx",
    "conformance_fbx/ufbx_maya_anim_layers_over_acc_7500_binary.fbx",
    "conformance_fbx/ufbx_maya_null_pivots_7700_binary.fbx",
    "conformance_fbx/ufbx_maya_pivot_offset_7700_binary.fbx",
    "conformance_fbx/ufbx_maya_split_pivot_7700_binary.fbx",
    "conformance_fbx/ufbx_maya_transformed_skin_7700_binary.fbx",
)
NO_BONES = ("layers", "null_pivots", "pivot_offset", "split_pivot")  # Blender makes no armature of them


def another(motion, frames, fps):
    """A motion of the same skeleton that swings every joint and carries the root about."""
    rng = np.random.default_rng(frames)
    time = np.arange(frames)[:, None, None] / fps
    joints = motion.skeleton.joint_count
    swing = rng.normal(size=(joints, 3)) * 0.5 * np.sin(2 * time + rng.uniform(0, 6, size=(joints, 3)))
    translations = np.repeat(motion.translations[:1], frames, axis=0)
    translations[:, 0] += 0.1 * np.sin(time[:, 0] * np.array([1.0, 2.0, 3.0]))
    rotations = quat_normalize(quat_multiply(motion.rotations[:1], rotvec_to_quat(swing)))
    return replace(motion, translations=translations, rotations=rotations, fps=fps)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Files with their characters and other motions in them: longer, at another rate; and what was meant."""
    home = os.environ.get("KINESTITCH_DATA")
    if not home:
        pytest.skip("KINESTITCH_DATA is unset: no characters")
    folder = tmp_path_factory.mktemp("kept")
    made = []
    for i, name in enumerate(KEPT):
        motion = another(read_fbx(Path(home) / name), 40 + i, (24.0, 30.0, 60.0)[i % 3])
        path = folder / Path(name).name
        write_fbx(motion, path, like=Path(home) / name)
        made.append((path, motion))
    return made


def starts(pairs):
    """Requests that say which take, and when it starts."""
    rows = []
    for (path, _), row in zip(pairs, requests(pairs), strict=True):
        take = choose_take(takes_of(Scene(read_document(path)))).name
        rows.append({**row, "start": read_with_start(path)[1], "take": take})
    return rows


def shared_joints(motion, answer):
    assert "error" not in answer, answer["error"]
    names = list(answer["names"])
    own = [j for j, name in enumerate(motion.skeleton.names) if name in names]
    assert len(own) >= motion.skeleton.joint_count - 1
    return own, [names.index(motion.skeleton.names[j]) for j in own]


def test_ufbx_sees_another_motion_in_a_kept_character(kept, ask_ufbx):
    for (path, motion), answer in zip(kept, ask_ufbx(starts(kept)), strict=True):
        own, theirs = shared_joints(motion, answer)
        pose = world_pose(motion)
        moved = np.linalg.norm(pose.positions[:, own] - answer["positions"][:, theirs], axis=-1)
        assert moved.max() <= METRES, f"{path.name}: {moved.max()} m"
        world = answer["matrices"][:, theirs]
        size = np.cbrt(np.linalg.det(world))[..., None, None]
        plain = world / size
        rigid = np.abs(np.swapaxes(plain, -1, -2) @ plain - np.eye(3)).max(axis=(0, -2, -1)) < 1e-4
        rigid &= (size > 0).all(axis=(0, 2, 3))
        turned = np.degrees(quat_distance(pose.rotations[:, own], matrix_to_quat(plain)))[:, rigid]
        assert turned.max(initial=0) <= DEGREES, f"{path.name}: {turned.max()} degrees"


def test_blender_sees_another_motion_in_a_kept_character(kept, ask_blender):
    armatures = [(path, motion) for path, motion in kept if not any(name in path.name for name in NO_BONES)]
    for (path, motion), answer in zip(armatures, ask_blender(requests(armatures)), strict=True):
        own, theirs = shared_joints(motion, answer)
        moved = np.linalg.norm(world_pose(motion).positions[:, own] - answer["positions"][:, theirs], axis=-1)
        assert moved.max() <= METRES, f"{path.name}: {moved.max()} m"


@pytest.fixture(scope="module")
def preset_files(tmp_path_factory):
    """One random motion as every program likes it."""
    motion = random_motion(5, joints=12, frames=40, fps=30.0, bend=1.5, skeleton_seed=5)
    made = []
    for name in PRESETS:
        path = tmp_path_factory.mktemp("presets") / f"{name}.fbx"
        write_fbx(motion, path, preset=name)
        made.append((path, motion))
    return made


def test_presets_change_nothing_that_ufbx_sees(preset_files, ask_ufbx):
    for (path, motion), answer in zip(preset_files, ask_ufbx(requests(preset_files)), strict=True):
        pick = columns(motion, answer)
        moved = np.linalg.norm(world_pose(motion).positions - answer["positions"][:, pick], axis=-1)
        assert moved.max() <= METRES, path.name


def test_presets_change_nothing_that_blender_sees(preset_files, ask_blender):
    for (path, motion), answer in zip(preset_files, ask_blender(requests(preset_files)), strict=True):
        pick = columns(motion, answer)
        moved = np.linalg.norm(world_pose(motion).positions - answer["positions"][:, pick], axis=-1)
        assert moved.max() <= METRES, path.name
        plain = np.allclose(answer["armature"], np.eye(4), atol=1e-6)
        assert plain == (path.stem == "blender")
