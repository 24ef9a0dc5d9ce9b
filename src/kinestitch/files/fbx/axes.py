"""A file's world, with its own axes and unit, and ours: metres, Y up, right-handed. Both ways."""

from __future__ import annotations

import numpy as np

from kinestitch.core.rotation import Array, matrix_to_quat, quat_conjugate, quat_multiply

_MIRROR = np.diag([-1.0, 1.0, 1.0])
_MOVES, _TURNS = np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0, 1.0])


def to_y_up_metres(translations: Array, rotations: Array, axes: Array, unit: float) -> tuple[Array, Array]:
    """Local poses (N, J, ·) of a file's world told in metres with Y up.

    axes : (3, 3) orthogonal; a reflection mirrors every joint's frame as well, so that frames stay right-handed
    """
    translations, rotations = translations * unit, rotations.copy()
    turn = axes
    if np.linalg.det(axes) < 0:
        turn = axes @ _MIRROR
        translations = translations * _MOVES
        rotations = rotations * _TURNS
    if not np.array_equal(turn, np.eye(3)):
        quat = matrix_to_quat(turn)
        translations[..., 0, :] = translations[..., 0, :] @ turn.T
        rotations[..., 0, :] = quat_multiply(quat, rotations[..., 0, :])
    return translations, rotations


def from_y_up_metres(translations: Array, rotations: Array, axes: Array, unit: float) -> tuple[Array, Array]:
    """The same local poses (N, J, ·) told in the file's own world again; `axes` and `unit` as above."""
    translations, rotations = translations / unit, rotations.copy()
    turn = axes @ _MIRROR if np.linalg.det(axes) < 0 else axes
    if not np.array_equal(turn, np.eye(3)):
        translations[..., 0, :] = translations[..., 0, :] @ turn
        rotations[..., 0, :] = quat_multiply(quat_conjugate(matrix_to_quat(turn)), rotations[..., 0, :])
    if np.linalg.det(axes) < 0:
        translations, rotations = translations * _MOVES, rotations * _TURNS
    return translations, rotations
