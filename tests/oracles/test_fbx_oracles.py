"""FBX against two readers that share no code with ours: ufbx and Blender."""

import os
import warnings
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import local_from_world, world_pose
from kinestitch.core.rotation import matrix_to_quat, quat_conjugate, quat_distance, quat_multiply
from kinestitch.errors import FormatError, KinestitchWarning
from kinestitch.files.fbx import read_fbx, write_fbx
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
