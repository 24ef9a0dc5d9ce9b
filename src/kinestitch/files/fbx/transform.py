"""Where a model stands: offsets, pivots, pre- and post-rotation, scale, and the three ways to inherit it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import (
    Array,
    euler_to_quat,
    matrix_to_quat,
    quat_conjugate,
    quat_continuous,
    quat_identity,
    quat_multiply,
    quat_normalize,
    quat_rotate,
    quat_to_euler,
    quat_to_matrix,
)
from kinestitch.errors import FormatError
from kinestitch.files.fbx.scene import Model

# FBX names the axis that turns first; read as a product of rotating axes the order is the other way round
ORDERS = ("ZYX", "YZX", "XZY", "ZXY", "YXZ", "XYZ", "ZYX")
_LARGEST = 1e100
UNIT_SCALE = 2e-6  # a scale this near 1 moves a joint one metre away by two micrometres


@dataclass(frozen=True, slots=True, eq=False)
class Local:
    """A model in its parent's frame over N frames: translation (N, 3), rotation (N, 4), scale (N, 3)."""

    translation: Array
    rotation: Array
    scale: Array

    @property
    def rigid(self) -> bool:
        """Whether the scale is 1 throughout."""
        return bool(np.abs(self.scale - 1.0).max(initial=0.0) < UNIT_SCALE)


def order_name(order: int) -> str:
    """The order of rotation as a product of rotating axes; unknown ones count as XYZ, as everywhere else."""
    return ORDERS[order] if 0 <= order < len(ORDERS) else ORDERS[0]


def euler_quat(degrees: Array, order: int) -> Array:
    """Quaternions (..., 4) of FBX Euler angles (..., 3) in degrees, x y z whatever the order of rotation."""
    name = order_name(order)
    angles = np.radians(degrees)
    return euler_to_quat(angles[..., ["XYZ".index(letter) for letter in name]], name)


def quat_degrees(q: Array, order: int) -> Array:
    """FBX Euler angles (..., 3) in degrees, x y z whatever the order of rotation, of quaternions (..., 4)."""
    name = order_name(order)
    angles = np.empty((*q.shape[:-1], 3))
    angles[..., ["XYZ".index(letter) for letter in name]] = quat_to_euler(q, name)
    return np.degrees(angles)


def local_transform(model: Model, translation: Array, degrees: Array, scale: Array) -> Local:
    """The model's local frame from its animated translation, Euler angles (degrees) and scale, each (N, 3)."""
    before, after = _turns_around(model)
    turn = quat_multiply(before, quat_multiply(euler_quat(degrees, rotation_order(model)), quat_conjugate(after)))
    turn = quat_normalize(turn)
    return Local(translation + _pivot_shift(model, turn, scale), turn, scale)


def animated_values(model: Model, local: Local) -> tuple[Array, Array]:
    """The other way round: the translation (N, 3) that makes the model stand like `local`, and the rotation (N, 4)
    that its Euler angles have to give.
    """
    before, after = _turns_around(model)
    turn = quat_multiply(quat_conjugate(before), quat_multiply(local.rotation, after))
    return local.translation - _pivot_shift(model, local.rotation, local.scale), quat_normalize(turn)


def rotation_order(model: Model) -> int:
    """The model's order of rotation, which counts only where RotationActive is set."""
    return model.integer("RotationOrder") if model.integer("RotationActive") else 0


def _turns_around(model: Model) -> tuple[Array, Array]:
    """Quaternions (4,) of pre- and post-rotation."""
    if not model.integer("RotationActive"):
        return quat_identity(), quat_identity()
    return euler_quat(model.vector("PreRotation"), 0), euler_quat(model.vector("PostRotation"), 0)


def _pivot_shift(model: Model, turn: Array, scale: Array) -> Array:
    """What pivots and offsets add to the animated translation: (3,) or (N, 3)."""
    spin, stretch = model.vector("RotationPivot"), model.vector("ScalingPivot")
    inner = -spin + model.vector("ScalingOffset") + stretch - scale * stretch
    shift = model.vector("RotationOffset") + spin
    return shift + quat_rotate(turn, inner) if np.any(inner) else shift


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A model in the file's world: position (N, 3), whole matrix (N, 3, 3), product of rotations (N, 4)."""

    position: Array
    matrix: Array
    turn: Array

    def rotation(self) -> Array:
        """World rotation (N, 4) without scale and shear."""
        size = np.linalg.norm(self.matrix, axis=-2, keepdims=True)
        if (size > 0).all():
            plain = self.matrix / size
            square = np.swapaxes(plain, -1, -2) @ plain
            if np.abs(square - np.eye(3)).max(initial=0.0) < 1e-9 and (np.linalg.det(plain) > 0).all():
                return quat_continuous(matrix_to_quat(plain))
        return nearest_rotation(self.matrix)


def nearest_rotation(matrices: Array) -> Array:
    """Quaternions (N, 4) nearest to matrices (N, 3, 3); a mirrored frame gets its x axis turned back."""
    if not np.isfinite(matrices).all() or np.abs(matrices).max(initial=0.0) > _LARGEST:
        raise FormatError("Expected finite scales, got infinite ones. Export the clip again.")
    u, _, v = np.linalg.svd(matrices)
    nearest = u @ v
    nearest[np.linalg.det(nearest) < 0, :, 0] *= -1
    return quat_continuous(matrix_to_quat(nearest))


def world_transform(local: Local, parent: World | None, parent_local: Local | None, inherit: int) -> World:
    """Place a model on its parent.

    inherit : 0 scales after both rotations (RrSs), 1 as matrices multiply (RSrs), 2 leaves the parent's own scale out
        (Rrs)
    """
    turn = quat_to_matrix(local.rotation)
    if parent is None or parent_local is None:
        return World(local.translation, turn * local.scale[:, None, :], local.rotation)
    position = parent.position + np.einsum("nij,nj->ni", parent.matrix, local.translation)
    whole = quat_multiply(parent.turn, local.rotation)
    if inherit == 1:
        return World(position, parent.matrix @ (turn * local.scale[:, None, :]), whole)
    base = quat_to_matrix(parent.turn)
    stretch = np.swapaxes(base, -1, -2) @ parent.matrix
    if inherit == 2:
        stretch = stretch / np.where(parent_local.scale == 0, 1.0, parent_local.scale)[:, None, :]
    return World(position, base @ turn @ stretch * local.scale[:, None, :], whole)
