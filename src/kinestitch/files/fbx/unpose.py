"""From where joints stand to what a file's models have to say: pose.py and transform.py backwards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, matrix_to_quat, quat_distance, quat_to_matrix
from kinestitch.errors import FormatError
from kinestitch.files.fbx.animation import LOCAL, Take
from kinestitch.files.fbx.axes import from_y_up_metres
from kinestitch.files.fbx.euler import continuous_degrees
from kinestitch.files.fbx.layers import property_values
from kinestitch.files.fbx.pose import needed_models
from kinestitch.files.fbx.scene import Key, Scene
from kinestitch.files.fbx.transform import (
    Local,
    World,
    animated_values,
    local_transform,
    rotation_order,
    world_transform,
)

_CLOSE = 1e-7  # rad
_FAR = 1e-4  # rad
_ROUNDS = 60


@dataclass(frozen=True, slots=True, eq=False)
class Said:
    """What a take has to say about one model, the file's units and degrees; None where a still value is kept.

    translation, rotation : (F, 3) of a joint
    still : (3, 3) translation, Euler angles and scale at the take's first frame
    """

    still: Array
    translation: Array | None = None
    rotation: Array | None = None


def said_by(scene: Scene, joints: tuple[Key, ...], take: Take | None, start: int, motion: Motion) -> dict[Key, Said]:
    """What the joints, and everything above them, have to say so that they move like `motion`.

    start : tick of the take's first frame, at which scale and what is no joint stand still
    motion : on the skeleton that the reader makes of `joints`, in metres with Y up

    Raises FormatError where no rotation does: scale of 0 above a joint, or so uneven that it shears joints too far.
    """
    moved, turned = from_y_up_metres(motion.translations, motion.rotations, scene.axes, scene.metres_per_unit)
    pose = world_pose(Motion(motion.skeleton, moved, turned, motion.fps))
    index = {joint: i for i, joint in enumerate(joints)}
    first = np.array([start], dtype=np.int64)
    locals_: dict[Key, Local] = {}
    worlds: dict[Key, World] = {}
    found: dict[Key, Said] = {}
    for key in needed_models(scene, joints):
        model = scene.models[key]
        still = np.concatenate([property_values(take, model, name, first) for name in LOCAL])
        spread = [np.broadcast_to(values, (motion.frames, 3)) for values in still]
        above = scene.parents.get(key)
        hold = None if above is None else (worlds[above], locals_[above])
        inherit = model.integer("InheritType")
        found[key] = Said(still)
        if key in index:
            j = index[key]
            local = _placed((pose.positions[:, j], pose.rotations[:, j]), spread[2], hold, inherit, model.name)
            translation, turn = animated_values(model, local)
            degrees = continuous_degrees(turn[:, None], rotation_order(model))[:, 0]
            found[key] = Said(still, translation, degrees)
        else:
            local = local_transform(model, *spread)
        locals_[key] = local
        worlds[key] = _world(local, hold, inherit)
    return found


def _world(local: Local, hold: tuple[World, Local] | None, inherit: int) -> World:
    parent, above = hold or (None, None)
    return world_transform(local, parent, above, inherit)


def _placed(
    target: tuple[Array, Array], scale: Array, hold: tuple[World, Local] | None, inherit: int, name: str
) -> Local:
    """The local frame that puts a joint at a world position (F, 3) with a world rotation (F, 4).

    Under even scale the first guess is exact. Uneven scale shears, and the reader sees the nearest rotation, so the
    guess is turned by what is left until nothing is.
    """
    position, rotation = target
    base: Array = np.broadcast_to(np.eye(3), (len(position), 3, 3))
    if hold is not None:
        base = _base(hold[0], inherit)
        try:
            back = np.linalg.inv(hold[0].matrix)
        except np.linalg.LinAlgError:
            raise FormatError(f"Expected scales other than 0 above joint {name!r}, got 0. Bake the scale.") from None
        position = np.einsum("nij,nj->ni", back, position - hold[0].position)
    wanted = quat_to_matrix(rotation)
    turn: Array = np.swapaxes(base, -1, -2) @ wanted
    turn[..., 0] *= np.sign(np.linalg.det(base))[:, None]
    for _ in range(_ROUNDS):
        local = Local(position, matrix_to_quat(turn), scale)
        seen = _world(local, hold, inherit).rotation()
        gap = float(np.abs(quat_distance(seen, rotation)).max())
        if gap < _CLOSE:
            return local
        left = wanted @ np.swapaxes(quat_to_matrix(seen), -1, -2)
        turn = np.swapaxes(base, -1, -2) @ left @ base @ turn
    if gap > _FAR:
        raise FormatError(f"Expected even scale, got a scale that shears joint {name!r} too far. Bake the scale.")
    return local


def _base(parent: World, inherit: int) -> Array:
    """The orthogonal frame (F, 3, 3), maybe mirrored, in which a joint on this parent turns."""
    turn = quat_to_matrix(parent.turn)
    if inherit != 1 or np.abs(turn - parent.matrix).max() < 1e-9:
        return turn
    u, _, v = np.linalg.svd(parent.matrix)
    return u @ v
