"""Joints' local translations and rotations out of the scene, frame by frame, without scale."""

from __future__ import annotations

import numpy as np

from kinestitch.core.kinematics import local_from_world
from kinestitch.core.rotation import Array, quat_identity, quat_multiply, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.files.fbx.animation import LOCAL, Take
from kinestitch.files.fbx.bones import SCENE, ancestry, nearest_above
from kinestitch.files.fbx.curves import Ticks
from kinestitch.files.fbx.layers import property_values
from kinestitch.files.fbx.scene import Key, Scene
from kinestitch.files.fbx.transform import Local, World, local_transform, nearest_rotation, world_transform
from kinestitch.files.naming import unique_names


def needed_models(scene: Scene, joints: tuple[Key, ...]) -> list[Key]:
    """The joints and everything above them, parents first."""
    wanted = {above for joint in joints if joint != SCENE for above in ancestry(scene, joint)}
    return [key for key in scene.models if key in wanted]


def local_poses(scene: Scene, joints: tuple[Key, ...], take: Take | None, ticks: Ticks) -> tuple[Array, Array]:
    """Local translations (N, J, 3), the file's units, and rotations (N, J, 4), each on the nearest joint above.

    take : None for the pose that the models' own properties give
    """
    locals_: dict[Key, Local] = {}
    for key in needed_models(scene, joints):
        model = scene.models[key]
        locals_[key] = local_transform(model, *(property_values(take, model, name, ticks) for name in LOCAL))
    if all(local.rigid for local in locals_.values()):
        return _rigid(scene, joints, _with_scene(joints, locals_, len(ticks)))
    return _scaled(scene, joints, locals_, len(ticks))


def _with_scene(joints: tuple[Key, ...], locals_: dict[Key, Local], count: int) -> dict[Key, Local]:
    if SCENE not in joints:
        return locals_
    return {SCENE: Local(np.zeros((count, 3)), quat_identity((count,)), np.ones((count, 3))), **locals_}


def _rigid(scene: Scene, joints: tuple[Key, ...], locals_: dict[Key, Local]) -> tuple[Array, Array]:
    chosen = set(joints)
    translations, rotations = [], []
    for joint in joints:
        moved, turn = locals_[joint].translation, locals_[joint].rotation
        for above in ancestry(scene, joint)[1:]:
            if above in chosen:
                break
            moved = locals_[above].translation + quat_rotate(locals_[above].rotation, moved)
            turn = quat_multiply(locals_[above].rotation, turn)
        translations.append(moved)
        rotations.append(turn)
    return np.stack(translations, axis=1), np.stack(rotations, axis=1)


def _scaled(scene: Scene, joints: tuple[Key, ...], locals_: dict[Key, Local], count: int) -> tuple[Array, Array]:
    worlds: dict[Key, World] = {}
    for key, local in locals_.items():
        above = scene.parents.get(key)
        parent = worlds[above] if above is not None else None
        inherit = scene.models[key].integer("InheritType")
        worlds[key] = world_transform(local, parent, None if above is None else locals_[above], inherit)
    if SCENE in joints:
        worlds[SCENE] = World(np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1)), quat_identity((count,)))
    positions = np.stack([worlds[joint].position for joint in joints], axis=1)
    rotations = np.stack([worlds[joint].rotation() for joint in joints], axis=1)
    translations, turns = local_from_world(bare_skeleton(scene, joints), positions, rotations)
    still = np.ptp(translations, axis=0).max(axis=-1) <= 1e-9 * (1 + np.abs(translations).max(axis=(0, 2)))
    translations[:, still] = translations[:1, still]  # what scale left constant but for rounding
    return translations, turns


def bare_skeleton(scene: Scene, joints: tuple[Key, ...]) -> Skeleton:
    """Names and parents of the joints, with no rest pose."""
    index = {joint: i for i, joint in enumerate(joints)}
    above = [nearest_above(scene, joint, index) for joint in joints]
    parents = tuple(-1 if key is None else index[key] for key in above)
    names, _ = unique_names([joint_name(scene, joint) for joint in joints])
    return Skeleton(tuple(names), parents, np.zeros((len(joints), 3)))


def joint_name(scene: Scene, joint: Key) -> str:
    """The name in the file; ``Root`` for the joint that stands for the scene."""
    return "Root" if joint == SCENE else scene.models[joint].name


def bind_poses(
    joints: tuple[Key, ...], parents: tuple[int, ...], matrices: dict[Key, Array], default: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Local rest translations (J, 3) and rotations (J, 4) from world matrices, by default from a local pose."""
    skeleton = Skeleton(tuple(str(i) for i in range(len(joints))), parents, np.zeros((len(joints), 3)))
    positions, rotations = np.empty((len(joints), 3)), np.empty((len(joints), 4))
    for j, (joint, parent) in enumerate(zip(joints, parents, strict=True)):
        matrix = matrices.get(joint)
        if matrix is not None:
            positions[j] = matrix[:3, 3]
            rotations[j] = nearest_rotation(matrix[None, :3, :3])[0]
        elif parent < 0:
            positions[j], rotations[j] = default[0][j], default[1][j]
        else:
            positions[j] = positions[parent] + quat_rotate(rotations[parent], default[0][j])
            rotations[j] = quat_multiply(rotations[parent], default[1][j])
    return local_from_world(skeleton, positions, rotations)
