"""A character in its skin: the surface follows the joints, near triangles hide far ones, other rigs are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.core.mesh import Mesh
from kinestitch.core.rotation import quat_conjugate, quat_multiply, quat_rotate
from kinestitch.errors import InvalidMotionError, SkeletonMismatchError
from kinestitch.render.skinned import Character
from kinestitch.render.video import film, pictures
from kinestitch.samples import sample

CORNERS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
SIDES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def beads(skeleton, radius=0.06, shade=(1.0, 0.0, 0.0)) -> Mesh:
    """A small octahedron around every joint."""
    places, _ = rest_pose(skeleton)
    count = skeleton.joint_count
    vertices = (places[:, None] + radius * CORNERS).reshape(-1, 3)
    triangles = (np.arange(count)[:, None, None] * 6 + SIDES).reshape(-1, 3)
    weights = np.repeat(np.eye(count), 6, axis=0)
    colours = np.broadcast_to(np.array(shade), (len(triangles), 3))
    return Mesh(skeleton, vertices, np.tile(CORNERS, (count, 1)), triangles, weights, colours)


def test_the_surface_follows_the_joints():
    motion = sample("kick")
    mesh = beads(motion.skeleton)
    world, (_, rest) = world_pose(motion), rest_pose(motion.skeleton)
    for frame in (0, 60, 150):
        vertices, normals = Character(mesh).posed(motion, frame)
        turned = quat_multiply(world.rotations[frame], quat_conjugate(rest))[:, None]
        expected = world.positions[frame][:, None] + quat_rotate(turned, 0.06 * CORNERS[None])
        assert np.abs(vertices.reshape(expected.shape) - expected).max() < 1e-12
        assert np.allclose(normals.reshape(expected.shape), quat_rotate(turned, CORNERS[None]))


def test_the_rest_pose_is_the_mesh_itself():
    motion = sample("idle")
    body = motion.skeleton
    still = replace(motion, rotations=body.rest[None], translations=body.offsets[None])
    mesh = beads(body)
    assert np.abs(Character(mesh).posed(still, 0)[0] - mesh.vertices).max() < 1e-12


def test_it_stands_in_the_mannequins_place():
    motion = sample("walk")
    body = Character(beads(motion.skeleton))
    shown = next(pictures(film([motion, motion], size=(320, 200), bodies=[body, None]))).astype(int)
    red = (shown[..., 0] > shown[..., 1] + 60) & (shown[..., 1] < 30)
    assert red[:, :160].sum() > 200
    assert red[:, 160:].sum() == 0
    light = shown[..., 0][red]
    assert np.ptp(light) > 60  # lit from one side


def test_near_triangles_hide_far_ones():
    body = sample("idle").skeleton
    motion = replace(sample("idle"), rotations=body.rest[None], translations=body.offsets[None])
    one = beads(body, radius=0.1)
    deep = 0.3 * film(motion, view="front").panels[0].actor.camera.toward
    far, near = one.vertices - deep, one.vertices + deep
    both = Mesh(
        motion.skeleton,
        np.concatenate([near, far]),
        np.tile(one.normals, (2, 1)),
        np.concatenate([one.triangles, one.triangles + len(near)]),
        np.tile(one.weights, (2, 1)),
        np.concatenate([np.tile([1.0, 0, 0], (len(one.triangles), 1)), np.tile([0, 0, 1.0], (len(one.triangles), 1))]),
    )
    shown = next(pictures(film(motion, size=(320, 320), view="front", bodies=[Character(both)]))).astype(int)
    red = (shown[..., 0] > 60) & (shown[..., 2] < 20)
    blue = (shown[..., 2] > 60) & (shown[..., 0] < 20)
    assert red.sum() > 1000 > 100 * blue.sum()


def test_another_rig_is_refused():
    other = replace(sample("idle").skeleton, names=tuple(f"j{j}" for j in range(sample("idle").skeleton.joint_count)))
    with pytest.raises(SkeletonMismatchError, match="retarget"):
        Character(beads(other)).posed(sample("walk"), 0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"normals": np.zeros((2, 3))}, "normals"),
        ({"triangles": np.full((1, 3), 10**6), "colours": np.zeros((1, 3))}, "triangles"),
        ({"colours": np.zeros((2, 3))}, "colours"),
    ],
)
def test_a_mesh_fits_together(change, words):
    with pytest.raises(InvalidMotionError, match=words):
        replace(beads(sample("idle").skeleton), **change)


def test_weights_sum_to_one():
    mesh = beads(sample("idle").skeleton)
    with pytest.raises(InvalidMotionError, match="sum to 1"):
        replace(mesh, weights=mesh.weights * 0.5)
